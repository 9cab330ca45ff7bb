"""Two joined ends in memory, for tests: the far end is served by a coroutine, as a socket server would."""

import asyncio
from asyncio import Queue
from collections.abc import Awaitable, Callable
from typing import TypeAlias

from truepose_drivers.errors import ConnectFailedError, ConnectionLostError

_END_OF_STREAM = b""


class MemoryEnd:
    """One end of a joined pair; what `send` takes arrives at the other end in pieces of `chunk_bytes`."""

    def __init__(self, incoming: Queue[bytes], outgoing: Queue[bytes], chunk_bytes: int) -> None:
        self._incoming = incoming
        self._outgoing = outgoing
        self._chunk_bytes = chunk_bytes

    @property
    def has_data(self) -> bool:
        """Whether `receive` would return at once."""
        return not self._incoming.empty()

    async def receive(self) -> bytes:
        """Return the next piece that arrived, empty at the end of the stream."""
        return await self._incoming.get()

    def write(self, data: bytes) -> None:
        """Send `data` in pieces without giving way."""
        for start in range(0, len(data), self._chunk_bytes):
            self._outgoing.put_nowait(data[start : start + self._chunk_bytes])

    async def send(self, data: bytes) -> None:
        """Send `data` in pieces; returns after the other end had a chance to read."""
        self.write(data)
        # As a socket does: whoever serves the far end gets its turn before the next statement here.
        await asyncio.sleep(0)

    def close(self) -> None:
        """End the stream towards the other end."""
        self._outgoing.put_nowait(_END_OF_STREAM)


Serve: TypeAlias = Callable[[MemoryEnd], Awaitable[None]]


class MemoryLink:
    """A link to `serve`, which is started anew by every `open`; the stream ends when it returns.

    Either direction splits what is sent into pieces of `chunk_bytes`. Without `serve` nobody answers.
    """

    def __init__(self, serve: Serve | None, *, chunk_bytes: int = 65_536) -> None:
        self._serve = serve
        self._chunk_bytes = chunk_bytes
        self._end: MemoryEnd | None = None
        self._server: asyncio.Task[None] | None = None

    @property
    def address(self) -> str:
        """A name for error texts."""
        return "memory"

    @property
    def is_open(self) -> bool:
        """Whether the stream is up as far as known."""
        return self._end is not None

    async def open(self) -> None:
        """Start serving a fresh far end; raises ConnectFailedError."""
        await self.close()
        if self._serve is None:
            raise ConnectFailedError(f"no response from {self.address}: check who serves it")
        there: Queue[bytes] = Queue()
        here: Queue[bytes] = Queue()
        self._end = MemoryEnd(here, there, self._chunk_bytes)
        self._server = asyncio.create_task(
            _serve_and_close(self._serve, MemoryEnd(there, here, self._chunk_bytes))
        )

    async def send(self, data: bytes) -> None:
        """Send `data`; raises ConnectionLostError."""
        await self._opened().send(data)

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return the next piece, None after `timeout_s` of silence; raises ConnectionLostError."""
        end = self._opened()
        if timeout_s <= 0.0 and not end.has_data:
            return None
        try:
            async with asyncio.timeout(max(timeout_s, 0.0)):
                data = await end.receive()
        except TimeoutError:
            return None
        if data == _END_OF_STREAM:
            await self.close()
            raise ConnectionLostError(f"the connection to {self.address} was lost: check who serves it")
        return data

    async def close(self) -> None:
        """End the stream and its server; never raises."""
        end, server = self._end, self._server
        self._end = self._server = None
        if end is not None:
            end.close()
        if server is not None:
            server.cancel()
            # Not awaited by itself: whatever the serving coroutine ended with is its test's business.
            await asyncio.wait({server})

    def _opened(self) -> MemoryEnd:
        if self._end is None:
            raise ConnectionLostError(f"not connected to {self.address}: connect first")
        return self._end


async def _serve_and_close(serve: Serve, end: MemoryEnd) -> None:
    try:
        await serve(end)
    finally:
        end.close()
