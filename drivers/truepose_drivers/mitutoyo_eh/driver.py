"""Gauges behind Mitutoyo's EH and EV counters, and ID-H indicators."""

from collections.abc import Sequence
from typing import Final

from truepose_drivers import options as option
from truepose_drivers.api import Clock, DeviceIdentity, DriverPlugin, Options
from truepose_drivers.errors import ConfigurationError
from truepose_drivers.line_gauges.conversation import (
    SHARED_OPTIONS,
    Ask,
    Display,
    LineGauges,
    open_line_gauges,
)
from truepose_drivers.line_gauges.protocol import LineGaugeError
from truepose_drivers.mitutoyo_eh import protocol
from truepose_drivers.transports.conversation import Reader
from truepose_drivers.transports.serial import SERIAL_OPTIONS, Framing

_FACTORY: Final = Framing(baud=9600, data_bits=7, parity="E", stop_bits=2)


class EhCounter:
    """The dialect of the counters; `end` stands behind each question."""

    box = "the EH counter"

    def __init__(self, end: bytes = protocol.ENDS["CR LF"]) -> None:
        self._end = end

    def new_reader(self) -> Reader[protocol.Reply]:
        """Return a reader of its lines."""
        return protocol.reply_reader()

    async def identity(self, ask: Ask[protocol.Reply], channels: Sequence[int]) -> DeviceIdentity:
        """See that it answers as a counter does; it knows no question of who it is."""
        await self._ask_channel(ask, channels[0])
        return DeviceIdentity("Mitutoyo", "EH counter", "unknown", "unknown")

    async def displays(self, ask: Ask[protocol.Reply], channels: Sequence[int]) -> Sequence[Display]:
        """Ask one channel after the other."""
        return [await self._ask_channel(ask, channel) for channel in channels]

    async def _ask_channel(self, ask: Ask[protocol.Reply], channel: int) -> Display:
        reply = await ask(protocol.encode_question(protocol.Question("GA", channel), self._end))
        # The codes behind CE are not in the manual at hand: each of them counts as a gauge without a value.
        if isinstance(reply, protocol.Refusal):
            return Display(None)
        if not isinstance(reply, protocol.CounterValue) or reply.channel != channel:
            raise LineGaugeError(f"the counter answered GA{channel:02d} with {reply}: connect again")
        # A greatest or least value that is held looks like the value itself; this letter alone tells them
        # apart.
        if reply.mode != "N":
            raise LineGaugeError(
                f"channel {channel} is set to hold its maximum, minimum or range (G{reply.mode}), not its"
                " value: set the counter to normal measurement"
            )
        return Display(reply.value)


def _open(options: Options, clock: Clock) -> LineGauges[protocol.Reply]:
    return open_line_gauges(
        options, clock, EhCounter(_end(options)), _FACTORY, most_channels=protocol.MOST_CHANNELS
    )


def _end(options: Options) -> bytes:
    # An option because the counters' own manual was not at hand: the mnemonics are those of the ID-H, the
    # ends of lines may be others.
    name = option.text(options, "terminator") or "CR LF"
    if name not in protocol.ENDS:
        raise ConfigurationError(f"option terminator is {name!r}: give one of {', '.join(protocol.ENDS)}")
    return protocol.ENDS[name]


_OPTIONS = {
    **SERIAL_OPTIONS,
    "terminator": "terminator of requests: CR LF, CR or LF; default CR LF; answers may end with any of them",
    **SHARED_OPTIONS,
}
PLUGIN = DriverPlugin("mitutoyo_eh", "linear_gauge", "mitutoyo_eh", _OPTIONS, _open, also=("ballbar",))
