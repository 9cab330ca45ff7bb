"""The few messages of ABB's EGM that are spoken here, as protocol buffers (proto2): bytes in, messages out.

Field numbers are those of the maker's descriptor, package `abb.egm`. One message is one datagram; angles are
in degrees. What is not needed is skipped.
"""

import math
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final, TypeAlias, TypeVar

from truepose_drivers.errors import RemoteProtocolError

EGM_PORT: Final = 6510
JOINTS: Final = 6
COUNTED_TO: Final = 1 << 32  # sequence numbers and times begin anew there
_FURTHEST_DEG: Final = 3600.0  # no joint is wound up further
_LONGEST_VARINT_BYTES: Final = 10
_VARINT, _DOUBLE, _BYTES, _FLOAT = 0, 1, 2, 5  # wire types

Value: TypeAlias = int | bytes  # of a varint, else as it stands


class EgmProtocolError(RemoteProtocolError):
    """The other side sent what is no message of EGM."""


class MessageKind(IntEnum):
    """What a message is, as its header says."""

    UNDEFINED = 0
    COMMAND = 1
    DATA = 2  # from the robot
    CORRECTION = 3  # to the robot
    PATH_CORRECTION = 4


class Motors(IntEnum):
    """Whether the motors are on."""

    UNDEFINED = 0
    ON = 1
    OFF = 2


class Rapid(IntEnum):
    """Whether the RAPID program runs."""

    UNDEFINED = 0
    STOPPED = 1
    RUNNING = 2


State = TypeVar("State", Motors, Rapid)


@dataclass(frozen=True, slots=True)
class RobotFrame:
    """What a robot says of itself at one time."""

    sequence: int
    time_ms: int  # of the controller
    joints_deg: tuple[float, ...]  # measured
    planned_deg: tuple[float, ...] = ()
    motors: Motors = Motors.UNDEFINED
    rapid: Rapid = Rapid.UNDEFINED

    def follows(self, before: "RobotFrame") -> bool:
        """Whether it is newer, by its number and by its time."""
        # By both: a stream that goes on counting while its clock stands repeats an old place.
        return _is_later(self.sequence, before.sequence) and _is_later(self.time_ms, before.time_ms)


def decode_robot(data: bytes) -> RobotFrame:
    """Read an EgmRobot; raises EgmProtocolError."""
    message = _message(data)
    header = _message(_part(message, 1))
    if _number(header, 3) != MessageKind.DATA:
        raise EgmProtocolError(f"a datagram of kind {_number(header, 3)} does not come from a robot")
    return RobotFrame(
        sequence=_number(header, 1),
        time_ms=_number(header, 2),
        joints_deg=_six(_joints(_part(message, 2))),
        planned_deg=_joints(_part(message, 3)),
        motors=_one_of(Motors, _part(message, 4)),
        rapid=_one_of(Rapid, _part(message, 8)),
    )


def encode_robot(frame: RobotFrame) -> bytes:
    """Return an EgmRobot."""
    header = (
        _varint_field(1, frame.sequence)
        + _varint_field(2, frame.time_ms)
        + _varint_field(3, MessageKind.DATA)
    )
    parts = [
        (1, header),
        (2, _bytes_field(1, _doubles(frame.joints_deg))),
        (3, _bytes_field(1, _doubles(frame.planned_deg))),
        (4, _varint_field(1, frame.motors)),
        (8, _varint_field(1, frame.rapid)),
    ]
    return b"".join(_bytes_field(number, part) for number, part in parts)


def _is_later(number: int, before: int) -> bool:
    # Milliseconds in 32 bits begin anew after 50 days, and a controller may run for longer.
    return 0 < (number - before) % COUNTED_TO < COUNTED_TO // 2


def _six(joints_deg: tuple[float, ...]) -> tuple[float, ...]:
    if len(joints_deg) != JOINTS or any(abs(angle) > _FURTHEST_DEG for angle in joints_deg):
        raise EgmProtocolError(f"the robot reports joints at {joints_deg} deg")
    return joints_deg


def _joints(part: bytes) -> tuple[float, ...]:
    """Return the angles in EgmPlanned or EgmFeedBack, none where it has none."""
    angles: list[float] = []
    for value in _message(_part(_message(part), 1)).get(1, []):
        if not isinstance(value, bytes) or len(value) % 8:
            raise EgmProtocolError("an angle is not a double")
        angles += struct.unpack(f"<{len(value) // 8}d", value)  # one, or packed
    if not all(map(math.isfinite, angles)):
        raise EgmProtocolError(f"the robot reports {angles} deg")
    return tuple(angles)


def _one_of(kind: type[State], part: bytes) -> State:
    number = _number(_message(part), 1)
    try:
        return kind(number)
    except ValueError as error:
        raise EgmProtocolError(f"{number} is not a state of the {kind.__name__.lower()}") from error


def _number(message: dict[int, list[Value]], field: int) -> int:
    """Return a field's number, 0 where it is missing; the last one counts."""
    value = message.get(field, [0])[-1]
    if not isinstance(value, int):
        raise EgmProtocolError(f"field {field} is not a number")
    return value % COUNTED_TO


def _part(message: dict[int, list[Value]], field: int) -> bytes:
    """Return a field's message, an empty one where it is missing; the last one counts."""
    value = message.get(field, [b""])[-1]
    if not isinstance(value, bytes):
        raise EgmProtocolError(f"field {field} is not a message")
    return value


def _message(data: bytes) -> dict[int, list[Value]]:
    found: dict[int, list[Value]] = {}
    for number, value in _fields(data):
        found.setdefault(number, []).append(value)
    return found


def _fields(data: bytes) -> Iterator[tuple[int, Value]]:
    at = 0
    while at < len(data):
        key, at = _varint(data, at)
        length = {_DOUBLE: 8, _FLOAT: 4}.get(key & 7, 0)
        if key & 7 == _VARINT:
            value, at = _varint(data, at)
            yield key >> 3, value
            continue
        if key & 7 == _BYTES:
            length, at = _varint(data, at)
        elif not length:
            raise EgmProtocolError(f"{key & 7} is not a field type")
        if at + length > len(data):
            raise EgmProtocolError("a field extends beyond the end of its message")
        yield key >> 3, data[at : at + length]
        at += length


def _varint(data: bytes, at: int) -> tuple[int, int]:
    number = 0
    for place, byte in enumerate(data[at : at + _LONGEST_VARINT_BYTES]):
        number |= (byte & 0x7F) << (7 * place)
        if byte < 0x80:
            return number, at + place + 1
    raise EgmProtocolError("a number has no end")


def _varint_field(field: int, value: int) -> bytes:
    return _encoded(field << 3 | _VARINT) + _encoded(value % COUNTED_TO)


def _bytes_field(field: int, value: bytes) -> bytes:
    return _encoded(field << 3 | _BYTES) + _encoded(len(value)) + value


def _doubles(angles: Sequence[float]) -> bytes:
    return b"".join(_encoded(1 << 3 | _DOUBLE) + struct.pack("<d", angle) for angle in angles)


def _encoded(value: int) -> bytes:
    if value < 0x80:
        return bytes([value])
    return bytes([value & 0x7F | 0x80]) + _encoded(value >> 7)
