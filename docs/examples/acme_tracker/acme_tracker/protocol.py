"""Wire protocol of the ACME tracker: one line of ASCII each way. No I/O here.

Source: invented for this example; a real driver names manual, revision and section. A point states its
number, its unit and the face that it was measured in, so that none of them has to be remembered.
"""

import math
from dataclasses import dataclass
from typing import Literal

from truepose_drivers.errors import DeviceRefusedError, NotInitialisedError, RemoteProtocolError


@dataclass(frozen=True, slots=True)
class Reply:
    """The answer's first word and the words after it."""

    word: str
    rest: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Point:
    """What a measurement came to, in mm."""

    number: int  # counts the measurements since the tracker was switched on
    face: Literal[1, 2]
    numbers: tuple[float, ...]  # x y z, their standard deviations, and the scatter


def encode(word: str, *values: float) -> bytes:
    """Return a request line."""
    return " ".join([word, *(f"{value:.4f}" for value in values)]).encode("ascii") + b"\n"


def decode(line: str) -> Reply:
    """Return the answer of a line; raises DeviceRefusedError, RemoteProtocolError."""
    words = line.split()
    if not words:
        raise RemoteProtocolError("the tracker sent an empty line")
    if words[0] == "REFUSED":
        raise DeviceRefusedError(f"the tracker refused: {' '.join(words[1:]) or 'without a reason'}")
    return Reply(words[0], tuple(words[1:]))


def expected(reply: Reply, word: str, count: int) -> tuple[str, ...]:
    """Return the words after the one that belongs there; raises RemoteProtocolError."""
    if reply.word != word or len(reply.rest) != count:
        raise RemoteProtocolError(f"the tracker answered {reply} where {word} belongs")
    return reply.rest


def point(reply: Reply) -> Point:
    """Read `POINT number unit face` and seven numbers; raises NotInitialisedError for another unit."""
    number, unit, face, *texts = expected(reply, "POINT", 10)
    if unit != "mm":
        raise NotInitialisedError(
            f"the tracker measures in {unit!r}: another program set that; initialise it"
        )
    if face not in {"1", "2"}:
        raise RemoteProtocolError(f"the tracker reports face {face}")
    return Point(_whole(number), 1 if face == "1" else 2, finite(texts))


def finite(texts: tuple[str, ...] | list[str]) -> tuple[float, ...]:
    """Return finite numbers with four decimals; raises RemoteProtocolError.

    One with more or fewer of them has lost a digit, or has one twice.
    """
    try:
        values = tuple(float(text) for text in texts if len(text.partition(".")[2]) == 4)
    except ValueError as error:
        raise RemoteProtocolError(f"the tracker sent {texts} where numbers belong") from error
    if len(values) != len(texts) or not all(map(math.isfinite, values)):
        raise RemoteProtocolError(f"the tracker sent {texts}; finite numbers with four decimals belong there")
    return values


def _whole(text: str) -> int:
    if not text.isdecimal():
        raise RemoteProtocolError(f"the tracker numbers its measurement {text!r}")
    return int(text)
