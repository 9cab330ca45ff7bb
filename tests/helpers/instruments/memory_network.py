"""Listening and connecting without sockets, so that an instrument can be served in simulated time."""

import asyncio
from itertools import count
from types import SimpleNamespace


class MemoryNetwork:
    """Stands in for `asyncio.start_server` and `asyncio.open_connection`."""

    def __init__(self) -> None:
        self._free_ports = count(1)
        self._accepting = {}

    async def start_server(self, accept, host, port, **_):
        port = port or next(self._free_ports)
        self._accepting[port] = accept
        address = SimpleNamespace(getsockname=lambda: (host, port))
        return SimpleNamespace(sockets=[address], close=lambda: self._accepting.pop(port, None))

    async def open_connection(self, host, port):
        if port not in self._accepting:
            raise ConnectionRefusedError
        here, there = asyncio.StreamReader(), asyncio.StreamReader()
        self._accepting[port](there, _Writer(here, there))
        return here, _Writer(there, here)


class _Writer:
    """Writes into the other end's reader; closing ends both directions."""

    def __init__(self, far, near) -> None:
        self._far, self._near = far, near

    def write(self, data) -> None:
        if not self.is_closing():
            self._far.feed_data(data)

    async def drain(self) -> None:
        await asyncio.sleep(0)

    def is_closing(self) -> bool:
        return self._near._eof

    def close(self) -> None:
        self._far.feed_eof()
        self._near.feed_eof()

    async def wait_closed(self) -> None:
        await asyncio.sleep(0)
