"""Wire protocol of the cell's clock: one JSON object a line, UTF-8, one answer to each request.

``{"op": "now"}`` and ``{"op": "sleep", "s": 4.0}`` are answered ``{"now_s": 12.5}``, or
``{"error": "..."}`` with a sentence.
"""

import json
import math
from dataclasses import dataclass
from typing import TypeAlias

from drivers.errors import RemoteProtocolError

LONGEST_LINE_BYTES = 1_024  # a request or answer of this protocol is shorter than 100 bytes


class ClockProtocolError(RemoteProtocolError):
    """A line that is no request and no answer of the clock."""


@dataclass(frozen=True, slots=True)
class Now:
    """Request: the present cell time."""


@dataclass(frozen=True, slots=True)
class Sleep:
    """Request: answer when `duration_s` of cell time have gone by."""

    duration_s: float


@dataclass(frozen=True, slots=True)
class Time:
    """Answer: the present cell time."""

    now_s: float


@dataclass(frozen=True, slots=True)
class Refusal:
    """Answer: a sentence that says why there is no time."""

    sentence: str


Request: TypeAlias = Now | Sleep
Answer: TypeAlias = Time | Refusal


def encode(message: Request | Answer) -> bytes:
    """Return the line of a message; raises ValueError when a number is not finite."""
    match message:
        case Now():
            document: dict[str, str | float] = {"op": "now"}
        case Sleep(duration_s):
            document = {"op": "sleep", "s": duration_s}
        case Time(now_s):
            document = {"now_s": now_s}
        case Refusal(sentence):
            document = {"error": sentence}
    return json.dumps(document, allow_nan=False).encode() + b"\n"


def decode_request(line: bytes) -> Request:
    """Read a request; raises ClockProtocolError with a sentence for its sender."""
    match _decode_object(line):
        case {"op": "now"}:
            return Now()
        case {"op": "sleep", "s": duration}:
            duration_s = _finite(duration, "s")
            if duration_s < 0.0:
                raise ClockProtocolError(
                    f"s is {duration_s}: the clock cannot go back, give 0 or more seconds"
                )
            return Sleep(duration_s)
        case {"op": "sleep"}:
            raise ClockProtocolError('op "sleep" needs the key "s", a duration in seconds')
        case _:
            raise ClockProtocolError('a request is {"op": "now"} or {"op": "sleep", "s": seconds}')


def decode_answer(line: bytes) -> Answer:
    """Read an answer; raises ClockProtocolError."""
    match _decode_object(line):
        case {"now_s": now}:
            return Time(_finite(now, "now_s"))
        case {"error": str(sentence)}:
            return Refusal(sentence)
        case other:
            raise ClockProtocolError(f"the clock answered {other!r}; now_s or error was expected")


class LineReader:
    """Reassembles lines from a byte stream; serves both sides of the wire."""

    def __init__(self) -> None:
        self._buffer = bytearray()

    @property
    def inside_line(self) -> bool:
        """Whether the stream stands in the middle of a line."""
        return bool(self._buffer)

    def receive_data(self, data: bytes) -> None:
        """Append what the stream delivered."""
        self._buffer += data

    def next_line(self) -> bytes | None:
        """Take the oldest whole line without its end, None until more bytes arrive.

        Raises ClockProtocolError when a line does not end.
        """
        end = self._buffer.find(b"\n")
        if (end if end >= 0 else len(self._buffer)) > LONGEST_LINE_BYTES:
            raise ClockProtocolError(
                f"a line of more than {LONGEST_LINE_BYTES} bytes: is this the clock's port?"
            )
        if end < 0:
            return None
        line = bytes(self._buffer[:end])
        del self._buffer[: end + 1]
        return line


def _decode_object(line: bytes) -> dict[str, object]:
    try:
        document = json.loads(line)
    except ValueError as error:
        raise ClockProtocolError(f"{line[:80]!r} is no JSON: {error}") from error
    if not isinstance(document, dict):
        raise ClockProtocolError(f"{line[:80]!r} is no JSON object")
    return document


def _finite(value: object, key: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ClockProtocolError(f"{key} is {value!r}; a number of seconds was expected")
    return float(value)
