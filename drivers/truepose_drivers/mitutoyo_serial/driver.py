"""Digimatic gauges on a Mitutoyo multiplexer or serial input tool."""

from collections.abc import Sequence
from typing import Final

from truepose_drivers.api import Clock, DeviceIdentity, DriverPlugin, Options
from truepose_drivers.line_gauges.conversation import (
    SHARED_OPTIONS,
    Ask,
    Display,
    LineGauges,
    open_line_gauges,
)
from truepose_drivers.line_gauges.protocol import LineGaugeError
from truepose_drivers.mitutoyo_serial import protocol
from truepose_drivers.transports.conversation import Reader
from truepose_drivers.transports.serial import SERIAL_OPTIONS, Framing

_FACTORY: Final = Framing(baud=9600, data_bits=8, parity="N", stop_bits=1)


class MitutoyoBox:
    """The dialect of the serial boxes: a digit asks, one channel after the other."""

    box = "the Mitutoyo box"

    def new_reader(self) -> Reader[protocol.Reply]:
        """Return a reader of its lines."""
        return protocol.reply_reader()

    async def identity(self, ask: Ask[protocol.Reply], channels: Sequence[int]) -> DeviceIdentity:
        """See that it answers; it knows no question of who it is."""
        await ask(protocol.encode_question(channels[0]))
        return DeviceIdentity("Mitutoyo", "serial gauge box", "unknown", "unknown")

    async def displays(self, ask: Ask[protocol.Reply], channels: Sequence[int]) -> Sequence[Display]:
        """Ask one channel after the other."""
        return [_display(await ask(protocol.encode_question(channel)), channel) for channel in channels]


def _display(reply: protocol.Reply, channel: int) -> Display:
    # 91n does not name its channel, so it cannot be held against the one that was asked.
    if isinstance(reply, protocol.NoValue):
        return Display(None)
    if reply.channel != channel:
        raise LineGaugeError(
            f"channel {reply.channel} answered, but channel {channel} was requested:"
            " it is a late reply, or the box numbers its channels differently"
        )
    return Display(reply.value)


def _open(options: Options, clock: Clock) -> LineGauges[protocol.Reply]:
    return open_line_gauges(options, clock, MitutoyoBox(), _FACTORY, most_channels=protocol.MOST_CHANNELS)


PLUGIN = DriverPlugin(
    "mitutoyo_serial",
    "linear_gauge",
    "mitutoyo_serial",
    {**SERIAL_OPTIONS, **SHARED_OPTIONS},
    _open,
    also=("ballbar",),
)
