"""Wire protocol of the cell's clock: one JSON object a line, UTF-8, one answer to each request.

``{"op": "now"}`` and ``{"op": "sleep", "s": 4.0}`` are answered ``{"now_s": 12.5}``, or
``{"error": "..."}`` with a sentence.
"""

from dataclasses import dataclass
from typing import TypeAlias

from truepose_drivers.framing import (
    JsonLineError,
    Refusal,
    decode_object,
    encode_object,
    encode_refusal,
    finite_number,
)

_LONGEST_SLEEP_S = 1e9  # thirty years


class ClockProtocolError(JsonLineError):
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
        case Refusal():
            return encode_refusal(message)
    return encode_object(document)


def decode_request(line: bytes) -> Request:
    """Read a request; raises JsonLineError with a sentence for its sender."""
    match decode_object(line):
        case {"op": "now"}:
            return Now()
        case {"op": "sleep", "s": duration}:
            duration_s = _finite(duration, "s")
            # Beyond that the time of a cell that does not wait would have no end.
            if not 0.0 <= duration_s <= _LONGEST_SLEEP_S:
                raise ClockProtocolError(f"s is {duration_s}: give 0 to {_LONGEST_SLEEP_S:g} seconds")
            return Sleep(duration_s)
        case {"op": "sleep"}:
            raise ClockProtocolError('op "sleep" needs the key "s", a duration in seconds')
        case _:
            raise ClockProtocolError('a request is {"op": "now"} or {"op": "sleep", "s": seconds}')


def decode_answer(line: bytes) -> Answer:
    """Read an answer; raises JsonLineError."""
    match decode_object(line):
        case {"now_s": now}:
            return Time(_finite(now, "now_s"))
        case {"error": str(sentence)}:
            return Refusal(sentence)
        case other:
            raise ClockProtocolError(f"the clock answered {other!r}; now_s or error was expected")


def _finite(value: object, key: str) -> float:
    number = finite_number(value)
    if number is None:
        raise ClockProtocolError(f"{key} is {str(value)[:40]}; a number of seconds was expected")
    return number
