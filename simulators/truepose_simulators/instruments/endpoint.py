"""A listening socket with its connections, one that answers lines, and what bad lines make of an answer."""

import asyncio
import contextlib
import json
import re
from collections.abc import Awaitable, Callable
from dataclasses import asdict, dataclass
from typing import Final, Protocol

from truepose_drivers.framing import JsonLineError, LineReader, Refusal, encode_refusal
from truepose_simulators.errors import EndpointUnavailableError
from truepose_simulators.instruments.cable import Cable

# What a client may send ahead of being read; also the longest line of a protocol of lines.
_BUFFER_BYTES = 1 << 16

Serve = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]


@dataclass(frozen=True, slots=True)
class Address:
    """Where an endpoint listens, as it is announced."""

    device: str
    protocol: str
    host: str
    port: int

    def as_json(self) -> str:
        """Return the announcement, one line."""
        return json.dumps(asdict(self))


class Endpoint:
    """Listens and hands every connection to `serve`; can stop listening and begin again on its port."""

    def __init__(
        self, device: str, protocol: str, serve: Serve, *, buffer_bytes: int = _BUFFER_BYTES
    ) -> None:
        self.device = device
        self.protocol = protocol
        self.cable = Cable()
        self._serve = serve
        self._buffer_bytes = buffer_bytes
        self._server: asyncio.Server | None = None
        self._connections: set[asyncio.Task[None]] = set()
        self.port = 0  # at which it listens, 0 before it ever did

    async def open(self, host: str, port: int) -> Address:
        """Listen; port 0 takes a free one. Raises EndpointUnavailableError."""
        try:
            self._server = await asyncio.start_server(self._accept, host, port, limit=self._buffer_bytes)
        except (OSError, OverflowError) as error:
            raise EndpointUnavailableError(
                f"the {self.device} cannot listen on {host}:{port}: {_reason(error)}; choose another port"
            ) from error
        self._host = host
        self.port = self._server.sockets[0].getsockname()[1]
        return Address(self.device, self.protocol, host, self.port)

    def stop_listening(self) -> None:
        """Refuse new connections; those that exist go on."""
        if self._server is not None:
            self._server.close()

    async def listen_again(self) -> None:
        """Accept connections on the same port as before."""
        await self.open(self._host, self.port)

    async def close(self) -> None:
        """Stop listening and drop every connection."""
        self.stop_listening()
        for task in self._connections:
            task.cancel()
        await asyncio.gather(*self._connections, return_exceptions=True)

    def _accept(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.get_running_loop().create_task(self._attend(reader, writer))
        # The loop itself keeps no more than a weak reference to a task, which may then be collected while it
        # runs.
        self._connections.add(task)
        task.add_done_callback(self._connections.discard)

    async def _attend(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        # A client that vanishes is an everyday event for a server, not an error.
        with contextlib.suppress(ConnectionError):
            try:
                ends = await self.cable.connect(reader, writer)
                if ends is not None:
                    await self._serve(*ends)
            finally:
                writer.close()


def _reason(error: Exception) -> str:
    return error.strerror or str(error) if isinstance(error, OSError) else "no such port"


_CHUNK_BYTES = 4096


def line_endpoint(name: str, answer: Callable[[bytes], Awaitable[bytes]]) -> Endpoint:
    """Build the endpoint of a device that is called as its protocol is."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        lines = LineReader()
        while data := await reader.read(_CHUNK_BYTES):
            lines.receive_data(data)
            try:
                while (line := lines.next_message()) is not None:
                    writer.write(await answer(line))
            except JsonLineError as error:  # no end of line in sight: nothing can be read any more
                writer.write(encode_refusal(Refusal(str(error))))
                return
            await writer.drain()

    return Endpoint(name, name, serve)


_STALL_S: Final = 0.05  # wall time: a line knows no other
_FIRST_DIGIT: Final = re.compile(rb"([+-])(\d)")


class Writer(Protocol):
    """What is needed of a stream."""

    def write(self, data: bytes) -> None:
        """Hand over `data`."""

    async def drain(self) -> None:
        """Wait until it is gone."""


async def say(writer: Writer, data: bytes, *, stalls: bool) -> None:
    """Write `data`, on a line that stalls in two halves with a pause between them."""
    half = len(data) // 2 if stalls else 0
    if stalls:
        writer.write(data[:half])
        await writer.drain()
        await asyncio.sleep(_STALL_S)
    writer.write(data[half:])
    await writer.drain()


def with_doubled_digit(data: bytes) -> bytes:
    """Return `data` with the first digit behind each sign twice."""
    return _FIRST_DIGIT.sub(rb"\1\2\2", data)
