"""The ballbar behind a Heidenhain ND 28x counter: its display, its keys and its remote commands.

The counter sorts by the range of the bar: beyond it `<` or `>` lights up. Without a signal it displays an
error, keeps its value to itself and says why when asked. With its cable out the line is dead.
"""

import asyncio
import math
from collections.abc import Sequence

from truepose_drivers.heidenhain_nd.protocol import (
    COUNTS_PER_INCH,
    COUNTS_PER_MM,
    DC1,
    DC3,
    ENQ,
    MM_PER_INCH,
    STX,
    Acknowledged,
    Command,
    Control,
    Lamps,
    Line,
    Refused,
    Reply,
    Request,
    RequestReader,
    display_line,
    encode_reply,
    error_line,
    identity_lines,
    lamps_line,
    printed_line,
    value_line,
)
from truepose_simulators.faults.wire import BallbarInches, BallbarKeyPressed, LineDoublesDigits, LineStalls
from truepose_simulators.instruments.ballbars.bad_lines import with_doubled_digit, write_with_stall
from truepose_simulators.instruments.ballbars.length_source import Electronics, Shown
from truepose_simulators.instruments.endpoint import Endpoint

_CHUNK_BYTES = 4096
_MODEL, _SOFTWARE, _RELEASED = "ND-287", "349797-04", "2001-05-04"
_NO_SIGNAL, _TOO_FAST = "SIGNAL ERROR", "FREQU. ERROR"
_MOST_DIGITS = 9
_DIGIT_KEYS = frozenset(f"T000{digit}" for digit in range(10))
_MOST_HELD_BYTES = 4096  # a client that holds the counter back and goes on asking loses answers


class Counter:
    """The counter itself: what its keys have set, and what it answers."""

    def __init__(self, bar: Electronics) -> None:
        self._bar = bar
        self._datum = 0  # counts taken off what the transducer shows
        self._entry = ""  # typed and not entered yet
        self._reference = False
        self._answers = {
            "A0000": lambda: identity_lines(_MODEL, _SOFTWARE, _RELEASED),
            "A0100": self._display,
            "A0200": self._value,
            "A0301": self._error_text,
            "A0400": lambda: (Line(_SOFTWARE.ljust(10)),),
            "A0800": lambda: (lamps_line(self._lamps(self._sample())),),
            "F0000": self._toggle_reference,
            "F0001": self._print_after_acknowledging,
            "F0002": self._print_after_acknowledging,
            "S0000": self._reset,
            "S0001": _acknowledge,  # the keys on its front, which nobody presses here
            "S0002": _acknowledge,
        }

    @property
    def plugged(self) -> bool:
        """Whether anything reaches it."""
        return self._bar.plugged

    def answer(self, request: Request) -> Sequence[Reply]:
        """Return the replies to a request, oldest first."""
        if isinstance(request, Control):
            return self._control(request.character)
        if not isinstance(request, Command):
            return (Refused(),)
        if request.code.startswith("T"):
            return self._press(request.code)
        answer = self._answers.get(request.code)
        return (Refused(),) if answer is None else answer()

    def _control(self, character: int) -> Sequence[Reply]:
        return {STX: self._print, ENQ: self._error_text}.get(character, _refuse)()

    def _press(self, code: str) -> Sequence[Reply]:
        """Press a key: digits, sign and point make up an entry, which ENTER takes over as the datum."""
        match code:
            case "T0100":
                self._entry = ""
            case "T0101":
                self._entry = self._entry[1:] if self._entry.startswith("-") else f"-{self._entry}"
            case "T0102" if "." not in self._entry:
                self._entry += "."
            case "T0104":
                self._enter()
            case _ if code in _DIGIT_KEYS and len(self._entry) < _MOST_DIGITS:
                self._entry += code[-1]
            case _:
                return (Refused(),)
        return (Acknowledged(),)

    def _enter(self) -> None:
        typed, self._entry = self._entry, ""
        sample = self._sample()
        if any(character.isdigit() for character in typed) and sample.signal != "none":
            self._datum = round(sample.deviation_mm * COUNTS_PER_MM) - round(float(typed) * COUNTS_PER_MM)

    def _sample(self) -> Shown:
        return self._bar.show()

    def _count(self, sample: Shown) -> int | None:
        if sample.signal == "none" or math.isnan(sample.deviation_mm):
            return None
        count = round(sample.deviation_mm * COUNTS_PER_MM) - self._datum
        if not self._bar.has(BallbarInches):
            return count
        return round(count / COUNTS_PER_MM / MM_PER_INCH * COUNTS_PER_INCH)

    def _lamps(self, sample: Shown) -> Lamps:
        out = sample.signal == "out_of_range"
        return Lamps(
            below=out and sample.deviation_mm < 0.0,
            inside=sample.signal == "good",
            above=out and sample.deviation_mm > 0.0,
            inch=self._bar.has(BallbarInches),
            reference=self._reference,
        )

    def _display(self) -> Sequence[Reply]:
        sample = self._sample()
        count = self._count(sample)
        return (_error(sample) if count is None else display_line(count),)

    def _value(self) -> Sequence[Reply]:
        count = self._count(self._sample())
        return (Refused() if count is None else value_line(count),)

    def _error_text(self) -> Sequence[Reply]:
        sample = self._sample()
        return (_error(sample) if self._count(sample) is None else Refused(),)

    def _print(self) -> Sequence[Reply]:
        sample = self._sample()
        count = self._count(sample)
        return (Refused() if count is None else printed_line(count, self._lamps(sample)),)

    def _print_after_acknowledging(self) -> Sequence[Reply]:
        return (Acknowledged(), *self._print())

    def _toggle_reference(self) -> Sequence[Reply]:
        self._reference = not self._reference
        return (Acknowledged(),)

    def _reset(self) -> Sequence[Reply]:
        """Start again as after switching it on: without reference marks no datum is kept."""
        self._datum, self._entry, self._reference = 0, "", False
        return (Acknowledged(),)


def _error(sample: Shown) -> Line:
    return error_line(_TOO_FAST if sample.too_fast else _NO_SIGNAL)


def _acknowledge() -> Sequence[Reply]:
    return (Acknowledged(),)


def _refuse() -> Sequence[Reply]:
    return (Refused(),)


def _on_the_line(bar: Electronics, said: bytes) -> bytes:
    return with_doubled_digit(said) if bar.has(LineDoublesDigits) else said


def nd28x_endpoint(bar: Electronics) -> Endpoint:
    """Build the endpoint of a counter; every connection reaches the same one."""
    counter = Counter(bar)

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        requests, outbox, holding = RequestReader(), bytearray(), False
        while data := await reader.read(_CHUNK_BYTES):
            if not counter.plugged:
                requests = RequestReader()
                continue
            requests.receive_data(data)
            while (request := requests.next_message()) is not None:
                if request in (Control(DC1), Control(DC3)):
                    holding = request == Control(DC3)
                elif len(outbox) < _MOST_HELD_BYTES:
                    outbox += _on_the_line(bar, b"".join(map(encode_reply, counter.answer(request))))
            if not holding:
                said = bytes(outbox)
                outbox.clear()
                if bar.has(BallbarKeyPressed):
                    said = b"".join(map(encode_reply, counter.answer(Control(STX)))) + said
                if bar.has(LineStalls):
                    await write_with_stall(writer, said)
                else:
                    writer.write(said)
            await writer.drain()

    return Endpoint("ballbar", "nd28x", serve)
