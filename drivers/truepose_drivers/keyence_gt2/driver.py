"""Keyence GT2 contact sensors behind a DL-EN1 (Ethernet) or DL-RS1A (serial) unit."""

from collections.abc import Sequence
from typing import Final

from truepose_drivers.api import Clock, DeviceIdentity, DriverPlugin, Options
from truepose_drivers.errors import DeviceRefusedError
from truepose_drivers.keyence_gt2 import protocol
from truepose_drivers.line_gauges.conversation import (
    SHARED_OPTIONS,
    Ask,
    Display,
    LineGauges,
    open_line_gauges,
)
from truepose_drivers.line_gauges.protocol import LineGaugeError
from truepose_drivers.transports.conversation import Reader
from truepose_drivers.transports.serial import SERIAL_OPTIONS, Framing

_PORT: Final = 64_000  # of the DL-EN1, as delivered
_SETTLE_S: Final = 0.05  # the unit has its values at hand
_FACTORY: Final = Framing(baud=9600, data_bits=8, parity="N", stop_bits=1)


class KeyenceUnit:
    """The dialect of the units: one question, and all amplifiers answer at once."""

    box = "the Keyence unit"

    def new_reader(self) -> Reader[protocol.Reply]:
        """Return a reader of its lines."""
        return protocol.reply_reader()

    async def identity(self, ask: Ask[protocol.Reply], channels: Sequence[int]) -> DeviceIdentity:
        """Count the amplifiers; none of them tells a serial number."""
        amplifiers = await _ask_all(ask, channels)
        return DeviceIdentity("Keyence", f"GT2, {len(amplifiers)} amplifiers", "unknown", "unknown")

    async def displays(self, ask: Ask[protocol.Reply], channels: Sequence[int]) -> Sequence[Display]:
        """Ask once, and pick the amplifiers that are used."""
        amplifiers = await _ask_all(ask, channels)
        return [_display(amplifiers[channel - 1]) for channel in channels]


async def _ask_all(ask: Ask[protocol.Reply], channels: Sequence[int]) -> tuple[protocol.Amplifier, ...]:
    # One question for all of them, so that the gauges of a fixture are read at one moment. MS, not M0: the
    # limits set at an amplifier belong to the value that they judge.
    reply = await ask(protocol.encode_question(protocol.STATES_AND_VALUES))
    match reply:
        case protocol.Amplifiers(command, amplifiers) if command == protocol.STATES_AND_VALUES:
            if len(amplifiers) >= max(channels):
                return amplifiers
            raise DeviceRefusedError(
                f"the unit has {len(amplifiers)} amplifiers, but channel {max(channels)} is configured:"
                " check channels in the cell file, and that all amplifiers are plugged together"
            )
        case protocol.Refusal(_, code):
            raise DeviceRefusedError(f"the unit refuses to send its values (error {code}): see its manual")
    raise LineGaugeError(f"the unit answered MS with {reply}: connect again")


def _display(amplifier: protocol.Amplifier) -> Display:
    return Display(
        amplifier.value, sorted_out=amplifier.state in {protocol.HIGH, protocol.LOW, protocol.BOTH}
    )


def _open(options: Options, clock: Clock) -> LineGauges[protocol.Reply]:
    on_network = {} if "serial" in options else {"port": _PORT}
    return open_line_gauges(
        {**on_network, **options},
        clock,
        KeyenceUnit(),
        _FACTORY,
        most_channels=protocol.MOST_AMPLIFIERS,
        settle_s=_SETTLE_S,
    )


_OPTIONS = {
    "host": "address of the DL-EN1 unit",
    "port": f"TCP port of the unit, default {_PORT}",
    "serial": "instead of host: name of the serial port of a DL-RS1A unit",
    "baud": SERIAL_OPTIONS["baud"],
    **SHARED_OPTIONS,
}
PLUGIN = DriverPlugin("keyence_gt2", "linear_gauge", "keyence_gt2", _OPTIONS, _open, also=("ballbar",))
