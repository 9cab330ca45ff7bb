"""Gauges behind Mitutoyo's EH and EV counters, and ID-H indicators."""

from collections.abc import Sequence
from typing import Final

from truepose_drivers import options as option
from truepose_drivers.api import Clock, DeviceIdentity, DriverPlugin, Options
from truepose_drivers.errors import ConfigurationError
from truepose_drivers.line_gauges.dialogue import Ask, LineGauges, Shown
from truepose_drivers.line_gauges.settings import (
    SERIAL_OPTIONS,
    SHARED_OPTIONS,
    gauge_settings,
    serial_or_tcp,
)
from truepose_drivers.line_gauges.text_lines import LineGaugeError
from truepose_drivers.mitutoyo_eh.protocol import (
    ENDS,
    MOST_CHANNELS,
    Counted,
    Question,
    Refused,
    Reply,
    encode_question,
    reply_reader,
)
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_drivers.transports.conversation import Reader
from truepose_drivers.transports.serial import Framing

_FACTORY: Final = Framing(baud=9600, data_bits=7, parity="E", stop_bits=2)


class EhCounter:
    """The dialect of the counters; `end` stands behind each question."""

    box = "the EH counter"

    def __init__(self, end: bytes = ENDS["CR LF"]) -> None:
        self._end = end

    def new_reader(self) -> Reader[Reply]:
        """Return a reader of its lines."""
        return reply_reader()

    async def identity(self, ask: Ask[Reply], channels: Sequence[int]) -> DeviceIdentity:
        """See that it answers as a counter does; it knows no question of who it is."""
        await self._ask_channel(ask, channels[0])
        return DeviceIdentity("Mitutoyo", "EH counter", "unknown", "unknown")

    async def shown(self, ask: Ask[Reply], channels: Sequence[int]) -> Sequence[Shown]:
        """Ask one channel after the other."""
        return [await self._ask_channel(ask, channel) for channel in channels]

    async def _ask_channel(self, ask: Ask[Reply], channel: int) -> Shown:
        reply = await ask(encode_question(Question("GA", channel), self._end))
        if isinstance(reply, Refused):
            return Shown(None)
        if not isinstance(reply, Counted) or reply.channel != channel:
            raise LineGaugeError(f"the counter answered GA{channel:02d} with {reply}: connect again")
        if reply.mode != "N":
            raise LineGaugeError(
                f"channel {channel} holds its greatest, least or span (G{reply.mode}), not its value:"
                " set the counter to normal measurement"
            )
        return Shown(reply.value)


def _open(options: Options, clock: Clock | None) -> LineGauges[Reply]:
    return LineGauges(
        serial_or_tcp(options, _FACTORY),
        clock or MonotonicClock(),
        EhCounter(_end(options)),
        gauge_settings(options, most_channels=MOST_CHANNELS),
    )


def _end(options: Options) -> bytes:
    name = option.text(options, "terminator") or "CR LF"
    if name not in ENDS:
        raise ConfigurationError(f"option terminator is {name!r}: give one of {', '.join(ENDS)}")
    return ENDS[name]


_OPTIONS = {
    **SERIAL_OPTIONS,
    "terminator": "what ends a question: CR LF, CR or LF; CR LF unless given; any ends an answer",
    **SHARED_OPTIONS,
}
PLUGIN = DriverPlugin("mitutoyo_eh", "linear_gauge", "mitutoyo_eh", _OPTIONS, _open, also=("ballbar",))
