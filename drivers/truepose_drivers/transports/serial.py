"""A serial port as a link: whatever pyserial opens, a port's name or a URL such as `socket://host:port`.

pyserial blocks, and no call into it takes longer than a slice.
"""

import contextlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import serial

from truepose_drivers import options as option
from truepose_drivers.api import Options
from truepose_drivers.errors import ConfigurationError, ConnectFailedError, ConnectionLostError
from truepose_drivers.transports.link import BlockingPort, Link
from truepose_drivers.transports.tcp import tcp_link

_NOT_OPENED: tuple[type[Exception], ...] = (OSError, ValueError)  # ValueError: no such kind of URL or rate
try:
    import termios
except ImportError:  # on Windows
    termios = None  # type: ignore[assignment]
else:
    _NOT_OPENED = (*_NOT_OPENED, termios.error)  # pyserial lets it through where a port refuses its settings

TERMINAL_SERVER_PORT: Final = 4001  # first line of a Moxa NPort, as delivered
RATES: Final = (1200, 2400, 4800, 9600, 19_200, 38_400, 57_600, 115_200)
SERIAL_OPTIONS: Final[Mapping[str, str]] = {
    "serial": "name of the serial port, such as /dev/ttyUSB0 or COM3, or a URL of pyserial",
    "baud": "rate set at the box, default 9600",
    "host": "instead of serial: address of a terminal server in raw mode",
    "port": f"TCP port of the terminal server's line, default {TERMINAL_SERVER_PORT}",
}
_SLICE_S = 0.05  # a port that is closed meanwhile is let go after this long
_WRITE_TIMEOUT_S = 2.0  # a device that holds us back by XOFF for longer has gone


@dataclass(frozen=True, slots=True)
class Framing:
    """How characters travel on the line."""

    baud: int = 9600
    data_bits: Literal[7, 8] = 8
    parity: Literal["N", "E", "O"] = "N"
    stop_bits: Literal[1, 2] = 1
    xon_xoff: bool = False


class SerialLink(BlockingPort[serial.Serial]):
    """A serial port with time-outs in wall time."""

    def __init__(self, port: str, framing: Framing) -> None:
        super().__init__(port, slice_s=_SLICE_S)
        self._framing = framing

    async def send(self, data: bytes) -> None:
        """Hand `data` to the port; raises ConnectionLostError."""
        port = self._opened()
        try:
            await self._in_thread(lambda: port.write(data))
        except OSError as error:
            raise await self._gone() from error

    async def send_break(self) -> None:
        """Hold the line low for a quarter of a second; raises ConnectionLostError."""
        port = self._opened()
        try:
            await self._in_thread(port.send_break)
        except OSError as error:
            raise await self._gone() from error

    async def set_baud(self, baud: int) -> None:
        """Go on at another speed until the port is opened again; raises ConnectionLostError."""
        port = self._opened()
        try:
            # pyserial sets the port up within the assignment, a blocking call.
            await self._in_thread(lambda: setattr(port, "baudrate", baud))
        except (OSError, ValueError) as error:
            raise await self._gone() from error

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return what has arrived, None after `timeout_s` of silence; raises ConnectionLostError."""
        return await self._in_slices(timeout_s, self._read_slice)

    async def _read_slice(self, slice_s: float) -> bytes:
        port = self._opened()
        try:
            return await self._in_thread(lambda: _read(port, waiting=slice_s > 0.0))
        except OSError as error:
            raise await self._gone() from error

    def _open_handle(self) -> serial.Serial:
        try:
            return self._open_port()
        except _NOT_OPENED as error:
            raise ConnectFailedError(
                f"port {self.address} cannot be opened ({error}):"
                " check its name, that the adapter is plugged in, and that no other program is using it"
            ) from error

    def _close_handle(self, handle: serial.Serial) -> None:
        handle.close()

    def _open_port(self) -> serial.Serial:
        framing = self._framing
        if os.path.realpath(self.address).startswith("/dev/pts/"):
            framing = Framing(framing.baud)  # a pseudo terminal has no line, and refuses settings of one
        port = serial.serial_for_url(
            self.address,
            baudrate=framing.baud,
            bytesize=framing.data_bits,
            parity=framing.parity,
            stopbits=framing.stop_bits,
            xonxoff=framing.xon_xoff,
            timeout=_SLICE_S,  # never changed afterwards: pyserial would set the whole line up anew each time
            write_timeout=_WRITE_TIMEOUT_S,
        )
        if framing.parity != "N":
            _check_parity(port)
        with contextlib.suppress(OSError):  # what an earlier conversation left behind; not every port can
            port.reset_input_buffer()
        return port

    async def _gone(self) -> ConnectionLostError:
        return await self._lost(f"port {self.address} was disconnected: check cable and adapter")


def serial_or_tcp(options: Options, factory: Framing, *, rates: Sequence[int] = RATES, what: str) -> Link:
    """Return the link of a box on a serial port or a terminal server; raises ConfigurationError.

    `what` it is stands in the error's sentence; its rate may be one of `rates` [baud].
    """
    port = option.text(options, "serial")
    if port is None:
        return tcp_link(options, TERMINAL_SERVER_PORT)
    if "host" in options or "port" in options:
        raise ConfigurationError(f"serial and host both select the {what}: give only one of them")
    return SerialLink(port, replace(factory, baud=baud(options, factory, rates)))


def baud(options: Options, factory: Framing, rates: Sequence[int]) -> int:
    """Return option `baud`, the rate that was set at a box; raises ConfigurationError."""
    value = options.get("baud", factory.baud)
    if isinstance(value, bool) or not isinstance(value, int) or value not in rates:
        raise ConfigurationError(f"option baud is {value!r}: give one of {', '.join(map(str, rates))}")
    return value


def _check_parity(port: serial.Serial) -> None:
    """Have the system check parity, which pyserial leaves off: a character that fails arrives as NUL."""
    descriptor = getattr(port, "fd", None)
    if termios is None or not isinstance(descriptor, int):
        return  # Windows checks by itself; a port behind a URL is checked at its far end
    iflag, *others = termios.tcgetattr(descriptor)
    # NUL is in no reply of these devices, so that a codec refuses the line; a character with a flipped bit
    # could be another digit.
    iflag = (iflag | termios.INPCK) & ~(termios.IGNPAR | termios.PARMRK | termios.ISTRIP)
    termios.tcsetattr(descriptor, termios.TCSANOW, [iflag, *others])


def _read(port: serial.Serial, *, waiting: bool) -> bytes:
    """Read what is there; with `waiting` wait a slice for it."""
    # What is there is taken in one piece: reading byte by byte costs a thread switch each, more than a
    # character takes at 115 200 baud.
    there = port.in_waiting
    return bytes(port.read(there or 1)) if there or waiting else b""
