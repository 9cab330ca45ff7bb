"""Packets on the byte stream, each beginning with its own length, and the layouts of their members.

Source: emScon SDK 3.6, C header: `lPacketSize` (i32, whole packet) and `type` (u32), little endian.

A layout such as ``"f64 val1 val2; bool use_adm; LengthUnit unit"`` lists kinds and members in wire order.
Kinds are `i32`, `u8` (padded to 4 bytes), `f64`, `bool` (4 bytes), `text32` and `text128` (UTF-16LE, zero
padded), or an enumeration of the header (4 bytes), of which those that nobody here reads or sets are `i32`.
Members carry the header's names in snake case without their type prefix, so that its manual still helps.
Structures are packed to 4 bytes: no hidden padding.
"""

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Self, TypeAlias

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.framing import StreamReader
from truepose_drivers.leica_emscon.protocol import equipment, settings, statuses

_HEADER = struct.Struct("<iI")
SHORTEST_PACKET_BYTES = 12  # no packet of the protocol is shorter than its header and one member
LONGEST_PACKET_BYTES = 65_536  # known clients treat anything longer as a lost byte count


class PacketError(RemoteProtocolError):
    """The other side sent bytes that are no emScon packet."""


class PacketType(IntEnum):
    """Second word of a packet."""

    COMMAND = 0  # a request and its answer share the number; the direction tells them apart
    ERROR = 1
    SINGLE_MEAS_RESULT = 2
    MULTI_MEAS_RESULT = 3
    STATIONARY_PROBE_MEAS_RESULT = 4
    CONTINUOUS_PROBE_MEAS_RESULT = 5
    NIVEL_RESULT = 6
    REFLECTOR_POS_RESULT = 7
    SYSTEM_STATUS_CHANGE = 8
    SINGLE_MEAS_RESULT_2 = 9
    MULTI_MEAS_RESULT_2 = 10
    PROBE_POS_RESULT = 11


@dataclass(frozen=True, slots=True)
class Frame:
    """One whole packet, header included."""

    packet_type: int
    data: bytes


def frame(packet_type: PacketType, body: bytes) -> bytes:
    """Return `body` as a packet of that type; raises ValueError when it is too long."""
    size = _HEADER.size + len(body)
    if size > LONGEST_PACKET_BYTES:
        raise ValueError(f"a packet of {size} bytes is longer than {LONGEST_PACKET_BYTES}: split it")
    return _HEADER.pack(size, packet_type) + body


class FrameReader(StreamReader):
    """Reassembles packets from a byte stream; serves both sides of the wire."""

    def next_message(self) -> Frame | None:
        """Take the oldest whole packet, or None until more bytes arrive.

        Raises PacketError when the stream holds no packet; it cannot be read any further then.
        """
        if len(self._buffer) < _HEADER.size:
            return None
        size, packet_type = _HEADER.unpack_from(self._buffer)
        # Packets have neither a mark nor a checksum: once a length is wrong, nothing tells where the next one
        # begins.
        if not SHORTEST_PACKET_BYTES <= size <= LONGEST_PACKET_BYTES:
            raise PacketError(
                f"the stream announces a packet of {size} bytes; emScon packets have"
                f" {SHORTEST_PACKET_BYTES} to {LONGEST_PACKET_BYTES}: is this the tracker's port?"
            )
        if len(self._buffer) < size:
            return None
        return Frame(packet_type, self._take(size))


Value: TypeAlias = int | float | str


class Record(dict[str, Value]):
    """Members of a packet by name."""

    def number(self, name: str) -> float:
        """Return a member as float; raises PacketError when it is text."""
        value = self[name]
        if isinstance(value, str):
            raise PacketError(f"member {name} is text ({value!r}), expected a number")
        return float(value)

    def integer(self, name: str) -> int:
        """Return an integer, boolean or enumeration; raises PacketError for anything else."""
        value = self[name]
        if not isinstance(value, int):
            raise PacketError(f"member {name} is {value!r}, expected an integer")
        return value

    def text(self, name: str) -> str:
        """Return a member as text; raises PacketError when it is a number."""
        value = self[name]
        if not isinstance(value, str):
            raise PacketError(f"member {name} is {value!r}, expected text")
        return value

    def vector(self, *names: str) -> tuple[float, float, float]:
        """Return three numbers, by default the coordinates val1 val2 val3."""
        first, second, third = names or ("val1", "val2", "val3")
        return self.number(first), self.number(second), self.number(third)


@dataclass(frozen=True, slots=True)
class _Kind:
    code: str
    to_wire: Callable[[Value], int | float | bytes]
    from_wire: Callable[[int | float | bytes], Value]
    zero: Value


@dataclass(frozen=True, slots=True)
class Layout:
    """Members in wire order, with the compiled format."""

    members: tuple[tuple[str, _Kind], ...]
    packer: struct.Struct

    @classmethod
    def of(cls, text: str) -> Self:
        """Compile a layout; raises ValueError for an unknown kind."""
        members = []
        for group in filter(None, text.split(";")):
            kind, *names = group.split()
            members += [(name, _kind(kind)) for name in names]
        return cls(tuple(members), struct.Struct("<" + "".join(kind.code for _, kind in members)))

    @property
    def size(self) -> int:
        """Length on the wire [bytes]."""
        return self.packer.size

    @property
    def names(self) -> tuple[str, ...]:
        """Members in wire order."""
        return tuple(name for name, _ in self.members)

    def zeros(self) -> Record:
        """Return a record with every member zero or empty."""
        return Record({name: kind.zero for name, kind in self.members})

    def pack(self, values: Mapping[str, Value]) -> bytes:
        """Return the bytes of all members; raises ValueError for a missing, unknown or unfitting one."""
        if len(values) != len(self.members) or any(name not in values for name in self.names):
            raise ValueError(f"members {sorted(values)} given, {list(self.names)} needed")
        try:
            return self.packer.pack(*(kind.to_wire(values[name]) for name, kind in self.members))
        except (struct.error, TypeError, OverflowError) as error:
            raise ValueError(
                f"{dict(values)} does not fit the members {list(self.names)}: {error}"
            ) from error

    def unpack(self, data: bytes, offset: int = 0) -> Record:
        """Return the members found at `offset`; raises PacketError when `data` is too short."""
        if len(data) < offset + self.size:
            raise PacketError(f"a packet of {len(data)} bytes should have {offset + self.size}")
        raw = self.packer.unpack_from(data, offset)
        return Record({
            name: kind.from_wire(value) for (name, kind), value in zip(self.members, raw, strict=True)
        })


def _kind(name: str) -> _Kind:
    if name in {"text32", "text128"}:
        return _text_kind(int(name.removeprefix("text")))
    if name in _SCALARS:
        return _SCALARS[name]
    for module in (settings, equipment, statuses):
        enumeration = getattr(module, name, None)
        if enumeration is not None:
            return _enumeration_kind(enumeration)
    raise ValueError(f"{name!r} is not a type of packet member")


def _text_kind(length: int) -> _Kind:
    def to_wire(value: Value) -> bytes:
        encoded = str(value).encode("utf-16-le")
        if len(encoded) > 2 * length:
            raise ValueError(f"{value!r} is longer than {length} UTF-16 units")
        return encoded

    return _Kind(f"{2 * length}s", to_wire, _decode_text, "")


def _decode_text(raw: int | float | bytes) -> str:
    if not isinstance(raw, bytes):
        raise TypeError("text members are bytes on the wire")
    # A lone surrogate from a broken name must not hide the number beside it, hence "replace".
    return raw.decode("utf-16-le", errors="replace").split("\0", 1)[0]


def _enumeration_kind(enumeration: type[IntEnum]) -> _Kind:
    known = {int(member): member for member in enumeration}

    def from_wire(raw: int | float | bytes) -> Value:
        # Newer firmware may know more: an unknown number stays a plain integer.
        number = _decode_integer(raw)
        return known.get(number, number)

    return _Kind("i", _encode_integer, from_wire, known.get(0, 0))


def _encode_integer(value: Value) -> int:
    if not isinstance(value, int):
        raise TypeError(f"{value!r} is not an integer")
    return value


def _decode_integer(raw: int | float | bytes) -> int:
    if not isinstance(raw, int):
        raise TypeError("integer members are integers on the wire")
    return raw


def _encode_number(value: Value) -> float:
    if isinstance(value, str):
        raise TypeError(f"{value!r} is not a number")
    return float(value)


def _decode_number(raw: int | float | bytes) -> float:
    if not isinstance(raw, float):
        raise TypeError("f64 members are floats on the wire")
    return raw


_SCALARS: Mapping[str, _Kind] = {
    "i32": _Kind("i", _encode_integer, _decode_integer, 0),
    "u8": _Kind("B3x", _encode_integer, _decode_integer, 0),
    "bool": _Kind("i", lambda value: int(bool(value)), bool, False),
    "f64": _Kind("d", _encode_number, _decode_number, 0.0),
}
