"""Options that drivers of gauges share, and the link to their box."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from truepose_drivers import options as option
from truepose_drivers.api import Options
from truepose_drivers.errors import ConfigurationError
from truepose_drivers.line_gauges.value_form import MOST_DECIMALS
from truepose_drivers.transports.link import Link
from truepose_drivers.transports.serial import Framing, SerialLink
from truepose_drivers.transports.tcp import tcp_link

_RATES: Final = (1200, 2400, 4800, 9600, 19_200, 38_400, 57_600, 115_200)
TERMINAL_SERVER_PORT: Final = 4001  # first line of a Moxa NPort, as delivered


@dataclass(frozen=True, slots=True)
class GaugeSettings:
    """What the cell file says of the gauges behind a box."""

    channels: tuple[int, ...] = (1,)
    range_mm: float = math.inf  # either way of zero; what lies beyond is out of range
    reversed: bool = False  # the box counts up as the plunger comes out
    decimals: int | None = None  # behind the point in millimetres; None: learnt from the first values


def gauge_settings(options: Options, *, most_channels: int) -> GaugeSettings:
    """Read the options that all of them have; raises ConfigurationError."""
    return GaugeSettings(
        _channels(options, most_channels),
        option.positive(options, "range_mm", 1.0) if "range_mm" in options else math.inf,
        _reversed(options),
        decimals(options),
    )


def decimals(options: Options) -> int | None:
    """Read how many digits stand behind the point; raises ConfigurationError."""
    number = options.get("decimals")
    if number is None:
        return None
    if isinstance(number, bool) or not isinstance(number, int) or not 0 <= number <= MOST_DECIMALS:
        raise ConfigurationError(f"option decimals is {number!r}: give a number from 0 to {MOST_DECIMALS}")
    return number


def serial_or_tcp(options: Options, framing: Framing) -> Link:
    """Return the link of a box on a serial port or a terminal server; raises ConfigurationError."""
    port = option.text(options, "serial")
    if port is None:
        return tcp_link(options, TERMINAL_SERVER_PORT)
    if "host" in options or "port" in options:
        raise ConfigurationError("serial and host are two ways to the same box: give one of them")
    baud = options.get("baud", framing.baud)
    if isinstance(baud, bool) or not isinstance(baud, int) or baud not in _RATES:
        raise ConfigurationError(f"option baud is {baud!r}: give one of {', '.join(map(str, _RATES))}")
    return SerialLink(port, Framing(baud, framing.data_bits, framing.parity, framing.stop_bits))


def _channels(options: Options, most: int) -> tuple[int, ...]:
    words = option.text(options, "channels") or "1"
    channels = tuple(int(word) if word.isdecimal() else 0 for word in words.split())
    if not all(1 <= channel <= most for channel in channels) or len(set(channels)) < len(channels):
        raise ConfigurationError(
            f"option channels is {words!r}: give different numbers from 1 to {most}, such as 1 2 3"
        )
    return channels


def _reversed(options: Options) -> bool:
    value = options.get("reversed", False)
    if not isinstance(value, bool):
        raise ConfigurationError(f"option reversed is {value!r}: give true or false")
    return value


SHARED_OPTIONS: Final[Mapping[str, str]] = {
    "channels": "which channels are used, each a gauge, such as 1 2 3; 1 unless given",
    "range_mm": "either way of zero; what lies beyond is out of range; unless given, what the box says is",
    "reversed": "true where the box counts up as the plunger comes out; false unless given",
    "decimals": "digits behind the point in millimetres; learnt from the first values unless given",
}
SERIAL_OPTIONS: Final[Mapping[str, str]] = {
    "serial": "name of the serial port, such as /dev/ttyUSB0 or COM3, or a URL of pyserial",
    "baud": "rate set at the box, 9600 unless changed",
    "host": "instead of serial: address of a terminal server in raw mode",
    "port": f"TCP port of the terminal server's line, {TERMINAL_SERVER_PORT} unless changed",
}
