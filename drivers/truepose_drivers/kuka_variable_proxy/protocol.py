"""Frames of the variable proxy (KUKAVARPROXY, C3 Bridge), and the variables here, as KRL has them.

Source: the public server's own program. An answer bears the number of its request; its last byte says whether
the variable was read or written. A variable that is not there is read as nothing.

Angles in degrees as the controller counts its axes. The last variables are those of our own program.
"""

import math
import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from typing import Final

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.framing import StreamReader

PROXY_PORT: Final = 7000
NUMBERS: Final = 2**16  # of requests, which begin anew then
_HEAD: Final = struct.Struct(">HHB")  # number, size of what follows it, mode
_SIZE: Final = struct.Struct(">H")
_AFTER_SIZE: Final = 1  # bytes of the head that the size counts: the mode
_TAILS: Final = {b"\x00\x01\x01": True, b"\x00\x01\x00": False, b"\x00\x00\x00": False}
_TAIL_BYTES: Final = 3
_LONGEST: Final = 2_048  # of a request, as the public server reads it; answers are shorter


class ProxyProtocolError(RemoteProtocolError):
    """The other side sent bytes that are no frame of the variable proxy."""


class Mode(IntEnum):
    """What is done with a variable."""

    READ = 0
    WRITE = 1


@dataclass(frozen=True, slots=True)
class Request:
    """A variable to be read, or written where there is a value."""

    number: int
    name: str
    value: str | None = None

    @property
    def mode(self) -> Mode:
        """What is to be done."""
        return Mode.READ if self.value is None else Mode.WRITE


@dataclass(frozen=True, slots=True)
class Answer:
    """What became of a request."""

    number: int
    mode: Mode
    value: str
    done: bool


class FrameReader(StreamReader):
    """Reassembles frames from a byte stream."""

    def _next_frame(self) -> tuple[int, Mode, bytes] | None:
        """Take the oldest whole frame: number, mode, and what follows; raises ProxyProtocolError."""
        if len(self._buffer) < _HEAD.size:
            return None
        number, size, mode = _HEAD.unpack_from(self._buffer)
        if not _AFTER_SIZE <= size <= _LONGEST or mode not in Mode.__members__.values():
            raise ProxyProtocolError(
                f"{bytes(self._buffer[:12])!r} is not the start of a variable proxy frame"
            )
        end = _HEAD.size - _AFTER_SIZE + size
        if len(self._buffer) < end:
            return None
        return number, Mode(mode), self._take(end)[_HEAD.size :]


class AnswerReader(FrameReader):
    """Reassembles what the proxy sends."""

    def next_message(self) -> Answer | None:
        """Take the oldest whole answer, None until more arrives; raises ProxyProtocolError."""
        frame = self._next_frame()
        if frame is None:
            return None
        number, mode, content = frame
        tail = content[-_TAIL_BYTES:]
        if tail not in _TAILS:
            raise ProxyProtocolError(f"{content!r} does not say whether it succeeded")
        value, rest = _block(content[:-_TAIL_BYTES])
        _require_end(rest)
        return Answer(number, mode, value, _TAILS[tail])


class RequestReader(FrameReader):
    """Reassembles what a client sends."""

    def next_message(self) -> Request | None:
        """Take the oldest whole request, None until more arrives; raises ProxyProtocolError."""
        frame = self._next_frame()
        if frame is None:
            return None
        number, mode, content = frame
        name, rest = _block(content)
        value = None
        if mode is Mode.WRITE:
            value, rest = _block(rest)
        _require_end(rest)
        return Request(number, name, value)


def encode_request(request: Request) -> bytes:
    """Return the frame of a request; raises ValueError where it is none."""
    blocks = [request.name] if request.value is None else [request.name, request.value]
    return _encode(request.number, request.mode, b"".join(map(_encoded, blocks)))


def encode_answer(answer: Answer) -> bytes:
    """Return the frame of an answer."""
    tail = b"\x00\x01" + bytes([answer.done])
    return _encode(answer.number, answer.mode, _encoded(answer.value) + tail)


def _encode(number: int, mode: Mode, content: bytes) -> bytes:
    size = _AFTER_SIZE + len(content)
    if size > _LONGEST:
        raise ValueError(f"a frame of {size} bytes is longer than the proxy accepts")
    return _HEAD.pack(number, size, mode) + content


def _encoded(text: str) -> bytes:
    data = text.encode("ascii")
    return _SIZE.pack(len(data)) + data


def _block(content: bytes) -> tuple[str, bytes]:
    """Return the text at the beginning, and what follows it."""
    if len(content) < _SIZE.size:
        raise ProxyProtocolError(f"{content!r} ends before its text")
    (size,) = _SIZE.unpack_from(content)
    text, rest = content[_SIZE.size : _SIZE.size + size], content[_SIZE.size + size :]
    if len(text) < size or not text.isascii():
        raise ProxyProtocolError(f"{content[:40]!r} is no text of {size} characters")
    return text.decode("ascii"), rest


def _require_end(rest: bytes) -> None:
    if rest:
        raise ProxyProtocolError(f"{rest[:40]!r} follows the end of a frame")


JOINTS: Final = 6
STEP_DEG: Final = 2.0**-15  # of a REAL, which has 24 bits, at 256 to 512 deg
SILENCE_S: Final = 0.8  # without a new beat, after which our program stops the arm
BEAT_S: Final = 0.05  # so often the driver gives one
STOPS_WITHIN_S: Final = 1.0  # silence and deceleration
ACTIVE: Final = "#P_ACTIVE"  # state of a program that runs
_AXES: Final = (*(f"A{axis}" for axis in range(1, 7)), *(f"E{axis}" for axis in range(1, 7)))
_FURTHEST_DEG: Final = 3600.0  # no joint is wound up further
_NUMBER: Final = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_FIELD: Final = re.compile(rf"\s*(\w+)\s+({_NUMBER}|#\w+)\s*", re.ASCII)
_AGGREGATE: Final = re.compile(r"\s*\{(?:\s*(\w+)\s*:)?([^{}]*)\}\s*", re.ASCII)
_LARGEST_COUNT: Final = 2**30
_STATE_TYPE: Final = "TP_STATE_TYPE"
_STATES: Final = ("BEGUN", "ARRIVED", "GIVEN_UP", "REFUSED")


class Variable(StrEnum):
    """Names of variables."""

    PING = "PING"  # of the proxy itself
    AXES = "$AXIS_ACT"
    OVERRIDE = "$OV_PRO"
    PROGRAM_STATE = "$PRO_STATE1"  # of the program that moves the arm
    MODE = "$MODE_OP"
    DRIVES = "$PERI_RDY"
    SERIAL = "$KR_SERIALNO"
    MODEL = "$MODEL_NAME[]"
    SOFTWARE = "$RCV_INFO[]"
    TARGET = "TP_TARGET"
    PERCENT = "TP_PERCENT"
    MOST_OVERRIDE = "TP_OVERRIDE"
    NUMBER = "TP_NUMBER"
    BEAT = "TP_BEAT"
    STATE = "TP_STATE"


@dataclass(frozen=True, slots=True)
class ProgramState:
    """Numbers of the motions that our program did this with last."""

    begun: int
    arrived: int  # at rest at the target
    given_up: int  # because nothing was heard
    refused: int  # because the target is out of the ranges of the axes

    @property
    def moves(self) -> bool:
        """Whether a motion has begun and not ended."""
        return self.begun not in {self.arrived, self.given_up, self.refused}

    @property
    def unused_number(self) -> int:
        """A number that no motion has had lately."""
        return following(max(self.begun, self.arrived, self.given_up, self.refused))


def following(count: int) -> int:
    """Return the count after `count`, from 1 on and well within 32 bits."""
    return max(count, 0) % _LARGEST_COUNT + 1


def encode_real(value: float) -> str:
    """Return a REAL as KRL shows it: with all digits that its 24 bits have, and a point."""
    (rounded,) = struct.unpack("f", struct.pack("f", value))
    text = f"{rounded + 0.0:.9G}"
    return text if "." in text or "E" in text else f"{text}.0"


def encode_axes(axes_deg: Sequence[float], kind: str = "") -> str:
    """Return an E6AXIS; raises ValueError for angles that are out of any robot's range."""
    if not all(abs(angle) <= _FURTHEST_DEG for angle in axes_deg):
        raise ValueError(f"joint angles {tuple(axes_deg)} deg are out of any robot's range")
    return encode_aggregate(dict(zip(_AXES, map(encode_real, axes_deg), strict=False)), kind)


def decode_axes(text: str) -> tuple[float, ...]:
    """Return the twelve axes of an E6AXIS, or as many as are stated; raises ProxyProtocolError."""
    fields = decode_aggregate(text, "E6AXIS")
    names = tuple(fields)
    if len(names) < JOINTS or names != _AXES[: len(names)]:
        raise ProxyProtocolError(f"the robot reports {text[:160]!r}; expected the axes A1 to A6")
    angles = tuple(_number(value) for value in fields.values())
    if not all(abs(angle) <= _FURTHEST_DEG for angle in angles):
        raise ProxyProtocolError(f"the robot reports {text[:160]!r}, which is out of any robot's range")
    return angles


def encode_state(state: ProgramState) -> str:
    """Return the state of our program."""
    counts = (state.begun, state.arrived, state.given_up, state.refused)
    return encode_aggregate(dict(zip(_STATES, map(str, counts), strict=True)), _STATE_TYPE)


def decode_state(text: str) -> ProgramState:
    """Return the state of our program; raises ProxyProtocolError."""
    fields = decode_aggregate(text, _STATE_TYPE)
    if tuple(fields) != _STATES:
        raise ProxyProtocolError(f"the robot reports {text[:160]!r} as the state of the program TRUEPOSE")
    return ProgramState(*(decode_count(value) for value in fields.values()))


def decode_count(text: str) -> int:
    """Return a whole number that is not negative; raises ProxyProtocolError."""
    if not (text.isascii() and text.isdigit()) or int(text) > _LARGEST_COUNT:
        raise ProxyProtocolError(f"the robot reports {text[:40]!r}; expected a count")
    return int(text)


def decode_text(text: str) -> str:
    """Return the text of a CHAR array, or any other value as it is written."""
    return text.strip().strip('"').strip()


def encode_aggregate(fields: Mapping[str, str], kind: str = "") -> str:
    """Return a structure, with its kind in front where one is given."""
    content = ", ".join(f"{name} {value}" for name, value in fields.items())
    return f"{{{kind}: {content}}}" if kind else f"{{{content}}}"


def decode_aggregate(text: str, kind: str) -> dict[str, str]:
    """Return the fields of a structure of a kind; raises ProxyProtocolError."""
    found = _AGGREGATE.fullmatch(text)
    fields = [] if found is None else [_FIELD.fullmatch(field) for field in found[2].split(",")]
    if found is None or found[1] not in {None, kind} or None in fields:
        raise ProxyProtocolError(f"the robot reports {text[:160]!r}; expected {kind}")
    values = {field[1]: field[2] for field in fields if field is not None}
    if len(values) != len(fields):
        raise ProxyProtocolError(f"the robot reports a field twice: {text[:160]!r}")
    return values


def _number(text: str) -> float:
    value = math.nan if text.startswith("#") else float(text)
    if not math.isfinite(value):
        raise ProxyProtocolError(f"the robot reports {text!r}; expected a number")
    return value
