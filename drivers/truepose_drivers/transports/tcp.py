"""A TCP connection as a link."""

import asyncio
import contextlib

from truepose_drivers import options as option
from truepose_drivers.api import Options
from truepose_drivers.errors import ConnectFailedError, ConnectionLostError

_RECEIVE_BYTES = 65_536
_CLOSE_TIMEOUT_S = 1.0  # a peer that does not say goodbye must not hold up a shutdown


class TcpLink:
    """A TCP client connection with time-outs in wall time."""

    def __init__(self, host: str, port: int, *, connect_timeout_s: float = 5.0, send_timeout_s: float = 10.0):
        self._host = host
        self._port = port
        self._connect_timeout_s = connect_timeout_s
        self._send_timeout_s = send_timeout_s
        self._streams: tuple[asyncio.StreamReader, asyncio.StreamWriter] | None = None

    @property
    def address(self) -> str:
        """Host and port."""
        return f"{self._host}:{self._port}"

    @property
    def is_open(self) -> bool:
        """Whether the connection is up; a peer that closed it is noticed without asking."""
        return self._streams is not None and not self._streams[0].at_eof()

    async def open(self) -> None:
        """Connect, dropping what was open before; raises ConnectFailedError."""
        await self.close()
        try:
            async with asyncio.timeout(self._connect_timeout_s):
                self._streams = await asyncio.open_connection(self._host, self._port)
        except TimeoutError as error:
            raise ConnectFailedError(
                f"nobody answers at {self.address} within {self._connect_timeout_s:g} s:"
                " check power, cable and address"
            ) from error
        except (OSError, UnicodeError) as error:  # UnicodeError: no name of a host
            reason = getattr(error, "strerror", None) or str(error)
            raise ConnectFailedError(
                f"no connection to {self.address} ({reason}): check power, cable and address"
            ) from error

    async def send(self, data: bytes) -> None:
        """Hand `data` to the network; raises ConnectionLostError."""
        _, writer = self._opened()
        try:
            async with asyncio.timeout(self._send_timeout_s):
                writer.write(data)
                await writer.drain()
        except OSError as error:  # TimeoutError is one
            raise await self._lost() from error

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return what has arrived, None after `timeout_s` of silence; raises ConnectionLostError."""
        reader, _ = self._opened()
        if timeout_s <= 0.0:
            await _let_arrive()
        try:
            async with asyncio.timeout(timeout_s) as deadline:
                data = await reader.read(_RECEIVE_BYTES)
        except OSError as error:
            if deadline.expired():
                return None
            raise await self._lost() from error
        if not data:
            raise await self._lost()
        return data

    async def close(self) -> None:
        """Close the connection; never raises."""
        if self._streams is None:
            return
        _, writer = self._streams
        self._streams = None
        writer.close()
        with contextlib.suppress(OSError):
            async with asyncio.timeout(_CLOSE_TIMEOUT_S):
                await writer.wait_closed()

    def _opened(self) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
        if self._streams is None:
            raise ConnectionLostError(f"there is no connection to {self.address}: connect first")
        return self._streams

    async def _lost(self) -> ConnectionLostError:
        await self.close()
        return ConnectionLostError(
            f"the connection to {self.address} is gone: check power and cable, then connect again"
        )


async def _let_arrive() -> None:
    """Let the event loop fetch what the system has received: one turn to look, one to take it."""
    for _ in range(2):
        await asyncio.sleep(0)


def tcp_link(options: Options, default_port: int | None = None) -> TcpLink:
    """Return the link of the options host and port; raises ConfigurationError."""
    return TcpLink(option.host(options), option.port(options, default_port))
