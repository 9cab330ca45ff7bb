"""A TCP connection as a link, which its own system ends where the peer is gone.

A peer whose cable was pulled says nothing, like one whose arm moves for a minute. The two systems tell them
apart: they ask each other whether they are there, whatever the programs on them do.

A driver asks after every answer, and before every question, whether more has arrived. That must cost next to
nothing: what arrives is kept by the connection itself, and the system is asked whether it has received
anything, so that most looks take no turn of the event loop, and none takes a timer or a cancelled wait.
"""

import asyncio
import contextlib
import select
import socket
from collections.abc import Callable
from typing import Final, cast

from truepose_drivers import options as option
from truepose_drivers.api import Options
from truepose_drivers.errors import ConnectFailedError, ConnectionLostError

_LOST_AFTER_MS: Final = 1500  # in which the peer's system acknowledges nothing
_ASKED_EVERY_S: Final = 1  # by the system, while nothing is sent
_SETTINGS: Final = (
    ("TCP_KEEPIDLE", _ASKED_EVERY_S),
    ("TCP_KEEPINTVL", _ASKED_EVERY_S),
    ("TCP_KEEPCNT", 1),
    ("TCP_USER_TIMEOUT", _LOST_AFTER_MS),
)


def watch_peer(connection: socket.socket) -> None:
    """Have the system end a connection within two seconds of the peer's going, as far as this system can."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in _SETTINGS:
        if hasattr(socket, name):
            connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)


_MOST_UNREAD_BYTES = 65_536  # more is left to the system until that was taken
_CLOSE_TIMEOUT_S = 1.0  # a peer that does not say goodbye must not hold up a shutdown


class _Connection(asyncio.Protocol):
    """What has arrived and was not taken yet, and how the connection stands."""

    def __init__(self) -> None:
        self._arrived = bytearray()
        self._news = asyncio.Event()  # bytes, or the end
        self._takes_more = asyncio.Event()
        self._takes_more.set()
        self._closed = asyncio.Event()
        self.ended = False

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast(asyncio.Transport, transport)
        peer = transport.get_extra_info("socket")
        watch_peer(peer)
        self._received = _received_by(peer.fileno())

    def data_received(self, data: bytes) -> None:
        self._arrived += data
        self._news.set()
        if len(self._arrived) >= _MOST_UNREAD_BYTES:
            self._transport.pause_reading()

    def eof_received(self) -> None:
        self._end()

    def connection_lost(self, exc: Exception | None) -> None:
        self._end()
        self._takes_more.set()
        self._closed.set()

    def pause_writing(self) -> None:
        self._takes_more.clear()

    def resume_writing(self) -> None:
        self._takes_more.set()

    def _end(self) -> None:
        self.ended = True
        self._news.set()

    @property
    def is_up(self) -> bool:
        """Whether there is, or may come, something to take."""
        return bool(self._arrived) or not self.ended

    def take(self) -> bytes:
        """Return what has arrived, nothing where that is nothing."""
        data = bytes(self._arrived)
        self._arrived.clear()
        if not self.ended:
            self._news.clear()
            self._transport.resume_reading()
        return data

    async def let_arrive(self) -> None:
        """Let the event loop fetch what the system has received: one turn to look, one to take it."""
        if not self._arrived and self._received():
            for _ in range(2):
                await asyncio.sleep(0)

    async def happens(self) -> None:
        """Return once something has arrived, or nothing will."""
        await self._news.wait()

    async def send(self, data: bytes, timeout_s: float) -> None:
        """Hand `data` to the network; raises ConnectionResetError, TimeoutError where it takes no more."""
        self._transport.write(data)
        if not self._takes_more.is_set():
            async with asyncio.timeout(timeout_s):
                await self._takes_more.wait()
        if self._closed.is_set():
            raise ConnectionResetError

    async def close(self) -> None:
        """Close, and return once that is done."""
        self._transport.close()
        await self._closed.wait()


class TcpLink:
    """A TCP client connection with time-outs in wall time."""

    def __init__(self, host: str, port: int, *, connect_timeout_s: float = 5.0, send_timeout_s: float = 10.0):
        self._host = host
        self._port = port
        self._connect_timeout_s = connect_timeout_s
        self._send_timeout_s = send_timeout_s
        self._connection: _Connection | None = None

    @property
    def address(self) -> str:
        """Host and port."""
        return f"{self._host}:{self._port}"

    @property
    def is_open(self) -> bool:
        """Whether the connection is up; a peer that closed it is noticed without asking."""
        return self._connection is not None and self._connection.is_up

    async def open(self) -> None:
        """Connect, dropping what was open before; raises ConnectFailedError."""
        await self.close()
        try:
            async with asyncio.timeout(self._connect_timeout_s):
                loop = asyncio.get_running_loop()
                _, self._connection = await loop.create_connection(_Connection, self._host, self._port)
        except TimeoutError as error:
            raise ConnectFailedError(
                f"no response from {self.address} within {self._connect_timeout_s:g} s:"
                " check power, cable and address"
            ) from error
        except (OSError, UnicodeError) as error:  # UnicodeError: no name of a host
            reason = getattr(error, "strerror", None) or str(error)
            raise ConnectFailedError(
                f"no connection to {self.address} ({reason}): check power, cable and address"
            ) from error

    async def send(self, data: bytes) -> None:
        """Hand `data` to the network; raises ConnectionLostError."""
        connection = self._opened()
        try:
            await connection.send(data, self._send_timeout_s)
        except OSError as error:  # TimeoutError is one
            raise await self._lost() from error

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return what has arrived, None after `timeout_s` of silence; raises ConnectionLostError."""
        connection = self._opened()
        if timeout_s <= 0.0:
            await connection.let_arrive()
        else:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(timeout_s):
                    await connection.happens()
        data = connection.take()
        if not data and connection.ended:
            raise await self._lost()
        return data or None

    async def close(self) -> None:
        """Close the connection; never raises."""
        connection, self._connection = self._connection, None
        if connection is not None:
            with contextlib.suppress(OSError):
                async with asyncio.timeout(_CLOSE_TIMEOUT_S):
                    await connection.close()

    def _opened(self) -> _Connection:
        if self._connection is None:
            raise ConnectionLostError(f"not connected to {self.address}: connect first")
        return self._connection

    async def _lost(self) -> ConnectionLostError:
        await self.close()
        return ConnectionLostError(
            f"the connection to {self.address} was lost: check power and cable, then connect again"
        )


def _received_by(connection: int) -> Callable[[], bool]:
    """Return what tells whether the system has received something, or the end, that was not fetched yet."""
    if not hasattr(select, "poll"):
        return lambda: True
    poll = select.poll()
    poll.register(connection, select.POLLIN)
    return lambda: bool(poll.poll(0))


def tcp_link(options: Options, default_port: int | None = None, *, port: str = "port") -> TcpLink:
    """Return the link of the options host and `port`; raises ConfigurationError."""
    return TcpLink(option.host(options), option.port(options, default_port, name=port))
