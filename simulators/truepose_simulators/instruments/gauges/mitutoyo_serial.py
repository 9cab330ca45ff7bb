"""Gauges behind a Mitutoyo multiplexer: a digit asks for a channel."""

import math
from collections.abc import Sequence
from typing import Final

from truepose_drivers.line_gauges.digimatic import NOT_CONNECTED, NOT_CONVERTIBLE
from truepose_drivers.line_gauges.value_form import Value
from truepose_drivers.mitutoyo_serial.protocol import ChannelValue, NoValue, Reply, encode
from truepose_simulators.instruments.ballbars.length_source import Electronics
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.gauges.text_box import TextBox, box_endpoint, in_inches

_DECIMALS: Final = 4
_DECIMALS_OF_INCHES: Final = 5
_UNKNOWN_COMMAND: Final = 913  # no source tells what a box answers to what it does not know


def mitutoyo_serial_endpoint(gauges: Sequence[Electronics], device: str = "gauge") -> Endpoint:
    """Build the endpoint of a box with a gauge on each channel."""

    def answer(line: str) -> bytes:
        return encode(_reply(gauges, line))

    return box_endpoint(device, "mitutoyo_serial", TextBox(gauges, answer))


def _reply(gauges: Sequence[Electronics], line: str) -> Reply:
    channel = int(line) if line.isdecimal() and len(line) == 1 else 0
    if not channel:
        return NoValue(_UNKNOWN_COMMAND)
    return _value(gauges[channel - 1], channel) if channel <= len(gauges) else NoValue(NOT_CONNECTED)


def _value(gauge: Electronics, channel: int) -> Reply:
    shown = gauge.show()
    if shown.too_fast:
        return NoValue(NOT_CONVERTIBLE)
    if shown.signal == "none" or math.isnan(shown.deviation_mm):
        return NoValue(NOT_CONNECTED)
    number, inches = in_inches(gauge, shown)
    return ChannelValue(channel, Value(number, _DECIMALS_OF_INCHES if inches else _DECIMALS))
