"""Remote commands of Mitutoyo's ID-H indicators, whose mnemonics the EH and EV counters share.

Source: manual 99MAH016B of the ID-H: ``GA01`` asks for the value of channel 1, answered
``GN01,+0016.2345`` (GX and GM: its greatest and least, GW: their difference). That EH counters answer
refusals with ``CE01`` and a code is general knowledge.
"""

import re
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from truepose_drivers.line_gauges.protocol import LineGaugeError, TextLines, Value, read_value, write_value

MOST_CHANNELS: Final = 99  # two digits
Ends: TypeAlias = Literal["CR LF", "CR", "LF"]
ENDS: Final[dict[str, bytes]] = {"CR LF": b"\r\n", "CR": b"\r", "LF": b"\n"}

_VALUE: Final = re.compile(r"G([NXMW])(\d\d),([+-](?=[\d.]{6,9}$)\d+\.?\d*)")
_REFUSED: Final = re.compile(r"CE(\d\d)[ ,]?(\w{0,4})")
_DONE: Final = re.compile(r"CH(\d\d)")
_QUESTION: Final = re.compile(r"([A-Z]{2})(\d\d)(?:,(.*))?")
_FIELD_WIDTH: Final = 9


@dataclass(frozen=True, slots=True)
class CounterValue:
    """What a channel displays; `mode` N is the value itself, X, M and W its greatest, least and span."""

    channel: int
    value: Value
    mode: str = "N"


@dataclass(frozen=True, slots=True)
class Refusal:
    """The counter has no value, or does not know the command."""

    channel: int
    code: str


@dataclass(frozen=True, slots=True)
class Done:
    """The counter did what it was told."""

    channel: int


@dataclass(frozen=True, slots=True)
class Question:
    """A command with its channel, such as GA01."""

    mnemonic: str
    channel: int


Reply: TypeAlias = CounterValue | Refusal | Done


def encode_question(question: Question, end: bytes) -> bytes:
    """Return the characters of a question."""
    return f"{question.mnemonic}{question.channel:02d}".encode() + end


def encode(reply: Reply, end: bytes) -> bytes:
    """Return the characters of a reply."""
    match reply:
        case CounterValue(channel, value, mode):
            line = f"G{mode}{channel:02d},{write_value(value, _FIELD_WIDTH)}"
        case Refusal(channel, code):
            line = f"CE{channel:02d},{code}"
        case Done(channel):
            line = f"CH{channel:02d}"
    return line.encode("ascii") + end


def decode(line: str) -> Reply:
    """Read a line without its end; raises LineGaugeError."""
    if match := _VALUE.fullmatch(line):
        return CounterValue(int(match[2]), read_value(match[3]), match[1])
    if match := _REFUSED.fullmatch(line):
        return Refusal(int(match[1]), match[2])
    if match := _DONE.fullmatch(line):
        return Done(int(match[1]))
    raise LineGaugeError(
        f"{line[:40]!r} is not a line from an EH counter: check its rate and its output mode"
    )


def decode_question(line: str) -> Question | None:
    """Read a question, None for one that the counter does not know."""
    match = _QUESTION.fullmatch(line)
    return None if match is None else Question(match[1], int(match[2]))


def reply_reader() -> TextLines[Reply]:
    """Return the client's side of the wire."""
    return TextLines(decode)
