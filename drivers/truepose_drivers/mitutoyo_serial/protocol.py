"""What Mitutoyo's serial boxes say: MUX-10F, DMX, IT-007R, and input tools as a virtual serial port.

Source: manual 99MAF600B. ``1`` CR asks for channel 1, answered ``01A+0000.123`` CR, or ``91n`` CR where the
channel has no value.
"""

from dataclasses import dataclass
from typing import Final, TypeAlias

from truepose_drivers.line_gauges.protocol import (
    LineGaugeError,
    TextLines,
    Value,
    data_line,
    read_data_line,
    read_error_line,
)

MOST_CHANNELS: Final = 9  # one digit
_FIELD_WIDTH: Final = 8  # manual: D5 to D12


@dataclass(frozen=True, slots=True)
class ChannelValue:
    """What the gauge on a channel displays."""

    channel: int
    value: Value


@dataclass(frozen=True, slots=True)
class NoValue:
    """The box has no value: 911, 912, ..."""

    number: int


Reply: TypeAlias = ChannelValue | NoValue


def encode_question(channel: int) -> bytes:
    """Return the question for a channel's value."""
    return f"{channel}\r".encode()


def encode(reply: Reply) -> bytes:
    """Return the characters of a reply."""
    match reply:
        case ChannelValue(channel, value):
            line = data_line(channel, value, _FIELD_WIDTH)
        case NoValue(number):
            line = f"{number}"
    return line.encode("ascii") + b"\r"


def decode(line: str) -> Reply:
    """Read a line without its end; raises LineGaugeError."""
    if (data := read_data_line(line)) is not None:
        return ChannelValue(*data)
    if (number := read_error_line(line)) is not None:
        return NoValue(number)
    raise LineGaugeError(f"{line[:40]!r} is not a line from a Mitutoyo box: check its rate")


def reply_reader() -> TextLines[Reply]:
    """Return the client's side of the wire."""
    return TextLines(decode)
