"""Wire protocol of open_abb, the text server on ABB IRC5 controllers: bytes in, messages out, no I/O.

Source: RAPID modules SERVER.mod and LOGGER.mod and the clients of the public project open_abb (see the
folder's README). Wire units: mm, degrees; quaternions w first.

A request is ``CODE value value ... #``, at most 80 characters (one RAPID string), at most ten values. A
reply is ``CODE STATUS text``. Neither has a terminator that can be relied on: one segment is one message,
and a client sends the next request only after the reply to the last.

Our own server stops a motion when nobody is heard any more, where it is asked to: its identity has one more
field at its end, and the codes 94 to 96, which the stock server does not have, go to our server only.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Final, Literal, TypeAlias

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.framing import StreamReader

MOTION_PORT = 5000
LOGGER_PORT = 5001
LONGEST_MESSAGE_CHARS = 80
MOST_PARAMETERS = 10
OUR_SERVER = "truepose 3"  # fourth field of the identity of our own server, which the stock one has not
MOST_DECIMALS = 5  # of a number, which our own server gives
_LONGEST_RECORD = 200  # of the logger; one of a pose has some 120 characters
REPLY_RESOLUTION_DEG = 0.01  # joint angles leave the controller with two decimals
_FULL_TURN_DEG = 360.0
_FURTHEST_DEG = 10 * _FULL_TURN_DEG  # no joint is wound up further
# What StrToVal reads; float() alone would also take nan and 1_000. Two digits of exponent stay finite.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,2})?", re.ASCII)


_PING_REPLY = re.compile(rb"(?P<rest>.*?)0 1 ?[\r\n]*", re.DOTALL)
_STATUSES = ("0", "1")
# Three digits of code at most: Python reads no number of five thousand, and raises a ValueError for it.
_REPLY_START = re.compile(rb"(?P<code>\d{0,3})( (?P<status>\d?)([ \r\n](?P<text>.*))?)?", re.DOTALL)

ReplyExtent: TypeAlias = Literal["part", "maybe whole", "whole"]


class OpenAbbProtocolError(RemoteProtocolError):
    """The other side sent text that is no message of open_abb."""


class Code(IntEnum):
    """First number of a request, echoed by its reply."""

    PING = 0
    MOVE_LINEAR = 1  # x y z q1..q4
    MOVE_JOINTS = 2  # j1..j6
    GET_POSE = 3
    GET_JOINTS = 4
    GET_EXTERNAL_AXES = 5
    SET_TOOL = 6  # x y z q1..q4
    SET_WORK_OBJECT = 7  # x y z q1..q4
    SET_SPEED = 8  # mm/s, deg/s [, linear and rotating external axes]
    SET_ZONE = 9  # fine 1/0, mm, mm, deg
    BUFFER_ADD = 30  # x y z q1..q4
    BUFFER_CLEAR = 31
    BUFFER_LENGTH = 32
    BUFFER_RUN = 33
    MOVE_EXTERNAL_AXES = 34
    SET_CIRCLE_POINT = 35  # x y z q1..q4
    MOVE_CIRCLE = 36  # x y z q1..q4
    GET_SPEED = 94  # of our own server only, as are 95 and 96: mm/s, deg/s
    WATCH = 95  # s of silence after which a motion is stopped; 0: never
    BEAT = 96  # has no reply: the client is there
    CONTROLLER_INFO = 98
    CLOSE = 99  # has no reply: the server closes and listens again


class ReplyStatus(IntEnum):
    """Second number of a reply."""

    BAD_MESSAGE = 0
    OK = 1


@dataclass(frozen=True, slots=True)
class Request:
    """A numbered request; `code` may be one that no server knows."""

    code: int
    values: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Reply:
    """A reply; `text` is empty where the request asks for nothing."""

    code: int
    status: int
    text: str = ""


@dataclass(frozen=True, slots=True)
class LogLine:
    """One record of the logger stream: a pose (kind 0) or joint angles (kind 1), stamped."""

    kind: int
    date: str
    time: str
    elapsed_s: float  # since the logger started
    values: tuple[float, ...]  # kind 0: x y z [mm] q1..q4; kind 1: j1..j6 [deg]


def encode_joint_target(target_deg: Sequence[float]) -> bytes:
    """Return request 2 with five decimals (1e-5 deg), the most that six joints leave room for."""
    return encode_request(Code.MOVE_JOINTS, [_joint_text(angle) for angle in target_deg])


def encode_request(code: int, values: Sequence[str] = ()) -> bytes:
    """Return the bytes of a request whose values are formatted already.

    Raises ValueError when it has too many values or does not fit one RAPID string.
    """
    if len(values) > MOST_PARAMETERS:
        raise ValueError(f"request {code} has {len(values)} values; open_abb takes {MOST_PARAMETERS}")
    text = " ".join([str(int(code)), *values, "#"])
    if len(text) > LONGEST_MESSAGE_CHARS:
        raise ValueError(f"request {code} has {len(text)} characters; a RAPID string holds 80")
    return text.encode("ascii")


def decimal(value: float, decimals: int) -> str:
    """Return a number as RAPID reads it, without exponent; raises ValueError when it is not finite."""
    if not math.isfinite(value):
        raise ValueError(f"{value} cannot be sent to a robot")
    return f"{value:.{decimals}f}"


def decode_request(data: bytes) -> Request:
    """Read a request as the controller does; raises OpenAbbProtocolError when it is corrupt.

    What stands behind the end mark is lost, as in RAPID, which reads one string a request. A value that
    runs into the mark without a space is not counted; two spaces in a row enclose a value that is none.
    """
    text = data.decode("ascii", errors="replace")[:LONGEST_MESSAGE_CHARS]
    body, mark, _ = text.partition("#")
    if not mark:
        raise OpenAbbProtocolError(f"{text!r} has no end mark # within {LONGEST_MESSAGE_CHARS} characters")
    words = body.split(" ")[:-1]
    numbers = [_number(word) for word in words]
    if not numbers:
        raise OpenAbbProtocolError(f"{text!r} has no code")
    if len(numbers) - 1 > MOST_PARAMETERS:
        raise OpenAbbProtocolError(f"{text!r} has more than {MOST_PARAMETERS} values")
    if not numbers[0].is_integer():
        raise OpenAbbProtocolError(f"{numbers[0]} is not a request code: codes are whole numbers")
    return Request(int(numbers[0]), tuple(numbers[1:]))


def encode_reply(reply: Reply) -> bytes:
    """Return the bytes of a reply; one without text ends with a space, as the controller's do.

    Raises ValueError when it does not fit one RAPID string.
    """
    text = f"{reply.code} {int(reply.status)} {reply.text}"
    if len(text) > LONGEST_MESSAGE_CHARS:
        raise ValueError(f"reply to {reply.code} has {len(text)} characters; a RAPID string holds 80")
    return text.encode("ascii")


def decode_reply(data: bytes) -> Reply:
    """Read what one receive delivered; raises OpenAbbProtocolError when it is no reply."""
    text = data.decode("ascii", errors="replace")
    words = text.rstrip("\r\n").split(" ", 2)
    too_long = len(text) > 2 * LONGEST_MESSAGE_CHARS  # of a whole one, and what lagged behind it
    if too_long or len(words) < 2 or not _is_count(words[0]) or words[1] not in _STATUSES:
        raise OpenAbbProtocolError(f"{text[:80]!r} is not an open_abb reply: expected code and status")
    return Reply(int(words[0]), int(words[1]), words[2].strip() if len(words) == 3 else "")


def reply_extent(data: bytes, code: int, words: int) -> ReplyExtent:
    """Tell whether a stream delivered all of the reply to `code`, whose text has at least `words` words.

    A last number with five decimals, which no server exceeds, ends a reply for certain, and so does the space
    behind the status where no text belongs; any other last word may still grow. What can never become that
    reply counts as whole, so that it is refused at once.
    """
    head = _REPLY_START.fullmatch(data)
    if head is None or len(data) > LONGEST_MESSAGE_CHARS:
        return "whole"
    if head["status"] is not None and int(head["code"] or b"-1") != code:
        return "whole"
    status, text = head["status"], head["text"]
    if not status:
        return "part"
    if words == 0 or status != b"1":
        return "maybe whole" if text is None else "whole"
    numbers = (text or b"").split()
    if len(numbers) < words:
        return "part"
    return "whole" if _decimals(numbers[-1]) >= MOST_DECIMALS else "maybe whole"


def ends_for_certain(reply: Reply) -> bool:
    """Whether the form of its last number says that a reply to GET_JOINTS is whole."""
    return _ends(reply.text.encode().split())


def rest_before_ping(data: bytes) -> bytes | None:
    """Return what stands before the reply to a ping, None until that reply is there.

    The controller replies in order: whatever arrives before it belongs to the reply before.
    """
    found = _PING_REPLY.fullmatch(data)
    return None if found is None else found["rest"]


def joint_angles_deg(reply: Reply, count: int) -> tuple[float, ...]:
    """Return the angles in a reply to GET_JOINTS; raises OpenAbbProtocolError when it has others."""
    angles = reply_numbers(reply, count)
    if any(abs(angle) > _FURTHEST_DEG for angle in angles):
        raise OpenAbbProtocolError(f"the reply {reply.text!r} has an angle out of any robot's range")
    return angles


def joint_resolution_deg(reply: Reply) -> float:
    """Return the step of the angles in a reply to GET_JOINTS: 0.01, finer if it has more decimals."""
    return min(REPLY_RESOLUTION_DEG, 10.0 ** -joint_decimals(reply))


def joint_decimals(reply: Reply) -> int:
    """Return how many decimals the most precise angle of a reply to GET_JOINTS has."""
    return max(_decimals(word.encode()) for word in reply.text.split())


def reply_numbers(reply: Reply, count: int) -> tuple[float, ...]:
    """Return the `count` numbers in a reply's text; raises OpenAbbProtocolError when it has others."""
    words = reply.text.split()
    if len(words) != count:
        raise OpenAbbProtocolError(f"the reply to {reply.code} is {reply.text!r}; expected {count} numbers")
    return tuple(_number(word) for word in words)


def rapid_number(value: float, decimals: int) -> str:
    """Return a number as RAPID's NumToStr does: whole numbers without decimals, huge ones as 9E+09."""
    rounded = round(value, decimals)
    if abs(rounded) >= 1e7:
        return f"{rounded:.0E}"
    return str(int(rounded)) if rounded == int(rounded) else f"{rounded:.{decimals}f}"


def encode_log_line(line: LogLine) -> bytes:
    """Return one record of the logger stream; a record ends where the next `#` begins."""
    first_decimals, decimals = (1, 3) if line.kind == 0 else (2, 2)
    numbers = [
        rapid_number(value, first_decimals if index < 3 else decimals)
        for index, value in enumerate(line.values)
    ]
    return " ".join(["#", str(line.kind), line.date, line.time, f"{line.elapsed_s:.2f}", *numbers]).encode()


class LogReader(StreamReader):
    """Reassembles logger records; the last one stays inside until the next begins."""

    def next_line(self) -> LogLine | None:
        """Take the oldest record whose end is known; raises OpenAbbProtocolError when it is none."""
        start = self._buffer.find(b"#")
        end = self._buffer.find(b"#", start + 1)
        if (end if end >= 0 else len(self._buffer)) > _LONGEST_RECORD:
            raise OpenAbbProtocolError(f"{bytes(self._buffer[:80])!r} is not a logger record")
        if start < 0 or end < 0:
            return None
        record = self._buffer[start + 1 : end].decode("ascii", errors="replace")
        del self._buffer[:end]
        return _log_line(record)


def _log_line(record: str) -> LogLine:
    words = record.split()
    expected = {"0": 11, "1": 10}.get(words[0] if words else "")
    if len(words) != expected:
        raise OpenAbbProtocolError(f"{record[:120]!r} is not a logger record")
    return LogLine(int(words[0]), words[1], words[2], _number(words[3]), tuple(map(_number, words[4:])))


def _joint_text(angle_deg: float) -> str:
    if not abs(angle_deg) <= _FURTHEST_DEG:
        raise ValueError(f"joint angle {angle_deg} deg is out of any robot's range")
    # Six times eleven characters, their blanks, code and end mark are 75 of the 80 that a RAPID string holds.
    return f"{angle_deg:+011.5f}"


def _number(word: str) -> float:
    if _NUMBER.fullmatch(word) is None:
        raise OpenAbbProtocolError(f"{word!r} is not a number")
    return float(word)


def _ends(numbers: Sequence[bytes]) -> bool:
    return _decimals(numbers[-1]) >= max(2, *map(_decimals, numbers))


def _decimals(word: bytes) -> int:
    """Return how many decimals a number has; 0 of a word that is none, such as a version in an identity."""
    whole, _, decimals = word.partition(b".")
    return len(decimals) if decimals.isdigit() and whole.lstrip(b"+-").isdigit() else 0


def _is_count(word: str) -> bool:
    return word.isascii() and word.isdigit()


SILENCE_S: Final = 0.8  # after which the controller stops the arm; it looks every 0.1 s
BEAT_S: Final = 0.2  # so often the driver is heard while the arm moves
STOPS_WITHIN_S: Final = 1.0  # silence, look and deceleration

BEAT: Final = encode_request(Code.BEAT)


def is_our_server(fields: list[str]) -> bool:
    """Whether an identity, in its fields, is that of a server that can watch."""
    return OUR_SERVER in fields[3:]
