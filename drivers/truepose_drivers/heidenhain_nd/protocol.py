"""Remote commands of the Heidenhain ND 2xx B and ND 287 counters: characters in, replies out.

Source: user's manuals ND 281 B, ND 231 B and ND 221 B, section "Remote operation over the data interface",
and the public client of ND 287 in pymeasure. A command is ESC, a letter, four digits and CR. Answers to A
commands begin with STX and end with CR LF; all others are answered ACK or NAK.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from truepose_drivers.errors import RemoteProtocolError
from truepose_drivers.framing import StreamReader

STX, ENQ, ACK, DC1, DC3, NAK, ESC = 0x02, 0x05, 0x06, 0x11, 0x13, 0x15, 0x1B
_CR, _LF = 0x0D, 0x0A
COUNTS_PER_MM = 10_000  # A0200 leaves the decimal point out: 0.1 um a count in millimetres,
COUNTS_PER_INCH = 100_000  # and a hundredth of a thousandth in inches
MM_PER_INCH = 25.4
BUFFER_CHARACTERS = 100  # of the counter; beyond it sends XOFF
_LONGEST_REPLY = 80  # the longest line known has 36 characters

_VALUE = re.compile(r"[+-]\d{9}")
_LAMPS = re.compile(r"[012]{7,14}")  # ND 281 B shows 14, ND 231 B 10, ND 221 B 7 of them
_COMMAND = re.compile(r"[A-Z]\d{4}")
_TEXT_WIDTH = 13
# Of ND 2xx B by their manual; of ND 287 by the 36 bytes that its client reads.
_TEXT_WIDTHS = (_TEXT_WIDTH, 33)
_FIELD_WIDTH = 10
_HIGHEST_COUNT = 999_999_999


class NdProtocolError(RemoteProtocolError):
    """The counter sent something that its manual does not know."""


@dataclass(frozen=True, slots=True)
class Command:
    """A remote command, such as `A0200`."""

    code: str


@dataclass(frozen=True, slots=True)
class Control:
    """A control character outside a command: STX asks for a print, ENQ for the error, DC3 and DC1 hold."""

    character: int


@dataclass(frozen=True, slots=True)
class Unreadable:
    """Characters that are no command."""

    data: bytes


Request: TypeAlias = Command | Control | Unreadable

IDENTITY = Command("A0000")
DISPLAY = Command("A0100")
VALUE = Command("A0200")
ERROR_TEXT = Command("A0301")
SOFTWARE = Command("A0400")
LAMPS = Command("A0800")


@dataclass(frozen=True, slots=True)
class Acknowledgement:
    """ACK."""


@dataclass(frozen=True, slots=True)
class Refusal:
    """NAK: the command is unknown, or makes no sense now."""


@dataclass(frozen=True, slots=True)
class Line:
    """A line of text; `opened` when STX stood before it."""

    text: str
    opened: bool = True


Reply: TypeAlias = Acknowledgement | Refusal | Line


@dataclass(frozen=True, slots=True)
class Lamps:
    """The status indicators that matter to a length."""

    inch: bool = False
    below: bool = False  # sorting mode: less than the lower limit
    inside: bool = False
    above: bool = False  # sorting mode: more than the upper limit
    reference: bool = False  # REF


def encode_request(request: Command | Control) -> bytes:
    """Return the characters of a request."""
    if isinstance(request, Control):
        return bytes([request.character])
    return bytes([ESC]) + request.code.encode("ascii") + bytes([_CR])


def encode_reply(reply: Reply) -> bytes:
    """Return the characters of a reply."""
    match reply:
        case Acknowledgement():
            return bytes([ACK])
        case Refusal():
            return bytes([NAK])
        case Line(text, opened):
            return bytes([STX] * opened) + text.encode("ascii", "replace") + bytes([_CR, _LF])


def identity_lines(model: str, software: str, released: str) -> tuple[Line, ...]:
    """Answer to A0000: three fields of ten characters under one STX."""
    return tuple(
        Line(field.ljust(_FIELD_WIDTH)[:_FIELD_WIDTH], opened=number == 0)
        for number, field in enumerate((model, software, released))
    )


def value_line(count: int) -> Line:
    """Answer to A0200; a count beyond nine digits shows its largest."""
    limited = max(-_HIGHEST_COUNT, min(_HIGHEST_COUNT, count))
    return Line(f"{limited:+010d}")


def error_line(text: str) -> Line:
    """Answer to A0301, thirteen characters."""
    return Line(text.ljust(_TEXT_WIDTH)[:_TEXT_WIDTH])


def display_line(count: int) -> Line:
    """Answer to A0100 while a value is displayed: sign, digits and the decimal point."""
    return Line(_decimal(count).rjust(_FIELD_WIDTH))


def printed_line(count: int, lamps: Lamps) -> Line:
    """Answer to STX: sign, value of ten characters, blank, unit, sorting status."""
    unit = "R" if lamps.reference else " "
    shown = _decimal(count)
    return Line(f"{shown[0]}{shown[1:]:>10} {unit}{_sorting(lamps)}", opened=False)


def lamps_line(lamps: Lamps) -> Line:
    """Answer to A0800: 0 dark, 1 lit, 2 blinking, in the order of the ND 281 B."""
    lit = [False] * 14
    lit[0], lit[1], lit[6] = lamps.reference, True, lamps.inch
    lit[7], lit[8], lit[9] = lamps.below, lamps.inside, lamps.above
    return Line("".join("01"[lamp] for lamp in lit))


def reply_kind(line: Line) -> Literal["value", "lamps", "text"]:
    """Tell what a line under STX answers by its form, every one of which has its width.

    Raises NdProtocolError for a line that answers nothing: characters were lost, or came twice.
    """
    if _VALUE.fullmatch(line.text):
        return "value"
    if _LAMPS.fullmatch(line.text):
        return "lamps"
    if len(line.text) in _TEXT_WIDTHS and line.text.isprintable():
        return "text"
    raise NdProtocolError(
        f"{line.text[:40]!r} is neither a value nor an error nor the status indicators of a counter:"
        " check cable, baud rate, data bits and parity"
    )


def decode_count(line: Line) -> int:
    """Read the answer to A0200; raises NdProtocolError."""
    if not _VALUE.fullmatch(line.text):
        raise NdProtocolError(f"the counter answered A0200 with {line.text!r}; expected a sign and 9 digits")
    return int(line.text)


def decode_lamps(line: Line) -> Lamps:
    """Read the answer to A0800; raises NdProtocolError."""
    if not _LAMPS.fullmatch(line.text):
        raise NdProtocolError(f"the counter answered A0800 with {line.text!r}; expected digits 0 to 2")
    lit = [character != "0" for character in line.text.ljust(14, "0")]
    return Lamps(reference=lit[0], inch=lit[6], below=lit[7], inside=lit[8], above=lit[9])


def is_identity_line(line: Line, number: int) -> bool:
    """Whether a line may be field `number` (from 0) of the answer to A0000."""
    return len(line.text) == _FIELD_WIDTH and line.text.isprintable() and line.opened == (number == 0)


def decode_identity(lines: Sequence[Line]) -> tuple[str, str, str]:
    """Read model, software number and its date."""
    model, software, released = (line.text.strip() for line in lines)
    return model, software, released


def to_mm(count: int, lamps: Lamps) -> float:
    """Length of a count, by the unit that is displayed [mm]."""
    return count / COUNTS_PER_INCH * MM_PER_INCH if lamps.inch else count / COUNTS_PER_MM


class RequestReader(StreamReader):
    """Reassembles what a client sends: the counter's side of the wire."""

    def next_message(self) -> Request | None:
        """Take the oldest whole request, None until more characters arrive."""
        if not self._buffer:
            return None
        if self._buffer[0] != ESC:
            return self._control()
        end = self._buffer.find(_CR)
        # A command without an end is given up when it would have filled the counter's buffer.
        if end < 0 and len(self._buffer) <= BUFFER_CHARACTERS:
            return None
        data = self._take(end + 1 if end >= 0 else len(self._buffer))
        code = data[1:-1].decode("ascii", "replace")
        return Command(code) if _COMMAND.fullmatch(code) else Unreadable(data)

    def _control(self) -> Request:
        character = self._take(1)
        if character[0] in (STX, ENQ, DC1, DC3):
            return Control(character[0])
        return Unreadable(character)


class ReplyReader(StreamReader):
    """Reassembles what the counter sends: the client's side of the wire."""

    def receive_data(self, data: bytes) -> None:
        """Append what the line delivered; flow control is no reply."""
        super().receive_data(data.translate(None, bytes([DC1, DC3])))

    def next_message(self) -> Reply | None:
        """Take the oldest whole reply, None until more characters arrive; raises NdProtocolError."""
        if not self._buffer:
            return None
        if self._buffer[0] in (ACK, NAK):
            return Acknowledgement() if self._buffer.pop(0) == ACK else Refusal()
        end = self._buffer.find(b"\r\n")
        if (end if end >= 0 else len(self._buffer)) > _LONGEST_REPLY:
            raise NdProtocolError(
                f"{bytes(self._buffer[:20])!r}... is not a reply from a counter:"
                " check baud rate, data bits and parity"
            )
        if end < 0:
            return None
        data = self._take(end, drop=2)
        opened = data.startswith(bytes([STX]))
        return Line(_ascii(data[opened:]), opened)


def _ascii(data: bytes) -> str:
    try:
        return data.decode("ascii")
    except UnicodeDecodeError as error:
        raise NdProtocolError(
            f"{data[:20]!r} is not text: check baud rate, data bits and parity of counter and port"
        ) from error


def _decimal(count: int) -> str:
    return f"{count / COUNTS_PER_MM:+.4f}"


def _sorting(lamps: Lamps) -> str:
    return "<" * lamps.below or ">" * lamps.above or "=" * lamps.inside or " "
