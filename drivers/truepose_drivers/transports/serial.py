"""A serial port as a link: whatever pyserial opens, a port's name or a URL such as `socket://host:port`.

pyserial blocks, so each port has a thread of its own, and no call into it takes longer than a slice.
"""

import asyncio
import contextlib
import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Literal, TypeVar

import serial

from truepose_drivers.errors import ConnectFailedError, ConnectionLostError

_NOT_OPENED: tuple[type[Exception], ...] = (OSError, ValueError)  # ValueError: no such kind of URL or rate
try:
    import termios
except ImportError:  # on Windows
    termios = None  # type: ignore[assignment]
else:
    _NOT_OPENED = (*_NOT_OPENED, termios.error)  # pyserial lets it through where a port refuses its settings

_SLICE_S = 0.05  # a port that is closed meanwhile is let go after this long
_WRITE_TIMEOUT_S = 2.0  # a device that holds us back by XOFF for longer has gone

Value = TypeVar("Value")


@dataclass(frozen=True, slots=True)
class Framing:
    """How characters travel on the line."""

    baud: int = 9600
    data_bits: Literal[7, 8] = 8
    parity: Literal["N", "E", "O"] = "N"
    stop_bits: Literal[1, 2] = 1
    xon_xoff: bool = False


class SerialLink:
    """A serial port with time-outs in wall time."""

    def __init__(self, port: str, framing: Framing) -> None:
        self._port_name = port
        self._framing = framing
        self._port: serial.Serial | None = None
        self._thread: ThreadPoolExecutor | None = None

    @property
    def address(self) -> str:
        """Name of the port."""
        return self._port_name

    @property
    def is_open(self) -> bool:
        """Whether the port is open; a device that went silent is only noticed by asking it."""
        return self._port is not None

    async def open(self) -> None:
        """Open the port, dropping what was open before; raises ConnectFailedError."""
        await self.close()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix=f"serial {self._port_name}")
        try:
            self._port = await self._in_thread(self._open_port)
        except _NOT_OPENED as error:
            await self.close()
            raise ConnectFailedError(
                f"port {self._port_name} cannot be opened ({error}):"
                " check its name, that the adapter is plugged in, and that no other program has it"
            ) from error

    async def send(self, data: bytes) -> None:
        """Hand `data` to the port; raises ConnectionLostError."""
        port = self._opened()
        try:
            await self._in_thread(lambda: port.write(data))
        except OSError as error:
            raise await self._lost() from error

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return what has arrived, None after `timeout_s` of silence; raises ConnectionLostError."""
        give_up_s = time.monotonic() + timeout_s
        while True:
            left_s = max(0.0, give_up_s - time.monotonic())
            data = await self._read_slice(waiting=left_s > 0.0)
            if data:
                return data
            if left_s <= _SLICE_S:
                return None

    async def _read_slice(self, *, waiting: bool) -> bytes:
        port = self._opened()
        try:
            return await self._in_thread(lambda: _read(port, waiting=waiting))
        except OSError as error:
            raise await self._lost() from error

    async def close(self) -> None:
        """Close the port; never raises."""
        port, thread = self._port, self._thread
        self._port = self._thread = None
        if port is not None and thread is not None:
            with contextlib.suppress(OSError):
                await asyncio.get_running_loop().run_in_executor(thread, port.close)
        if thread is not None:
            thread.shutdown(wait=False)

    def _open_port(self) -> serial.Serial:
        framing = self._framing
        if os.path.realpath(self._port_name).startswith("/dev/pts/"):
            framing = Framing(framing.baud)  # a pseudo terminal has no line, and refuses settings of one
        port = serial.serial_for_url(
            self._port_name,
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

    async def _in_thread(self, call: Callable[[], Value]) -> Value:
        return await asyncio.get_running_loop().run_in_executor(self._thread, call)

    def _opened(self) -> serial.Serial:
        if self._port is None:
            raise ConnectionLostError(f"there is no connection to {self.address}: connect first")
        return self._port

    async def _lost(self) -> ConnectionLostError:
        await self.close()
        return ConnectionLostError(
            f"port {self.address} is gone: check cable and adapter, then connect again"
        )


def _check_parity(port: serial.Serial) -> None:
    """Have the system check parity, which pyserial leaves off: a character that fails arrives as NUL."""
    descriptor = getattr(port, "fd", None)
    if termios is None or not isinstance(descriptor, int):
        return  # Windows checks by itself; a port behind a URL is checked at its far end
    iflag, *others = termios.tcgetattr(descriptor)
    iflag = (iflag | termios.INPCK) & ~(termios.IGNPAR | termios.PARMRK | termios.ISTRIP)
    termios.tcsetattr(descriptor, termios.TCSANOW, [iflag, *others])


def _read(port: serial.Serial, *, waiting: bool) -> bytes:
    """Read what is there; with `waiting` wait a slice for it."""
    there = port.in_waiting
    return bytes(port.read(there or 1)) if there or waiting else b""
