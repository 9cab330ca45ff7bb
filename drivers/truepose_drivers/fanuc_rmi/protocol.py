"""Wire protocol of FANUC's Remote Motion Interface (RMI): packets, what they say, and why it refuses.

Source: the packet definitions of FANUC's own public driver, which follow the operator's manual B-84184EN/03.
A packet names itself under one of three keys: what concerns the session, a command that is carried out at
once, or an instruction that is queued behind those before it. A reply has key and name of its request.

Wire units: mm, degrees, milliseconds, percent, joints as the controller counts (see `arm_options`).

Source of the refusals: the table of FANUC's own public driver; 7004 and 7015 as seen on a controller by its
users.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.framing import LineReader, decode_object, finite_number


class RmiProtocolError(RemoteProtocolError):
    """The other side sent what is no packet of the Remote Motion Interface."""


class Kind(StrEnum):
    """The key under which a packet names itself."""

    SESSION = "Communication"
    COMMAND = "Command"
    INSTRUCTION = "Instruction"


@dataclass(frozen=True, slots=True)
class Packet:
    """One packet in either direction."""

    kind: Kind
    name: str
    fields: Mapping[str, object] = field(default_factory=dict)

    def number(self, name: str) -> float:
        """Return a number of the packet; raises RmiProtocolError."""
        value = finite_number(self.fields.get(name))
        if value is None:
            raise RmiProtocolError(f"{self.name} states {name} as {self.fields.get(name)!r}: not a number")
        return value

    def whole(self, name: str) -> int:
        """Return a whole number of the packet; raises RmiProtocolError."""
        value = self.number(name)
        if value != int(value):
            raise RmiProtocolError(f"{self.name} states {name} as {value!r}: not a whole number")
        return int(value)

    def part(self, name: str) -> "Packet":
        """Return an object inside the packet as one of its own; raises RmiProtocolError."""
        value = self.fields.get(name)
        if not isinstance(value, Mapping):
            raise RmiProtocolError(f"{self.name} has no {name}")
        return Packet(self.kind, f"{name} of {self.name}", value)


class PacketReader:
    """Reassembles packets from a byte stream; serves both sides of the wire."""

    def __init__(self) -> None:
        self._lines = LineReader()

    @property
    def inside_message(self) -> bool:
        """Whether more stands here than was taken."""
        return self._lines.inside_message

    def receive_data(self, data: bytes) -> None:
        """Append what the stream delivered."""
        self._lines.receive_data(data)

    def next_message(self) -> Packet | None:
        """Take the oldest whole packet, None until more arrives; raises RemoteProtocolError."""
        line = self._lines.next_message()
        return None if line is None else decode(line)


def encode(packet: Packet) -> bytes:
    """Return the line of a packet; raises ValueError when a number is not finite."""
    return json.dumps({packet.kind: packet.name, **packet.fields}, allow_nan=False).encode() + b"\r\n"


def decode(line: bytes) -> Packet:
    """Read a line without its line feed; raises RemoteProtocolError."""
    document = decode_object(line)
    kinds = [kind for kind in Kind if kind in document]
    name = document.pop(kinds[0]) if kinds else None
    if len(kinds) != 1 or not isinstance(name, str):
        raise RmiProtocolError(f"{line[:80]!r} does not name one packet of the Remote Motion Interface")
    return Packet(kinds[0], name, document)


CONNECT_PORT: Final = 16001  # where every session begins; it goes on at a port that is named there
JOINTS: Final = 6
RESOLUTION_DEG: Final = 0.001  # of joint readings
FASTEST_PERCENT: Final = 100
ERROR_NAMES: Final = ("ErrorData", *(f"ErrorData{number}" for number in range(2, 6)))  # latest first
_AXES: Final = tuple(f"J{number}" for number in range(1, 10))  # additional axes included
_FURTHEST_DEG: Final = 3600.0  # no joint is wound up further
_HIGHEST_PORT: Final = 65_535
_TAGS: Final = 2**32  # of which time tags begin anew


class Session(StrEnum):
    """What concerns the session; the last three come unasked."""

    CONNECT = "FRC_Connect"
    DISCONNECT = "FRC_Disconnect"
    TERMINATE = "FRC_Terminate"
    SYSTEM_FAULT = "FRC_SystemFault"
    ASCII_READY = "FRC_AsbnReady"


class Command(StrEnum):
    """Commands that the driver gives; they are carried out while instructions wait."""

    INITIALIZE = "FRC_Initialize"
    ABORT = "FRC_Abort"
    RESET = "FRC_Reset"
    STATUS = "FRC_GetStatus"
    ERROR_TEXTS = "FRC_ReadError"
    JOINTS = "FRC_ReadJointAngles"
    OVERRIDE = "FRC_SetOverRide"


JOINT_MOTION: Final = "FRC_JointMotionJRep"


@dataclass(frozen=True, slots=True)
class Status:
    """What a controller says of itself."""

    servo_ready: bool
    pendant_on: bool  # nothing moves by this interface then
    running: bool  # motions are taken: it was initialised and not ended since
    single_step: bool
    next_sequence: int  # number that the next instruction must have
    override_percent: int  # of every speed, as set on the pendant


@dataclass(frozen=True, slots=True)
class JointMotion:
    """A joint motion to rest at its end."""

    sequence: int
    axes_deg: tuple[float, ...]  # joints and additional axes, as the controller counts them
    speed_percent: int  # of the greatest speeds of the joints


@dataclass(frozen=True, slots=True)
class StatedAxes:
    """Where the controller says that its axes are."""

    time_ms: int
    axes_deg: tuple[float, ...]  # of joints, then of additional axes as far as they are stated

    def is_newer_than(self, other: "StatedAxes") -> bool:
        """Whether it was stated later; the controller's time begins anew after some weeks."""
        return 0 < (self.time_ms - other.time_ms) % _TAGS < _TAGS // 2


def session(name: Session, **fields: object) -> Packet:
    """Return a packet that concerns the session."""
    return Packet(Kind.SESSION, name, fields)


def command(name: Command, **fields: object) -> Packet:
    """Return a command."""
    return Packet(Kind.COMMAND, name, fields)


def reply(request: Packet, error: int = 0, fields: Mapping[str, object] | None = None) -> Packet:
    """Return the reply to a request, that of an instruction with its number."""
    number = {"SequenceID": request.fields.get("SequenceID")} if request.kind is Kind.INSTRUCTION else {}
    return Packet(request.kind, request.name, {"ErrorID": error, **number, **(fields or {})})


def error_of(answer: Packet) -> int:
    """Return why a request was refused, 0 where it was not; raises RmiProtocolError."""
    return answer.whole("ErrorID")


def handed_over(answer: Packet) -> tuple[int, str]:
    """Return the port at which the session goes on, and the version of the interface."""
    port = answer.whole("PortNumber")
    if not 1 <= port <= _HIGHEST_PORT:
        raise RmiProtocolError(f"the controller sends to port {port}, which is not a port")
    return port, f"RMI {answer.whole('MajorVersion')}.{answer.whole('MinorVersion')}"


def encode_status(status: Status) -> dict[str, object]:
    """Return the fields by which a controller states its status."""
    return {
        "ServoReady": int(status.servo_ready),
        "TPMode": int(status.pendant_on),
        "RMIMotionStatus": int(status.running),
        "ProgramStatus": 0 if status.running else 2,
        "SingleStepMode": int(status.single_step),
        "NumberUTool": 10,
        "NextSequenceID": status.next_sequence,
        "NumberUFrame": 9,
        "Override": status.override_percent,
    }


def decode_status(answer: Packet) -> Status:
    """Return what a controller says of itself; raises RmiProtocolError."""
    override = answer.whole("Override")
    if not 1 <= override <= FASTEST_PERCENT:
        raise RmiProtocolError(f"the controller reports a speed override of {override} %")
    return Status(
        servo_ready=answer.whole("ServoReady") != 0,
        pendant_on=answer.whole("TPMode") != 0,
        running=answer.whole("RMIMotionStatus") != 0,
        single_step=answer.whole("SingleStepMode") != 0,
        next_sequence=answer.whole("NextSequenceID"),
        override_percent=override,
    )


def encode_axes(axes_deg: Sequence[float]) -> dict[str, float]:
    """Return angles as they stand in a packet."""
    return dict(zip(_AXES, axes_deg, strict=False))


def decode_axes(packet: Packet) -> StatedAxes:
    """Return the axes of a reply; raises RmiProtocolError where they are none of an arm."""
    return StatedAxes(packet.whole("TimeTag"), _angles(packet.part("JointAngle")))


def encode_motion(motion: JointMotion) -> Packet:
    """Return the instruction of a motion; raises ValueError where it is none."""
    if not 1 <= motion.speed_percent <= FASTEST_PERCENT:
        raise ValueError(f"{motion.speed_percent} % of the joints' greatest speed cannot be sent")
    if not all(abs(angle) <= _FURTHEST_DEG for angle in motion.axes_deg):
        raise ValueError(f"joint angles {motion.axes_deg} deg are out of any robot's range")
    return Packet(
        Kind.INSTRUCTION,
        JOINT_MOTION,
        {
            "SequenceID": motion.sequence,
            "JointAngle": encode_axes([round(angle, 6) for angle in motion.axes_deg]),
            "SpeedType": "Percent",
            "Speed": motion.speed_percent,
            # To rest at the end. The packet has a value with FINE too, though a public client leaves it out.
            "TermType": "FINE",
            "TermValue": 0,
        },
    )


def error_texts(answer: Packet) -> list[str]:
    """Return what the controller shows of its last errors."""
    texts = [answer.fields.get(name) for name in ERROR_NAMES]
    return [text for text in texts if isinstance(text, str) and text not in {"", "No Error"}]


def _angles(stated: Packet) -> tuple[float, ...]:
    angles = tuple(stated.number(axis) for axis in _AXES if axis in stated.fields)
    if len(angles) < JOINTS or stated.fields.keys() != set(_AXES[: len(angles)]):
        raise RmiProtocolError(f"the robot reports {dict(stated.fields)}; expected six joints or more")
    if not all(abs(angle) <= _FURTHEST_DEG for angle in angles):
        raise RmiProtocolError(f"the robot reports {angles} deg, which is out of any robot's range")
    return angles


_FIRST: Final = 2_556_928  # RMIT-000
_MOTION_FACILITY: Final = 15  # of the errors of motions, MOTN-nnn: 15,000 and what follows

IN_HOLD: Final = _FIRST + 24
ALREADY_CONNECTED: Final = _FIRST + 26
INVALID_STATE: Final = _FIRST + 15
NOT_RUNNING: Final = _FIRST + 9
WRONG_SEQUENCE: Final = _FIRST + 29
BAD_SPEED_TYPE: Final = _FIRST + 30
BAD_SPEED: Final = _FIRST + 31
BAD_TERM_TYPE: Final = _FIRST + 32
BAD_TERM_VALUE: Final = _FIRST + 33
BAD_POSITION_REGISTER: Final = _FIRST + 4
BAD_REPRESENTATION: Final = _FIRST + 44
BAD_POSITION_DATA: Final = _FIRST + 23
BAD_DESTINATION: Final = _FIRST + 36
BAD_OVERRIDE: Final = _FIRST + 5
BAD_TOOL: Final = _FIRST + 2
BAD_FRAME: Final = _FIRST + 3
BAD_VALUE: Final = _FIRST + 21
UNKNOWN_COMMAND: Final = _FIRST + 13
UNKNOWN_INSTRUCTION: Final = _FIRST + 20
PROGRAM_EXISTS: Final = 7015

_WORDS: Final[Mapping[int, str]] = {
    _FIRST + 1: "an error inside the controller",
    BAD_OVERRIDE: "no such speed override",
    _FIRST + 6: "its program cannot be run",
    _FIRST + 7: "the servos are off",
    _FIRST + 8: "the pendant is switched on, or its program cannot be run",
    NOT_RUNNING: "the interface was not initialised",
    _FIRST + 12: "its faults cannot be reset",
    UNKNOWN_COMMAND: "it does not know the command",
    _FIRST + 14: "the command failed",
    INVALID_STATE: "it is not ready",
    _FIRST + 16: "it must be switched off and on",
    UNKNOWN_INSTRUCTION: "it does not know the instruction",
    BAD_POSITION_DATA: "no such position",
    IN_HOLD: "it holds after an error",
    ALREADY_CONNECTED: "another program is connected to it",
    WRONG_SEQUENCE: "the instruction is out of sequence",
    BAD_SPEED_TYPE: "no such kind of speed",
    BAD_SPEED: "no such speed",
    BAD_DESTINATION: "the target cannot be reached",
    _FIRST + 43: "the pendant is set to single steps",
    7004: "its program RMI_MOVE is in use",
    PROGRAM_EXISTS: "its program RMI_MOVE was left behind by a broken session: delete it on the pendant",
}


def in_words(error: int) -> str:
    """Return why a request was refused."""
    return f"{_WORDS.get(error, 'it does not say why')} (error {error})"


def is_of_target(error: int) -> bool:
    """Whether a motion was refused for where it leads."""
    return error in {BAD_POSITION_DATA, BAD_DESTINATION} or error // 1000 == _MOTION_FACILITY
