"""Packets on the byte stream: every one begins with its own length, nothing marks its end.

Source: emScon SDK 3.6, C header: `lPacketSize` (i32, whole packet) and `type` (u32), little endian.
"""

import struct
from dataclasses import dataclass
from enum import IntEnum

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.stream_reader import StreamReader

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
        if not SHORTEST_PACKET_BYTES <= size <= LONGEST_PACKET_BYTES:
            raise PacketError(
                f"the stream announces a packet of {size} bytes; emScon packets have"
                f" {SHORTEST_PACKET_BYTES} to {LONGEST_PACKET_BYTES}: is this the tracker's port?"
            )
        if len(self._buffer) < size:
            return None
        return Frame(packet_type, self._take(size))
