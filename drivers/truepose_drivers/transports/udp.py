"""Datagrams that one device sends to a port of ours; those of anybody else are dropped."""

import asyncio
import socket
from collections import deque
from typing import Any, Final

from truepose_drivers.errors import ConnectFailedError, ConnectionLostError

_MOST_UNREAD: Final = 32  # datagrams; older ones go


class _Inbox(asyncio.DatagramProtocol):
    """What has arrived from `sender` and was not taken yet."""

    def __init__(self, sender: str) -> None:
        self._sender = sender
        self._arrived: deque[bytes] = deque(maxlen=_MOST_UNREAD)
        self._news = asyncio.Event()

    def datagram_received(self, data: bytes, addr: tuple[str | Any, int]) -> None:
        if addr[0] == self._sender:
            self._arrived.append(data)
            self._news.set()

    async def take(self) -> bytes:
        """Return the oldest datagram, waiting for one."""
        while not self._arrived:
            self._news.clear()
            await self._news.wait()
        return self._arrived.popleft()


class UdpPort:
    """A port of this computer at which the datagrams of one device arrive."""

    def __init__(self, sender: str, port: int) -> None:
        self._sender = sender
        self._port = port
        self._inbox: _Inbox | None = None
        self._transport: asyncio.DatagramTransport | None = None

    @property
    def address(self) -> str:
        """Our port and who sends to it."""
        return f"UDP port {self._port} from {self._sender}"

    @property
    def is_open(self) -> bool:
        """Whether the port listens; nobody can tell whether somebody sends."""
        return self._transport is not None

    async def open(self) -> None:
        """Listen, dropping what was open before; raises ConnectFailedError."""
        await self.close()
        loop = asyncio.get_running_loop()
        try:
            found = await loop.getaddrinfo(self._sender, None, family=socket.AF_INET, type=socket.SOCK_DGRAM)
            sender = str(found[0][4][0])
            self._transport, self._inbox = await loop.create_datagram_endpoint(
                lambda: _Inbox(sender), local_addr=("0.0.0.0", self._port)
            )
        except (OSError, UnicodeError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise ConnectFailedError(
                f"cannot listen at {self.address} ({reason}): check the address, and that no other program"
                " listens there"
            ) from error

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return the oldest datagram not taken yet, None after `timeout_s`; raises ConnectionLostError."""
        if self._inbox is None:
            raise ConnectionLostError(f"nothing is listening at {self.address}: connect first")
        try:
            async with asyncio.timeout(max(timeout_s, 0.0)):
                return await self._inbox.take()
        except TimeoutError:
            return None

    async def close(self) -> None:
        """Listen no more; never raises."""
        transport, self._transport, self._inbox = self._transport, None, None
        if transport is not None:
            transport.close()
            await asyncio.sleep(0)  # which frees the port
