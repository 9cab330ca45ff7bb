"""Wire protocol of MAPPDK, the KAREL text server of fanucpy: bytes in, messages out, no I/O.

Source: the KAREL program and the Python client of the public project fanucpy (see the folder's README).
Wire units: mm, degrees, as the controller counts its joints (see `arm_options`).

A request is one line of fields joined by `:`. A reply is ``CODE:MESSAGE`` without any terminator, at most
254 characters; a client sends the next request only after the reply to the last.

Our own server stops a motion when nobody is heard any more, where it is asked to. The stock server has none
of these requests, and ours does all that the stock one does.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final, Literal, TypeAlias

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.framing import StreamReader

MOTION_PORT: Final = 18735
LOGGER_PORT: Final = 18736  # takes the same requests; answers while a motion keeps the other port busy
LONGEST_MESSAGE_CHARS: Final = 254  # of a KAREL string
JOINTS: Final = 6
OUR_SERVER: Final = "truepose 1"  # first field of the identity of our own server, which the stock one has not
LONGEST_TIMED_MOTION_S: Final = 3200.0  # of the time of a motion in a TP program
_ENTRIES = 9  # of every reply with joints; those that the arm has not are "none"
_FEWEST_DECIMALS = 3
_FURTHEST_DEG = 3600.0  # no joint is wound up further
_TIME_STEP_S = 0.1
_GREATEST_SPEED = 9999
_SUCCESS = "success"
_END_OF_IDENTITY = ";"
_NUMBER = re.compile(r"[+-]?(\d+\.\d*|\.\d+|\d+)", re.ASCII)
_ENTRY = re.compile(r"j= *(none|[+-]?\d*\.\d+)", re.ASCII)
_BEGUN_ENTRY = re.compile(r"(j(= *([+-]?\d*(\.\d*)?|n|no|non|none)?)?)?", re.ASCII)
_KNOWN_ERRORS = frozenset({
    "wrong-command",
    "position-is-not-reachable",
    "error-in-joint-values",
    "cannot-convert-joint-vals",
    "R[81]-was-not-set",
    "R[82]-was-not-set",
    "R[83]-was-not-set",
    "PR[81]-was-not-set",
    "wrong-rdo-value",
    "wrong-dout-value",
    "wrong-watch-value",  # of our own server
})

ReplyExtent: TypeAlias = Literal["part", "maybe whole", "whole"]
Expected: TypeAlias = Literal["success", "joints", "identity"]


class MappdkProtocolError(RemoteProtocolError):
    """The other side sent text that is no message of MAPPDK."""


class Command(StrEnum):
    """First field of a request; the last four are of our own server only."""

    POSE = "curpos"
    JOINTS = "curjpos"
    MOVE_TO_JOINTS = "movej"
    MOVE_TO_POSE = "movep"
    POWER = "ins_pwr"
    CALL = "mappdkcall"
    SET_ROBOT_OUTPUT = "setrdo"
    GET_ROBOT_OUTPUT = "getrdo"
    SET_OUTPUT = "setdout"
    GET_OUTPUT = "getdout"
    SET_SYSTEM_VARIABLE = "setsysvar"
    EXIT = "exit"
    IDENTITY = "identity"
    WATCH = "watch"  # ms of silence after which a motion is stopped; 0: never
    BEAT = "beat"  # has no reply: the client is there
    MOVE_IN_TIME = "movet"  # tenths of a second that the motion takes at least, joints


class ReplyCode:
    """First field of a reply."""

    OK: Final = 0
    ERROR: Final = 1


@dataclass(frozen=True, slots=True)
class Request:
    """A request as the controller takes it apart."""

    name: str
    fields: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Motion:
    """The fields of a motion to joints [deg] or to a pose [mm, deg]."""

    values: tuple[float, ...]
    speed: int  # % of the greatest joint speed, mm/s where linear
    acceleration_percent: int = 100
    continuous_percent: int = 0  # 0: the arm rests at its end
    linear: bool = False


@dataclass(frozen=True, slots=True)
class TimedMotion:
    """A joint motion of our own server, at rest at its end."""

    values: tuple[float, ...]
    duration_s: float  # at least


@dataclass(frozen=True, slots=True)
class Reply:
    """A reply; the message holds no colon."""

    code: int
    message: str


GREETING: Final = Reply(ReplyCode.OK, _SUCCESS)  # sent to everybody who is let in


def encode_request(name: Command, *fields: str) -> bytes:
    """Return the line of a request; raises ValueError when it does not fit one KAREL string."""
    text = ":".join([name, *fields])
    if len(text) > LONGEST_MESSAGE_CHARS:
        raise ValueError(f"request {name} has {len(text)} characters; a KAREL string holds 254")
    return text.encode("ascii") + b"\n"


def encode_motion(name: Command, motion: Motion) -> bytes:
    """Return the line of a motion; raises ValueError for a speed or value that cannot be sent."""
    if not 1 <= motion.speed <= _GREATEST_SPEED:
        raise ValueError(f"a speed of {motion.speed} cannot be sent to a robot")
    return encode_request(
        name,
        f"{motion.speed:04d}",
        f"{motion.acceleration_percent:04d}",
        f"{motion.continuous_percent:03d}",
        f"{int(motion.linear)}",
        *_value_fields(motion.values),
    )


def encode_timed_motion(motion: TimedMotion) -> bytes:
    """Return the line of a timed motion, rounded up to the next tenth of a second."""
    if not 0.0 < motion.duration_s <= LONGEST_TIMED_MOTION_S:
        raise ValueError(f"a motion cannot take {motion.duration_s:g} s: at most 3200 s can be stated")
    # Up, since a shorter motion would be too fast. 1e-9: 3 * 0.1 s, in doubles a little more than 0.3,
    # must not become four tenths.
    tenths = math.ceil(motion.duration_s / _TIME_STEP_S - 1e-9)
    return encode_request(Command.MOVE_IN_TIME, f"{tenths:05d}", *_value_fields(motion.values))


def encode_watch(silence_s: float) -> bytes:
    """Return the line that has our own server stop motions after so much silence."""
    return encode_request(Command.WATCH, f"{round(1000.0 * silence_s):04d}")


class RequestReader(StreamReader):
    """Reassembles the lines that a client sends."""

    def next_message(self) -> str | None:
        """Take the oldest whole line, cut to what a KAREL string holds; None until more arrives."""
        end = self._buffer.find(b"\n")
        if end < 0:
            # More than that is lost on the controller too; kept, a line without end would fill the memory.
            del self._buffer[LONGEST_MESSAGE_CHARS:]
            return None
        line = self._take(end, drop=1).decode("ascii", errors="replace")
        return line.rstrip("\r")[:LONGEST_MESSAGE_CHARS]


def decode_request(line: str) -> Request:
    """Take a line apart; any line is a request, most are of no server."""
    name, *fields = line.split(":")
    return Request(name, tuple(fields))


def decode_motion(request: Request) -> Motion:
    """Read the fields of a motion; raises MappdkProtocolError with the text of the reply to it."""
    if len(request.fields) < 5:
        raise MappdkProtocolError("error-in-joint-values")
    speed, acceleration, continuous = (
        _register(text, register)
        for text, register in zip(request.fields, ("R[81]", "R[82]", "R[83]"), strict=False)
    )
    linear = request.fields[3] == "1"
    return Motion(_values(request.fields[4:]), speed, acceleration, continuous, linear)


def decode_timed_motion(request: Request) -> TimedMotion:
    """Read the fields of a timed motion; raises MappdkProtocolError."""
    if len(request.fields) < 2:
        raise MappdkProtocolError("error-in-joint-values")
    tenths = _register(request.fields[0], "R[81]")
    return TimedMotion(_values(request.fields[1:]), tenths * _TIME_STEP_S)


def encode_reply(reply: Reply) -> bytes:
    """Return the bytes of a reply; raises ValueError where clients could not take it apart."""
    text = f"{reply.code}:{reply.message}"
    if len(text) > LONGEST_MESSAGE_CHARS or ":" in reply.message:
        raise ValueError(f"{text!r} is not a reply: it is too long, or its message contains a colon")
    return text.encode("ascii")


def decode_reply(data: bytes) -> Reply:
    """Read what was received; raises MappdkProtocolError when it is no reply."""
    text = data.decode("ascii", errors="replace").rstrip("\r\n")
    code, colon, message = text.partition(":")
    if not colon or code not in {"0", "1"} or ":" in message or len(text) > LONGEST_MESSAGE_CHARS:
        raise MappdkProtocolError(f"{text[:80]!r} is not a MAPPDK reply: expected code and message")
    return Reply(int(code), message)


def reply_extent(data: bytes, expected: Expected) -> ReplyExtent:
    """Tell whether a stream delivered all of a reply.

    What can never become the reply that is expected counts as whole, so that it is refused at once.
    """
    text = data.decode("ascii", errors="replace").rstrip("\r\n")
    if len(data) > LONGEST_MESSAGE_CHARS + len("\r\n"):
        return "whole"
    if text in {"", "0", "1"}:
        return "part"
    if text[:2] == "1:":
        return _extent_of_error(text[2:])
    if text[:2] != "0:":
        return "whole"
    match expected:
        case "success":
            return "part" if _SUCCESS.startswith(text[2:]) and text[2:] != _SUCCESS else "whole"
        case "identity":
            return "whole" if text.endswith(_END_OF_IDENTITY) or ":" in text[2:] else "part"
        case "joints":
            return _extent_of_joints(text[2:])


def require(reply: Reply, expected: Expected) -> None:
    """See that a good reply is of the kind that is expected; raises MappdkProtocolError."""
    if reply.code != ReplyCode.OK:
        return
    if expected == "joints":
        joint_angles_deg(reply)
    elif (reply.message == _SUCCESS) != (expected == "success"):
        raise MappdkProtocolError(
            f"the robot replied {reply.message[:80]!r}, which does not answer the request"
        )


def encode_joints(angles_deg: Sequence[float], decimals: int = _FEWEST_DECIMALS) -> Reply:
    """Return the reply to `curjpos` as a controller of six joints writes it."""
    texts = [f"{angle:{decimals + 5}.{decimals}f}" for angle in angles_deg]
    texts += ["none"] * (_ENTRIES - len(texts))
    return Reply(ReplyCode.OK, ",".join(f"j={text}" for text in texts))


def joint_angles_deg(reply: Reply) -> tuple[float, ...]:
    """Return the angles in a reply to `curjpos`; raises MappdkProtocolError when it has others."""
    texts = _joint_texts(reply)
    angles = tuple(map(float, texts))
    if any(abs(angle) > _FURTHEST_DEG for angle in angles):
        raise MappdkProtocolError(f"the reply {reply.message!r} has an angle out of any robot's range")
    return angles


def joint_resolution_deg(reply: Reply) -> float:
    """Return the step of the angles in a reply to `curjpos`."""
    return 10.0 ** -_decimals(_joint_texts(reply)[0])


def encode_identity(model: str, serial: str, version: str) -> Reply:
    """Return our own server's reply to `identity`."""
    return Reply(ReplyCode.OK, ",".join([OUR_SERVER, model, serial, version]) + _END_OF_IDENTITY)


def decode_identity(reply: Reply) -> tuple[str, str, str] | None:
    """Return model, serial number and version; None of a server that is not ours.

    Raises MappdkProtocolError where our server's identity lacks a field.
    """
    if reply.code != ReplyCode.OK:
        return None
    fields = reply.message.removesuffix(_END_OF_IDENTITY).split(",")
    if len(fields) != 4 or fields[0] != OUR_SERVER:
        raise MappdkProtocolError(f"the robot calls itself {reply.message[:80]!r}, which is not an identity")
    model, serial, version = (field.strip() for field in fields[1:])
    return model, serial, version


def _extent_of_error(message: str) -> ReplyExtent:
    return "whole" if message in _KNOWN_ERRORS or ":" in message else "maybe whole"


def _extent_of_joints(message: str) -> ReplyExtent:
    *done, last = message.split(",")
    if len(done) >= _ENTRIES or not all(map(_ENTRY.fullmatch, done)) or not _BEGUN_ENTRY.fullmatch(last):
        return "whole"
    if len(done) < _ENTRIES - 1 or _ENTRY.fullmatch(last) is None:
        return "part"
    # The ninth entry of an arm of six joints is none, and cannot go on; a number may still get digits.
    return "whole" if last.endswith("none") else "maybe whole"


def _joint_texts(reply: Reply) -> list[str]:
    entries = [_ENTRY.fullmatch(entry) for entry in reply.message.split(",")]
    texts = [entry[1] for entry in entries if entry is not None]
    own, others = texts[:JOINTS], texts[JOINTS:]
    if len(entries) != _ENTRIES or len(texts) != _ENTRIES or "none" in own or set(others) != {"none"}:
        raise MappdkProtocolError(
            f"the robot reported {reply.message[:120]!r}; expected angles of six joints"
        )
    decimals = set(map(_decimals, own))
    if len(decimals) > 1 or min(decimals) < _FEWEST_DECIMALS:
        raise MappdkProtocolError(
            f"the robot reported {reply.message[:120]!r}: digits were lost or duplicated"
        )
    return own


def _decimals(text: str) -> int:
    return len(text.partition(".")[2])


def _value_fields(values: Sequence[float]) -> list[str]:
    if not all(abs(value) <= _FURTHEST_DEG for value in values):
        raise ValueError(f"joint angles {tuple(values)} deg are out of any robot's range")
    return [f"{len(values)}", *(f"{value:+014.6f}" for value in values)]


def _values(fields: Sequence[str]) -> tuple[float, ...]:
    count, texts = fields[0], [text.strip() for text in fields[1:]]
    if count != str(len(texts)) or not all(map(_NUMBER.fullmatch, texts)):
        raise MappdkProtocolError("error-in-joint-values")
    return tuple(map(float, texts))


def _register(text: str, register: str) -> int:
    if not (text.isascii() and text.isdigit()):
        raise MappdkProtocolError(f"{register}-was-not-set")
    return int(text)


# Our own server watches whoever moves the arm.
SILENCE_S: Final = 0.8  # after which the controller stops the arm; it looks every 0.05 s
BEAT_S: Final = 0.2  # so often the driver is heard while the arm moves
STOPS_WITHIN_S: Final = 1.0  # silence, look and deceleration

BEAT: Final = encode_request(Command.BEAT)
