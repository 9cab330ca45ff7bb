"""RTDE packets: size, kind, payload, all big endian; protocol version 2. Source: maker's RTDE guide."""

import struct
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from truepose_drivers.stream_reader import StreamReader
from truepose_drivers.universal_robots.protocol.errors import UrProtocolError

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
            raise UrProtocolError(f"{bytes(self._buffer[:12])!r} begins no RTDE packet")
        if len(self._buffer) < size:
            return None
        return Packet(Kind(kind), self._take(size)[_HEADER.size :])


def encode(packet: Packet) -> bytes:
    """Return a packet as it goes over the wire."""
    return _HEADER.pack(_HEADER.size + len(packet.payload), packet.kind) + packet.payload


def version_request(version: int = PROTOCOL_VERSION) -> Packet:
    """Ask for a version of the protocol."""
    return Packet(Kind.VERSION, _VERSION.pack(version))


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


def said(payload: bytes) -> str:
    """Return what the controller says to people."""
    length = payload[0] if payload else 0
    if len(payload) < length + 1 or not payload:
        raise UrProtocolError(f"{payload[:40]!r} is no text of the controller")
    return payload[1 : length + 1].decode(errors="replace")


def words(payload: bytes) -> list[str]:
    """Return the names of a list, behind which some clients put one more comma; raises UrProtocolError."""
    try:
        return payload.decode("ascii").removesuffix(",").split(",")
    except UnicodeDecodeError as error:
        raise UrProtocolError(f"{payload[:40]!r} is no list of names") from error


def _listed(names: Iterable[str]) -> bytes:
    return ",".join(names).encode("ascii")


def _fixed(layout: struct.Struct, payload: bytes, what: str) -> tuple[float, ...]:
    if len(payload) != layout.size:
        raise UrProtocolError(f"{payload[:40]!r} is not {what}")
    return layout.unpack(payload)
