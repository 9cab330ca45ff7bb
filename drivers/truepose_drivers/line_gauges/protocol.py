"""Lines of text that boxes of gauges send, and the values in them; no I/O.

A digit that was lost, one that came twice and a gauge that shows inches give a number of another form: of
another width, or with other digits behind the point. So a number is taken only in the form of all others.

Source: Mitutoyo's manual 99MAF600B and the public clients pytuyo and mitutoyo_reader: 0, channel, A, sign,
and a number of eight or nine characters.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final, Generic, TypeAlias, TypeVar

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.framing import StreamReader

Message = TypeVar("Message")

_ENDS = b"\r\n"
_LONGEST_LINE = 400  # of fifteen amplifiers with their output states


class LineGaugeError(RemoteProtocolError):
    """A gauge sent a line that its manual does not know."""


class TextLines(StreamReader, Generic[Message]):
    """Puts lines together and reads each of them with `decode`; serves both sides of the wire."""

    def __init__(self, decode: Callable[[str], Message]) -> None:
        super().__init__()
        self._decode = decode

    @property
    def inside_message(self) -> bool:
        """Whether more stands here than was taken; the second half of an end of line is nothing."""
        return bool(self._buffer.lstrip(_ENDS))

    def next_message(self) -> Message | None:
        """Take the oldest whole line, None until more arrives; raises RemoteProtocolError."""
        # Makers end lines with CR, LF or both. So the LF of a CR LF stands before the line that follows.
        del self._buffer[: len(self._buffer) - len(self._buffer.lstrip(_ENDS))]
        end = min((at for at in map(self._buffer.find, (b"\r", b"\n")) if at >= 0), default=-1)
        if (end if end >= 0 else len(self._buffer)) > _LONGEST_LINE:
            raise LineGaugeError(
                f"{bytes(self._buffer[:20])!r}... does not end: check the rate, and what is on this line"
            )
        return None if end < 0 else self._decode(_ascii(self._take(end, drop=1)))


def _ascii(line: bytes) -> str:
    try:
        return line.decode("ascii")
    except UnicodeDecodeError as error:
        raise LineGaugeError(f"{line[:20]!r} is not text: check rate, data bits and parity") from error


_FIELD_WIDTH: Final = 9
_FINEST_DECIMALS: Final = 4  # in millimetres, 0.1 um: with more of them a gauge shows inches
MOST_LESSONS: Final = 3  # values that may follow each other without agreeing
MOST_DECIMALS: Final = 6  # that fit the field

_Form: TypeAlias = tuple[int, int]  # characters behind the sign, digits behind the point


@dataclass(frozen=True, slots=True)
class Value:
    """What the gauge displays, in its own unit; `decimals` digits stand behind the point."""

    shown: float
    decimals: int
    width: int = field(default=_FIELD_WIDTH, compare=False)  # characters behind the sign, as they came

    @property
    def form(self) -> _Form:
        """Characters behind the sign, and digits behind the point."""
        return self.width, self.decimals


def read_value(sign_and_digits: str) -> Value:
    """Read a signed number as a display writes it, such as `+0000.123`."""
    whole, _, decimals = sign_and_digits[1:].partition(".")
    return Value(float(f"{sign_and_digits[0]}{whole}.{decimals}"), len(decimals), len(sign_and_digits) - 1)


def write_value(value: Value, width: int = _FIELD_WIDTH) -> str:
    """Return sign and digits in a field of `width` characters."""
    return f"{'-' if value.shown < 0.0 else '+'}{abs(value.shown):0{width}.{value.decimals}f}"


class ValueForm:
    """The form of one gauge's values, stated or learnt from values that follow each other and agree."""

    def __init__(self, decimals: int | None, error: type[RemoteProtocolError]) -> None:
        """Prepare; `decimals` stand behind the point in millimetres, learnt unless given."""
        self._stated_decimals = decimals
        self._error = error
        self._form: _Form | None = None

    @property
    def known(self) -> bool:
        """Whether it was learnt."""
        return self._form is not None

    @property
    def resolution_mm(self) -> float:
        """Of the last digit; the finest there is until the form is known."""
        return 10.0 ** -(_FINEST_DECIMALS if self._form is None else self._form[1])

    def learn(self, before: Value, after: Value) -> None:
        """Take the form of two values that follow each other, where they agree and may be millimetres."""
        # Learnt once and then kept, over connections too: a key pressed later may have changed the unit, and
        # the line does not tell the unit.
        if self._form is None and before.form == after.form and before.decimals in self._acceptable_decimals:
            self._form = before.form

    def require(self, value: Value) -> None:
        """See that a value has the form of all others; raises the error given."""
        if value.form != self._form:
            raise self._error(
                f"the gauge sends {value.decimals} decimal places, {value.width} characters in all,"
                f" instead of {self._expected}: it shows inches, or characters were lost; set it to"
                " millimetres, and for another gauge on this cable start the service again"
            )

    @property
    def _acceptable_decimals(self) -> Sequence[int]:
        if self._stated_decimals is not None:
            return (self._stated_decimals,)
        return range(_FINEST_DECIMALS + 1)

    @property
    def _expected(self) -> str:
        if self._form is not None:
            width, decimals = self._form
            return f"{decimals} and {width}"
        return " or ".join(map(str, self._acceptable_decimals))


_VALUE: Final = re.compile(r"0(\d)A([+-](?=[\d.]{8,9}$)\d+\.?\d*)")
_ERROR: Final = re.compile(r"(9\d\d)")

NOT_CONNECTED: Final = 911  # no gauge on the cable, or it is off and says nothing
NOT_CONVERTIBLE: Final = 912  # the gauge sent something that is no value


def data_line(channel: int, value: Value, width: int) -> str:
    """Return the line of a value."""
    return f"0{channel}A{write_value(value, width)}"


def read_data_line(line: str) -> tuple[int, Value] | None:
    """Return channel and value of a line, None for one that is no data line."""
    match = _VALUE.fullmatch(line)
    return None if match is None else (int(match[1]), read_value(match[2]))


def read_error_line(line: str) -> int | None:
    """Return the number of an error line, None for one that is none."""
    match = _ERROR.fullmatch(line)
    return None if match is None else int(match[1])
