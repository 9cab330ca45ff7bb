"""A port whose library blocks: it has a thread of its own, and waits there in slices.

A port that is closed meanwhile is let go after a slice at the latest.
"""

import asyncio
import contextlib
import time
from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Generic, TypeVar

from truepose_drivers.errors import ConnectionLostError

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
        self._thread = ThreadPoolExecutor(1, thread_name_prefix=self._address)
        try:
            self._handle = await self._in_thread(self._open_handle)
        except BaseException:
            await self.close()
            raise

    async def close(self) -> None:
        """Let the device go; never raises."""
        handle, thread = self._handle, self._thread
        self._handle = self._thread = None
        if handle is not None and thread is not None:
            with contextlib.suppress(OSError, ValueError):
                await asyncio.get_running_loop().run_in_executor(thread, self._close_handle, handle)
        if thread is not None:
            thread.shutdown(wait=False)

    @abstractmethod
    def _open_handle(self) -> Handle:
        """Open the device, in its thread; raises ConnectFailedError."""

    @abstractmethod
    def _close_handle(self, handle: Handle) -> None:
        """Let the device go, in its thread."""

    def _opened(self) -> Handle:
        if self._handle is None:
            raise ConnectionLostError(f"there is no connection to {self.address}: connect first")
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
            if left_s <= self._slice_s:
                return None

    async def _lost(self, sentence: str) -> ConnectionLostError:
        """Let the device go and return the error that says so."""
        await self.close()
        return ConnectionLostError(f"{sentence}, then connect again")
