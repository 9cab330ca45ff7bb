"""What goes over a Universal Robots controller's ports, RTDE and dashboard; no socket, no clock.

RTDE packets are size, kind and payload, all big endian; protocol version 2. The dashboard has questions and
answers of a line each, after a greeting. Source: the maker's guides of RTDE and of the dashboard.
"""

import math
import re
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Final, TypeAlias

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.framing import StreamReader


class UrProtocolError(RemoteProtocolError):
    """Bytes that are no message of this protocol, or not the one that was due."""


RTDE_PORT: Final = 30004
PROTOCOL_VERSION: Final = 2

_HEADER = struct.Struct(">HB")  # size of the packet, this header included; kind
_VERSION = struct.Struct(">H")
_CONTROLLER = struct.Struct(">4I")  # major, minor, bug fix, build
_FREQUENCY = struct.Struct(">d")


class Kind(IntEnum):
    """What a packet is about; a reply has the kind of its request."""

    VERSION = ord("V")
    CONTROLLER = ord("v")
    TEXT = ord("M")
    OUTPUTS = ord("O")
    INPUTS = ord("I")
    START = ord("S")
    PAUSE = ord("P")
    DATA = ord("U")


@dataclass(frozen=True, slots=True)
class Packet:
    """One packet in either direction."""

    kind: Kind
    payload: bytes = b""


class PacketReader(StreamReader):
    """Reassembles packets from a byte stream; serves both sides of the wire."""

    def next_message(self) -> Packet | None:
        """Take the oldest whole packet; raises UrProtocolError as soon as a header can be none."""
        if len(self._buffer) < _HEADER.size:
            return None
        size, kind = _HEADER.unpack_from(self._buffer)
        if size < _HEADER.size or kind not in Kind.__members__.values():
            raise UrProtocolError(f"{bytes(self._buffer[:12])!r} is not the start of an RTDE packet")
        if len(self._buffer) < size:
            return None
        return Packet(Kind(kind), self._take(size)[_HEADER.size :])


def encode(packet: Packet) -> bytes:
    """Return a packet as it goes over the wire."""
    return _HEADER.pack(_HEADER.size + len(packet.payload), packet.kind) + packet.payload


def version_request() -> Packet:
    """Ask for our version of the protocol."""
    return Packet(Kind.VERSION, _VERSION.pack(PROTOCOL_VERSION))


def requested_version(payload: bytes) -> int:
    """Return which version is asked for."""
    (version,) = _fixed(_VERSION, payload, "a version")
    return int(version)


def verdict(kind: Kind, *, accepted: bool) -> Packet:
    """Answer to a request that is answered with yes or no."""
    return Packet(kind, bytes([accepted]))


def is_accepted(payload: bytes) -> bool:
    """Whether the answer was yes; raises UrProtocolError where it was neither."""
    if payload not in {b"\x00", b"\x01"}:
        raise UrProtocolError(f"{payload[:12]!r} is neither yes nor no")
    return payload == b"\x01"


def controller_version(numbers: tuple[int, int, int, int]) -> Packet:
    """State the controller's software."""
    return Packet(Kind.CONTROLLER, _CONTROLLER.pack(*numbers))


def stated_version(payload: bytes) -> str:
    """Return the controller's software, such as "5.11.0.108249"."""
    return ".".join(map(str, _fixed(_CONTROLLER, payload, "a controller's version")))


def outputs_request(frequency_hz: float, names: Iterable[str]) -> Packet:
    """Ask for fields, so many times a second."""
    return Packet(Kind.OUTPUTS, _FREQUENCY.pack(frequency_hz) + _listed(names))


def requested_outputs(payload: bytes) -> tuple[float, list[str]]:
    """Return how often [1/s] and which fields are asked for."""
    head = payload[: _FREQUENCY.size]
    (frequency_hz,) = _fixed(_FREQUENCY, head, "a frequency")
    return float(frequency_hz), words(payload[_FREQUENCY.size :])


def inputs_request(names: Iterable[str]) -> Packet:
    """Ask to write fields."""
    return Packet(Kind.INPUTS, _listed(names))


def recipe_reply(kind: Kind, number: int, types: Iterable[str]) -> Packet:
    """Give fields that were asked for a number, and name their types."""
    return Packet(kind, bytes([number]) + _listed(types))


def recipe_stated(payload: bytes) -> tuple[int, list[str]]:
    """Return the number and the types of the fields that were asked for."""
    if not payload:
        raise UrProtocolError("an empty answer names no types")
    return payload[0], words(payload[1:])


def text_message(message: str, source: str, level: int) -> Packet:
    """Say something to people: exception 0, error 1, warning 2, information 3."""
    parts = [message.encode(errors="replace")[:255], source.encode(errors="replace")[:255]]
    return Packet(Kind.TEXT, b"".join(bytes([len(part)]) + part for part in parts) + bytes([level]))


def operator_message(payload: bytes) -> str:
    """Return what the controller says to people."""
    length = payload[0] if payload else 0
    if len(payload) < length + 1 or not payload:
        raise UrProtocolError(f"{payload[:40]!r} is not text from the controller")
    return payload[1 : length + 1].decode(errors="replace")


def words(payload: bytes) -> list[str]:
    """Return the names of a list, behind which some clients put one more comma; raises UrProtocolError."""
    try:
        return payload.decode("ascii").removesuffix(",").split(",")
    except UnicodeDecodeError as error:
        raise UrProtocolError(f"{payload[:40]!r} is not a list of names") from error


def _listed(names: Iterable[str]) -> bytes:
    return ",".join(names).encode("ascii")


def _fixed(layout: struct.Struct, payload: bytes, what: str) -> tuple[float, ...]:
    if len(payload) != layout.size:
        raise UrProtocolError(f"{payload[:40]!r} is not {what}")
    return layout.unpack(payload)


Values: TypeAlias = Mapping[str, tuple[float, ...]]  # of single numbers tuples of one

NOT_FOUND: Final = "NOT_FOUND"  # in the place of a type: the controller does not know that field
IN_USE: Final = "IN_USE"  # another client writes it

# Format and count of each type; RTDE guide, "Data types".
_TYPES: Final[Mapping[str, tuple[str, int]]] = {
    "BOOL": ("?", 1),
    "UINT8": ("B", 1),
    "UINT32": ("I", 1),
    "UINT64": ("Q", 1),
    "INT32": ("i", 1),
    "DOUBLE": ("d", 1),
    "VECTOR3D": ("d", 3),
    "VECTOR6D": ("d", 6),
    "VECTOR6INT32": ("i", 6),
    "VECTOR6UINT32": ("I", 6),
}


@dataclass(frozen=True, slots=True)
class Recipe:
    """Fields and their types under the number that the controller gave them."""

    number: int
    fields: Mapping[str, str]

    def pack(self, values: Values) -> Packet:
        """Return the data packet of values; raises KeyError where a field has none."""
        numbers = [_written(kind, number) for name, kind in self.fields.items() for number in values[name]]
        return Packet(Kind.DATA, bytes([self.number]) + self._layout.pack(*numbers))

    def unpack(self, payload: bytes) -> dict[str, tuple[float, ...]]:
        """Return the values of a data packet; raises UrProtocolError where it is none of this recipe."""
        if len(payload) != self._layout.size + 1 or payload[0] != self.number:
            raise UrProtocolError(
                f"a data packet of {len(payload)} bytes for recipe {payload[:1].hex() or 'none'}; expected"
                f" {self._layout.size + 1} bytes for recipe {self.number:02x}"
            )
        numbers = iter(self._layout.unpack(payload[1:]))
        values = {
            name: tuple(next(numbers) for _ in range(_TYPES[kind][1])) for name, kind in self.fields.items()
        }
        _require_finite(values)
        return values

    @property
    def _layout(self) -> struct.Struct:
        return struct.Struct(
            ">" + "".join(_TYPES[kind][0] * _TYPES[kind][1] for kind in self.fields.values())
        )


def agreed_recipe(number: int, types: Iterable[str], wanted: Mapping[str, str]) -> Recipe:
    """Return the recipe of fields with the types that were expected; raises UrProtocolError."""
    stated = list(types)
    if stated != list(wanted.values()):
        raise UrProtocolError(
            f"types {','.join(stated)[:120]} were reported; expected {','.join(wanted.values())}"
        )
    return Recipe(number, wanted)


def _written(kind: str, number: float) -> float:
    return number if _TYPES[kind][0] == "d" else int(number)


def _require_finite(values: Values) -> None:
    for name, numbers in values.items():
        if not all(map(math.isfinite, numbers)):
            raise UrProtocolError(f"field {name} is {numbers}: no numbers")


DASHBOARD_PORT: Final = 29999
GREETING: Final = "Connected: Universal Robots Dashboard Server"
SERIAL_NUMBER: Final = "get serial number"
ROBOT_MODEL: Final = "get robot model"

_LONGEST_LINE_BYTES = 1000
_NOT_UNDERSTOOD = "could not understand"
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 ._/-]{0,39}")


class LineReader(StreamReader):
    """Reassembles lines; serves both sides of the wire."""

    def next_message(self) -> str | None:
        """Take the oldest whole line; raises UrProtocolError where one does not end."""
        end = self._buffer.find(b"\n")
        if max(end, len(self._buffer) if end < 0 else 0) > _LONGEST_LINE_BYTES:
            raise UrProtocolError(f"{bytes(self._buffer[:40])!r} has no line end")
        if end < 0:
            return None
        return self._take(end, drop=1).decode(errors="replace").strip()


def encode_line(line: str) -> bytes:
    """Return a line as it goes over the wire."""
    return f"{line}\n".encode()


def require_greeting(line: str) -> None:
    """Raise UrProtocolError unless a dashboard speaks."""
    if not line.startswith(GREETING):
        raise UrProtocolError(f"{line[:60]!r} is not an answer from a Universal Robots dashboard")


def stated_name(line: str) -> str | None:
    """Return a serial number or model, None where this software does not know the question."""
    if _NOT_UNDERSTOOD in line.lower():
        return None
    if _NAME.fullmatch(line) is None:
        raise UrProtocolError(f"the dashboard answered with {line[:60]!r}, which is not a name")
    return line
