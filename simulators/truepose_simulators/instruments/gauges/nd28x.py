"""The ballbar behind a Heidenhain ND 28x counter: its display, its keys and its remote commands.

The counter sorts by the range of the bar: beyond it `<` or `>` lights up. Without a signal it displays an
error, keeps its value to itself and says why when asked. With its cable out the line is dead.
"""

import asyncio
import math
from collections.abc import Sequence

from truepose_drivers.heidenhain_nd import protocol
from truepose_simulators.faults.kinds import BallbarInches, BallbarKeyPressed, LineDoublesDigits, LineStalls
from truepose_simulators.instruments.endpoint import Endpoint, say, with_doubled_digit
from truepose_simulators.instruments.gauges.length_source import Electronics, Sample

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
            "A0000": lambda: protocol.identity_lines(_MODEL, _SOFTWARE, _RELEASED),
            "A0100": self._display,
            "A0200": self._value,
            "A0301": self._error_text,
            "A0400": lambda: (protocol.Line(_SOFTWARE.ljust(10)),),
            "A0800": lambda: (protocol.lamps_line(self._lamps(self._sample())),),
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

    def answer(self, request: protocol.Request) -> Sequence[protocol.Reply]:
        """Return the replies to a request, oldest first."""
        if isinstance(request, protocol.Control):
            return self._control(request.character)
        if not isinstance(request, protocol.Command):
            return (protocol.Refusal(),)
        if request.code.startswith("T"):
            return self._press(request.code)
        answer = self._answers.get(request.code)
        return (protocol.Refusal(),) if answer is None else answer()

    def _control(self, character: int) -> Sequence[protocol.Reply]:
        return {protocol.STX: self._print, protocol.ENQ: self._error_text}.get(character, _refuse)()

    def _press(self, code: str) -> Sequence[protocol.Reply]:
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
                return (protocol.Refusal(),)
        return (protocol.Acknowledgement(),)

    def _enter(self) -> None:
        typed, self._entry = self._entry, ""
        sample = self._sample()
        if any(character.isdigit() for character in typed) and sample.signal != "none":
            self._datum = round(sample.deviation_mm * protocol.COUNTS_PER_MM) - round(
                float(typed) * protocol.COUNTS_PER_MM
            )

    def _sample(self) -> Sample:
        return self._bar.show()

    def _count(self, sample: Sample) -> int | None:
        if sample.signal == "none" or math.isnan(sample.deviation_mm):
            return None
        count = round(sample.deviation_mm * protocol.COUNTS_PER_MM) - self._datum
        if not self._bar.has(BallbarInches):
            return count
        return round(count / protocol.COUNTS_PER_MM / protocol.MM_PER_INCH * protocol.COUNTS_PER_INCH)

    def _lamps(self, sample: Sample) -> protocol.Lamps:
        out = sample.signal == "out_of_range"
        return protocol.Lamps(
            below=out and sample.deviation_mm < 0.0,
            inside=sample.signal == "good",
            above=out and sample.deviation_mm > 0.0,
            inch=self._bar.has(BallbarInches),
            reference=self._reference,
        )

    def _display(self) -> Sequence[protocol.Reply]:
        sample = self._sample()
        count = self._count(sample)
        return (_error(sample) if count is None else protocol.display_line(count),)

    def _value(self) -> Sequence[protocol.Reply]:
        count = self._count(self._sample())
        return (protocol.Refusal() if count is None else protocol.value_line(count),)

    def _error_text(self) -> Sequence[protocol.Reply]:
        sample = self._sample()
        return (_error(sample) if self._count(sample) is None else protocol.Refusal(),)

    def _print(self) -> Sequence[protocol.Reply]:
        sample = self._sample()
        count = self._count(sample)
        return (protocol.Refusal() if count is None else protocol.printed_line(count, self._lamps(sample)),)

    def _print_after_acknowledging(self) -> Sequence[protocol.Reply]:
        return (protocol.Acknowledgement(), *self._print())

    def _toggle_reference(self) -> Sequence[protocol.Reply]:
        self._reference = not self._reference
        return (protocol.Acknowledgement(),)

    def _reset(self) -> Sequence[protocol.Reply]:
        """Start again as after switching it on: without reference marks no datum is kept."""
        self._datum, self._entry, self._reference = 0, "", False
        return (protocol.Acknowledgement(),)


def _error(sample: Sample) -> protocol.Line:
    return protocol.error_line(_TOO_FAST if sample.too_fast else _NO_SIGNAL)


def _acknowledge() -> Sequence[protocol.Reply]:
    return (protocol.Acknowledgement(),)


def _refuse() -> Sequence[protocol.Reply]:
    return (protocol.Refusal(),)


def _on_the_line(bar: Electronics, said: bytes) -> bytes:
    return with_doubled_digit(said) if bar.has(LineDoublesDigits) else said


def nd28x_endpoint(bar: Electronics) -> Endpoint:
    """Build the endpoint of a counter; every connection reaches the same one."""
    counter = Counter(bar)

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        requests, outbox, holding = protocol.RequestReader(), bytearray(), False
        while data := await reader.read(_CHUNK_BYTES):
            if not counter.plugged:
                requests = protocol.RequestReader()
                continue
            requests.receive_data(data)
            while (request := requests.next_message()) is not None:
                if request in (protocol.Control(protocol.DC1), protocol.Control(protocol.DC3)):
                    holding = request == protocol.Control(protocol.DC3)
                elif len(outbox) < _MOST_HELD_BYTES:
                    outbox += _on_the_line(bar, b"".join(map(protocol.encode_reply, counter.answer(request))))
            if not holding:
                said = bytes(outbox)
                outbox.clear()
                if bar.has(BallbarKeyPressed):
                    said = (
                        b"".join(map(protocol.encode_reply, counter.answer(protocol.Control(protocol.STX))))
                        + said
                    )
                await say(writer, said, stalls=bar.has(LineStalls))

    return Endpoint("ballbar", "nd28x", serve)
