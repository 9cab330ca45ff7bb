"""Gauges behind a Mitutoyo EH counter: GA and a channel ask for a value."""

import math
from collections.abc import Sequence
from typing import Final

from truepose_drivers.line_gauges.value_form import Value
from truepose_drivers.mitutoyo_eh.protocol import (
    ENDS,
    Counted,
    Done,
    Ends,
    Question,
    Refused,
    Reply,
    decode_question,
    encode,
)
from truepose_simulators.instruments.ballbars.length_source import Electronics
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.gauges.text_box import TextBox, box_endpoint, in_inches

_DECIMALS: Final = 4
_DECIMALS_OF_INCHES: Final = 5
_NO_SUCH_COMMAND, _NO_SIGNAL, _TOO_FAST = "10", "20", "30"  # ours: no source lists the codes


class Counter:
    """The counter: its gauges, and what was set to zero."""

    def __init__(self, gauges: Sequence[Electronics]) -> None:
        self._gauges = gauges
        self._zeros_mm = [0.0] * len(gauges)

    def reply(self, question: Question | None) -> Reply:
        """Return the reply to a question, None for one that cannot be read."""
        if question is None or not 1 <= question.channel <= len(self._gauges):
            return Refused(0 if question is None else question.channel, _NO_SUCH_COMMAND)
        match question.mnemonic:
            case "GA":
                return self._value(question.channel)
            case "CR":
                return self._set_zero(question.channel)
            case "CN":  # the value itself is what is always shown here
                return Done(question.channel)
        return Refused(question.channel, _NO_SUCH_COMMAND)

    def _value(self, channel: int) -> Reply:
        gauge = self._gauges[channel - 1]
        shown = gauge.show()
        if shown.signal == "none" or math.isnan(shown.deviation_mm):
            return Refused(channel, _TOO_FAST if shown.too_fast else _NO_SIGNAL)
        number, inches = in_inches(gauge, shown)
        decimals = _DECIMALS_OF_INCHES if inches else _DECIMALS
        return Counted(channel, Value(number - self._zeros_mm[channel - 1], decimals))

    def _set_zero(self, channel: int) -> Reply:
        shown = self._gauges[channel - 1].show()
        if math.isnan(shown.deviation_mm):
            return Refused(channel, _NO_SIGNAL)
        self._zeros_mm[channel - 1] = shown.deviation_mm
        return Done(channel)


def mitutoyo_eh_endpoint(
    gauges: Sequence[Electronics], device: str = "gauge", *, end: Ends = "CR LF"
) -> Endpoint:
    """Build the endpoint of a counter with a gauge on each channel."""
    counter = Counter(gauges)

    def answer(line: str) -> bytes:
        return encode(counter.reply(decode_question(line)), ENDS[end])

    return box_endpoint(device, "mitutoyo_eh", TextBox(gauges, answer))
