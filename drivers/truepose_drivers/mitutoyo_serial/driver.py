"""Digimatic gauges on a Mitutoyo multiplexer or serial input tool."""

from collections.abc import Sequence
from typing import Final

from truepose_drivers.api import Clock, DeviceIdentity, DriverPlugin, Options
from truepose_drivers.line_gauges.dialogue import Ask, LineGauges, Shown
from truepose_drivers.line_gauges.settings import (
    SERIAL_OPTIONS,
    SHARED_OPTIONS,
    gauge_settings,
    serial_or_tcp,
)
from truepose_drivers.line_gauges.text_lines import LineGaugeError
from truepose_drivers.mitutoyo_serial.protocol import (
    MOST_CHANNELS,
    NoValue,
    Reply,
    encode_question,
    reply_reader,
)
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_drivers.transports.conversation import Reader
from truepose_drivers.transports.serial import Framing

_FACTORY: Final = Framing(baud=9600, data_bits=8, parity="N", stop_bits=1)


class MitutoyoBox:
    """The dialect of the serial boxes: a digit asks, one channel after the other."""

    box = "the Mitutoyo box"

    def new_reader(self) -> Reader[Reply]:
        """Return a reader of its lines."""
        return reply_reader()

    async def identity(self, ask: Ask[Reply], channels: Sequence[int]) -> DeviceIdentity:
        """See that it answers; it knows no question of who it is."""
        await ask(encode_question(channels[0]))
        return DeviceIdentity("Mitutoyo", "serial gauge box", "unknown", "unknown")

    async def shown(self, ask: Ask[Reply], channels: Sequence[int]) -> Sequence[Shown]:
        """Ask one channel after the other."""
        return [_shown(await ask(encode_question(channel)), channel) for channel in channels]


def _shown(reply: Reply, channel: int) -> Shown:
    if isinstance(reply, NoValue):
        return Shown(None)
    if reply.channel != channel:
        raise LineGaugeError(
            f"channel {reply.channel} answered, and channel {channel} was asked:"
            " it is left from before, or the box numbers its channels otherwise"
        )
    return Shown(reply.value)


def _open(options: Options, clock: Clock | None) -> LineGauges[Reply]:
    return LineGauges(
        serial_or_tcp(options, _FACTORY),
        clock or MonotonicClock(),
        MitutoyoBox(),
        gauge_settings(options, most_channels=MOST_CHANNELS),
    )


PLUGIN = DriverPlugin(
    "mitutoyo_serial",
    "linear_gauge",
    "mitutoyo_serial",
    {**SERIAL_OPTIONS, **SHARED_OPTIONS},
    _open,
    also=("ballbar",),
)
