"""Commands of Keyence's communication units DL-RS1A and DL-EN1 for GT2 amplifiers.

Source: manuals of the DL-RS1A. ``MS`` CR is answered by output state and value of all amplifiers in the order
of their numbers, ``MS,04,+00012.345,04,-00000.001`` CR LF; ``M0`` by the values alone; ``ER,MS,ee`` refuses.
That the DL-EN1 speaks the same text on TCP is general knowledge.
"""

import re
from dataclasses import dataclass
from typing import Final, TypeAlias

from truepose_drivers.line_gauges.protocol import LineGaugeError, TextLines, Value, read_value, write_value

VALUES: Final = "M0"
STATES_AND_VALUES: Final = "MS"
INVALID_COMMAND: Final = "00"
HIGH, LOW, BOTH, GO = 1, 2, 3, 4  # output states; 0 is off
MOST_AMPLIFIERS: Final = 15

_VALUE: Final = re.compile(r"[+-](?=[\d.]{6,10}$)\d+\.\d+")
# How an amplifier without a valid value is reported is not in the manuals at hand. Dashes, and a display
# full of nines, count as none; anything else that is no number is refused.
_NO_VALUE: Final = re.compile(r"[+-]?(-+\.?-*|9+\.9+)")  # a row of dashes, or as far as the display goes
_STATE: Final = re.compile(r"0?[0-4]")
_ERROR: Final = re.compile(r"ER,(\w{2}),(\d\d)")
_FIELD_WIDTH: Final = 9
_DASHES: Final = "+-----.---"


@dataclass(frozen=True, slots=True)
class Amplifier:
    """What one amplifier says."""

    value: Value | None
    state: int = 0


@dataclass(frozen=True, slots=True)
class Amplifiers:
    """What all of them say, in the order of their numbers."""

    command: str
    all: tuple[Amplifier, ...]


@dataclass(frozen=True, slots=True)
class Refusal:
    """The unit refuses a command."""

    command: str
    code: str


Reply: TypeAlias = Amplifiers | Refusal


def encode_question(command: str) -> bytes:
    """Return the characters of a command."""
    return command.encode() + b"\r"


def encode(reply: Reply) -> bytes:
    """Return the characters of a reply."""
    match reply:
        case Refusal(command, code):
            fields = ["ER", command, code]
        case Amplifiers(command, amplifiers):
            fields = [command]
            for amplifier in amplifiers:
                state = [f"{amplifier.state:02d}"] if command == STATES_AND_VALUES else []
                fields += [*state, _text(amplifier.value)]
    return ",".join(fields).encode("ascii") + b"\r\n"


def decode(line: str) -> Reply:
    """Read a line without its end; raises LineGaugeError."""
    if match := _ERROR.fullmatch(line):
        return Refusal(match[1], match[2])
    command, *fields = line.split(",")
    if command == VALUES and fields:
        return Amplifiers(command, tuple(Amplifier(_value(field, line)) for field in fields))
    if command == STATES_AND_VALUES and fields and len(fields) % 2 == 0:
        pairs = zip(fields[::2], fields[1::2], strict=True)
        return Amplifiers(
            command, tuple(Amplifier(_value(text, line), _state(state, line)) for state, text in pairs)
        )
    raise _unknown(line)


def _value(text: str, line: str) -> Value | None:
    if _NO_VALUE.fullmatch(text):
        return None
    if _VALUE.fullmatch(text):
        return read_value(text)
    raise _unknown(line)


def _state(text: str, line: str) -> int:
    if _STATE.fullmatch(text):
        return int(text)
    raise _unknown(line)


def _text(value: Value | None) -> str:
    return _DASHES if value is None else write_value(value, _FIELD_WIDTH)


def _unknown(line: str) -> LineGaugeError:
    return LineGaugeError(f"{line[:40]!r} is not an answer from a Keyence unit: is this its port?")


def reply_reader() -> TextLines[Reply]:
    """Return the client's side of the wire."""
    return TextLines(decode)
