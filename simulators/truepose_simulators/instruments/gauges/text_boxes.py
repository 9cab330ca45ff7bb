"""Gauges behind boxes that answer lines of text: Mitutoyo's multiplexers and counters, Keyence's units."""

import asyncio
import math
import re
from collections.abc import Callable, Sequence
from typing import Final

from truepose_drivers.keyence_gt2 import protocol as keyence
from truepose_drivers.line_gauges.protocol import NOT_CONNECTED, NOT_CONVERTIBLE, Value
from truepose_drivers.mitutoyo_eh import protocol as eh
from truepose_drivers.mitutoyo_serial import protocol as serial
from truepose_simulators.faults.kinds import BallbarInches, BallbarKeyPressed, LineDoublesDigits, LineStalls
from truepose_simulators.instruments.endpoint import Endpoint, say, with_doubled_digit
from truepose_simulators.instruments.gauges.length_source import Electronics

_CHUNK_BYTES: Final = 4096
_MM_PER_INCH: Final = 25.4
_DECIMALS: Final = 4
_DECIMALS_OF_INCHES: Final = 5
_LONGEST_QUESTION: Final = 100
_END: Final = re.compile(rb"[\r\n]")


class Questions:
    """Puts lines together; noise, and what no box could hold, is forgotten up to the next end of a line."""

    def __init__(self) -> None:
        self._begun = b""

    def receive(self, data: bytes) -> list[str]:
        """Return the lines that are whole now."""
        # What has begun is cut off below: noise without an end of line would otherwise leave the box deaf for
        # as long as the connection stands.
        *whole, begun = _END.split(self._begun + data)
        self._begun = begun[: _LONGEST_QUESTION + 1]  # one too many: still too long when its end comes
        return [
            line.decode("ascii") for line in whole if line.isascii() and 0 < len(line) <= _LONGEST_QUESTION
        ]


class TextBox:
    """A box with its gauges; `answer` returns what it says to one line."""

    def __init__(self, gauges: Sequence[Electronics], answer: Callable[[str], bytes]) -> None:
        self._gauges = gauges
        self._answer = answer
        self._pressed = False  # a key, before the last question

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Answer one client until it goes."""
        questions = Questions()
        while data := await reader.read(_CHUNK_BYTES):
            if not self._gauges[0].plugged:
                questions = Questions()
                continue
            for said in map(self._said, questions.receive(data)):
                await say(writer, said, stalls=self._gauges[0].has(LineStalls))

    def _said(self, line: str) -> bytes:
        said = self._answer(line)
        if self._gauges[0].has(LineDoublesDigits):
            said = with_doubled_digit(said)
        self._pressed = self._gauges[0].has(BallbarKeyPressed) and not self._pressed
        return said + said if self._pressed else said


def displayed(gauge: Electronics, length_mm: float) -> Value:
    """Return a length as the gauge's display shows it, in the unit that is set there."""
    if gauge.has(BallbarInches):
        return Value(length_mm / _MM_PER_INCH, _DECIMALS_OF_INCHES)
    return Value(length_mm, _DECIMALS)


def box_endpoint(device: str, protocol: str, box: TextBox) -> Endpoint:
    """Build the endpoint of a box; every connection reaches the same one."""
    return Endpoint(device, protocol, box.serve)


_UNKNOWN_COMMAND: Final = 913  # no source tells what a box answers to what it does not know


def mitutoyo_serial_endpoint(gauges: Sequence[Electronics], device: str = "gauge") -> Endpoint:
    """Build the endpoint of a box with a gauge on each channel."""

    def answer(line: str) -> bytes:
        return serial.encode(_reply(gauges, line))

    return box_endpoint(device, "mitutoyo_serial", TextBox(gauges, answer))


def _reply(gauges: Sequence[Electronics], line: str) -> serial.Reply:
    channel = int(line) if line.isdecimal() and len(line) == 1 else 0
    if not channel:
        return serial.NoValue(_UNKNOWN_COMMAND)
    return _value(gauges[channel - 1], channel) if channel <= len(gauges) else serial.NoValue(NOT_CONNECTED)


def _value(gauge: Electronics, channel: int) -> serial.Reply:
    shown = gauge.show()
    if shown.too_fast:
        return serial.NoValue(NOT_CONVERTIBLE)
    if shown.signal == "none" or math.isnan(shown.deviation_mm):
        return serial.NoValue(NOT_CONNECTED)
    return serial.ChannelValue(channel, displayed(gauge, shown.deviation_mm))


_NO_SUCH_COMMAND, _NO_SIGNAL, _TOO_FAST = "10", "20", "30"  # ours: no source lists the codes


class Counter:
    """The counter: its gauges, and what was set to zero."""

    def __init__(self, gauges: Sequence[Electronics]) -> None:
        self._gauges = gauges
        self._zeros_mm = [0.0] * len(gauges)

    def reply(self, question: eh.Question | None) -> eh.Reply:
        """Return the reply to a question, None for one that cannot be read."""
        if question is None or not 1 <= question.channel <= len(self._gauges):
            return eh.Refusal(0 if question is None else question.channel, _NO_SUCH_COMMAND)
        match question.mnemonic:
            case "GA":
                return self._value(question.channel)
            case "CR":
                return self._set_zero(question.channel)
            case "CN":  # the value itself is what is always shown here
                return eh.Done(question.channel)
        return eh.Refusal(question.channel, _NO_SUCH_COMMAND)

    def _value(self, channel: int) -> eh.Reply:
        gauge = self._gauges[channel - 1]
        shown = gauge.show()
        if shown.signal == "none" or math.isnan(shown.deviation_mm):
            return eh.Refusal(channel, _TOO_FAST if shown.too_fast else _NO_SIGNAL)
        return eh.CounterValue(channel, displayed(gauge, shown.deviation_mm - self._zeros_mm[channel - 1]))

    def _set_zero(self, channel: int) -> eh.Reply:
        shown = self._gauges[channel - 1].show()
        if math.isnan(shown.deviation_mm):
            return eh.Refusal(channel, _NO_SIGNAL)
        self._zeros_mm[channel - 1] = shown.deviation_mm
        return eh.Done(channel)


def mitutoyo_eh_endpoint(
    gauges: Sequence[Electronics], device: str = "gauge", *, end: eh.Ends = "CR LF"
) -> Endpoint:
    """Build the endpoint of a counter with a gauge on each channel."""
    counter = Counter(gauges)

    def answer(line: str) -> bytes:
        return eh.encode(counter.reply(eh.decode_question(line)), eh.ENDS[end])

    return box_endpoint(device, "mitutoyo_eh", TextBox(gauges, answer))


_COMMAND_CHARACTERS: Final = 2


def keyence_gt2_endpoint(gauges: Sequence[Electronics], device: str = "gauge") -> Endpoint:
    """Build the endpoint of a unit with an amplifier for each gauge."""

    def answer(line: str) -> bytes:
        if line not in {keyence.VALUES, keyence.STATES_AND_VALUES}:
            return keyence.encode(
                keyence.Refusal(
                    line[:_COMMAND_CHARACTERS].ljust(_COMMAND_CHARACTERS, "?"), keyence.INVALID_COMMAND
                )
            )
        return keyence.encode(keyence.Amplifiers(line, tuple(map(_amplifier, gauges))))

    return box_endpoint(device, "keyence_gt2", TextBox(gauges, answer))


def _amplifier(gauge: Electronics) -> keyence.Amplifier:
    shown = gauge.show()
    if shown.signal == "none" or math.isnan(shown.deviation_mm):
        return keyence.Amplifier(None)
    beyond = keyence.LOW if shown.deviation_mm < 0.0 else keyence.HIGH
    state = keyence.GO if shown.signal == "good" else beyond
    return keyence.Amplifier(displayed(gauge, shown.deviation_mm), state)
