"""What the packets of the Remote Motion Interface say, as far as a calibration needs it.

Wire units: mm, degrees, milliseconds, percent, joints as the controller counts (see `arms.joint_counting`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from truepose_drivers.fanuc_rmi.protocol.packets import Kind, Packet, RmiProtocolError

CONNECT_PORT: Final = 16001  # where every session begins; it goes on at a port that is named there
JOINTS: Final = 6
RESOLUTION_DEG: Final = 0.001  # of joint readings
FASTEST_PERCENT: Final = 100
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
        raise RmiProtocolError(f"the controller sends to port {port}, which is none")
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
        raise RmiProtocolError(f"the controller states a speed override of {override} %")
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
            "TermType": "FINE",
            "TermValue": 0,
        },
    )


def error_texts(answer: Packet) -> list[str]:
    """Return what the controller shows of its last errors."""
    texts = [value for key, value in answer.fields.items() if key.startswith("ErrorData")]
    return [text for text in texts if isinstance(text, str) and text not in {"", "No Error"}]


def _angles(stated: Packet) -> tuple[float, ...]:
    angles = tuple(stated.number(axis) for axis in _AXES if axis in stated.fields)
    if len(angles) < JOINTS or list(stated.fields) != list(_AXES[: len(angles)]):
        raise RmiProtocolError(f"the robot states {dict(stated.fields)}; six joints or more were expected")
    if not all(abs(angle) <= _FURTHEST_DEG for angle in angles):
        raise RmiProtocolError(f"the robot states {angles} deg, which is out of any robot's range")
    return angles
