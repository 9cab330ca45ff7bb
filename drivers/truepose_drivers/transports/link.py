"""What a driver needs of a connection: bytes with time-outs in wall time, and the two ways it ends.

A blocking port that is closed meanwhile is let go after a slice at the latest.
"""

import asyncio
import contextlib
import time
from abc import ABC, abstractmethod
from collections.abc import AsyncIterator, Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Final, Generic, Protocol, TypeVar

from truepose_drivers.errors import (
    ConnectFailedError,
    ConnectionLostError,
    DeviceRefusedError,
    DriverError,
    LinkError,
    RemoteProtocolError,
)

MOST_PIECES: Final = 10_000  # waiting on a stream: whoever sends more never stops


class Port(Protocol):
    """A connection to one device; can be opened again after it was lost."""

    @property
    def address(self) -> str:
        """Where the device is, for error texts."""
        ...

    @property
    def is_open(self) -> bool:
        """Whether the device is there as far as known."""
        ...

    async def open(self) -> None:
        """Connect, dropping what was open before; raises ConnectFailedError."""
        ...

    async def close(self) -> None:
        """End the connection; never raises."""
        ...


class Source(Port, Protocol):
    """A connection on which bytes arrive."""

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return what has arrived, at least one byte; None after `timeout_s` [s, wall time] of silence.

        With a time-out of 0 only what is there already. Raises ConnectionLostError at the stream's end.
        """
        ...


class Link(Source, Protocol):
    """A byte stream to one device."""

    async def send(self, data: bytes) -> None:
        """Hand `data` to the stream; raises ConnectionLostError."""
        ...


def now_s() -> float:
    """Return the time of the event loop [s], by which time-outs are counted."""
    return asyncio.get_running_loop().time()


async def open_patiently(
    open_once: Callable[[], Awaitable[None]], *, within_s: float, every_s: float, advice: str
) -> None:
    """Open a connection, trying again while its server may still be between two clients.

    Raises ConnectFailedError with the last reason and `advice` where it does not open within `within_s`.
    """
    give_up_s = now_s() + within_s
    while True:
        try:
            return await open_once()
        except LinkError as error:
            if now_s() >= give_up_s:
                raise ConnectFailedError(f"{error}; {advice}") from error
        await asyncio.sleep(every_s)


class OverPort:
    """What stands over a port: where it is, whether it is there, and its end are the port's."""

    def __init__(self, port: Port) -> None:
        self._port = port

    @property
    def address(self) -> str:
        """Where the device is, for error texts."""
        return self._port.address

    @property
    def is_open(self) -> bool:
        """Whether the device is there as far as known."""
        return self._port.is_open

    async def close(self) -> None:
        """End the connection; never raises."""
        await self._port.close()


class OnePortDevice:
    """A device at the far end of one port: it is there as long as the port is open."""

    def __init__(self, port: Port) -> None:
        self._port = port

    @property
    def connected(self) -> bool:
        """Whether the link is up as far as known."""
        return self._port.is_open

    async def close(self) -> None:
        """Close the link; never raises."""
        await self._port.close()


@contextlib.asynccontextmanager
async def introduction(port: Port, advice: str = "") -> AsyncIterator[None]:
    """Let whoever answers say who it is; what goes wrong meanwhile closes the port.

    An open port behind which nobody speaks is no connection: raises ConnectFailedError for its silence. Where
    `advice` says what else it may be, a refusal is no connection either.
    """
    try:
        yield
    except (LinkError, DeviceRefusedError) as error:
        await port.close()
        if isinstance(error, DeviceRefusedError) and not advice:
            raise
        raise ConnectFailedError(f"{error}; {advice}" if advice else str(error)) from error
    except DriverError:
        await port.close()
        raise


async def drain(source: Source, *, quiet_s: float = 0.0) -> None:
    """Drop what arrived unasked, so that it is not taken for the answer to the next question.

    What still arrives is dropped as well, until nothing has for `quiet_s` [s, wall time]. Raises
    RemoteProtocolError where it does not end.
    """
    for _ in range(MOST_PIECES):
        if await source.receive(quiet_s) is None:
            return
    raise unending(source)


def unending(source: Source) -> RemoteProtocolError:
    """Return the error of a device that sends on and on."""
    return RemoteProtocolError(
        f"the device at {source.address} does not stop sending: is this the right address?"
    )


Handle = TypeVar("Handle")
Value = TypeVar("Value")


class BlockingPort(ABC, Generic[Handle]):
    """What ports of such libraries have in common; `Handle` is what the library has opened."""

    def __init__(self, address: str, *, slice_s: float) -> None:
        self._address = address
        self._slice_s = slice_s
        self._handle: Handle | None = None
        self._thread: ThreadPoolExecutor | None = None

    @property
    def address(self) -> str:
        """Where the device is, for error texts."""
        return self._address

    @property
    def is_open(self) -> bool:
        """Whether the device is open; one that went silent or was unplugged is noticed by asking it."""
        return self._handle is not None

    async def open(self) -> None:
        """Open the device, dropping what was open before; raises ConnectFailedError."""
        await self.close()
        # One thread of its own: libraries of serial and USB devices are not to be called by two at once, and
        # a device that hangs must not take a place in the loop's shared pool.
        self._thread = ThreadPoolExecutor(1, thread_name_prefix=self._address)
        try:
            self._handle = await self._in_thread(self._open_handle)
        except BaseException:
            # A task that was cancelled while the device opened would leave it open for nobody.
            await self.close()
            raise

    async def close(self) -> None:
        """Let the device go; never raises."""
        # Taken out before anything is awaited: whoever reads meanwhile finds the port closed, and a second
        # close nothing to do.
        handle, thread = self._handle, self._thread
        self._handle = self._thread = None
        if handle is not None and thread is not None:
            with contextlib.suppress(OSError, ValueError):
                await asyncio.get_running_loop().run_in_executor(thread, self._close_handle, handle)
        if thread is not None:
            # The loop does not wait for a read in C that has still its slice to go.
            thread.shutdown(wait=False)

    @abstractmethod
    def _open_handle(self) -> Handle:
        """Open the device, in its thread; raises ConnectFailedError."""

    @abstractmethod
    def _close_handle(self, handle: Handle) -> None:
        """Let the device go, in its thread."""

    def _opened(self) -> Handle:
        if self._handle is None:
            raise ConnectionLostError(f"not connected to {self.address}: connect first")
        return self._handle

    async def _in_thread(self, call: Callable[[], Value]) -> Value:
        return await asyncio.get_running_loop().run_in_executor(self._thread, call)

    async def _in_slices(
        self, timeout_s: float, read: Callable[[float], Awaitable[bytes | None]]
    ) -> bytes | None:
        """Return what `read` brings, which waits as long as it is told [s]; None after `timeout_s`."""
        give_up_s = time.monotonic() + timeout_s
        while True:
            left_s = max(0.0, give_up_s - time.monotonic())
            if data := await read(min(left_s, self._slice_s)):
                return data
            # Asked after the read, so that a time-out of 0 still takes what is there.
            if left_s <= self._slice_s:
                return None

    async def _lost(self, sentence: str) -> ConnectionLostError:
        """Let the device go and return the error that says so."""
        await self.close()
        return ConnectionLostError(f"{sentence}, then connect again")
