"""Who is connected to a controller, one at a time, and what becomes of a motion when nobody is any more."""

import asyncio
import contextlib
import math
from collections.abc import Awaitable, Callable
from typing import Protocol, TypeVar

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import EndpointUnavailableError, SimulatorError
from truepose_simulators.instruments.endpoint import Endpoint

_CHUNK_BYTES = 4096

Answer = TypeVar("Answer")


class ProgramStoppedError(SimulatorError):
    """The controller's program stopped; `drops` says whether its sockets die with it."""

    def __init__(self, message: str, *, drops: bool) -> None:
        super().__init__(message)
        self.drops = drops


class Client(Protocol):
    """Who is connected, as the program hears it while the arm moves."""

    def silent_s(self) -> float:
        """How long nothing was heard [s, cell time]; infinite once the connection is gone."""
        ...


class AlwaysThere:
    """A client that is heard all the time."""

    def silent_s(self) -> float:
        """Never silent."""
        return 0.0


class ClientMonitor:
    """What a program hears of its client while it does something else; the words are lost."""

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._heard_s = cell.clock.now_s
        self._gone = False

    def silent_s(self) -> float:
        """How long nothing was heard [s, cell time]; infinite once the connection is gone."""
        return math.inf if self._gone else self._cell.clock.now_s - self._heard_s

    async def listen(self, reader: asyncio.StreamReader) -> None:
        """Listen until the client is gone."""
        try:
            while await reader.read(_CHUNK_BYTES):
                self._heard_s = self._cell.clock.now_s
        finally:
            self._gone = reader.at_eof() or reader.exception() is not None


async def while_listening(
    answer: Awaitable[Answer], ear: ClientMonitor, reader: asyncio.StreamReader
) -> Answer:
    """Return an answer that takes a while; meanwhile the client is heard."""
    listening = asyncio.create_task(ear.listen(reader))
    try:
        return await answer
    finally:
        listening.cancel()
        with contextlib.suppress(asyncio.CancelledError, ConnectionError):
            await listening


async def until_client_leaves(reader: asyncio.StreamReader) -> None:
    """Return when the client is gone."""
    while await reader.read(_CHUNK_BYTES):
        pass


async def rest_after(
    cell: Cell, duration_s: float, client: Client, *, watched_s: float, look_s: float
) -> None:
    """Wait for the end of a motion; a watched one is given up when its client falls silent.

    Raises ProgramStoppedError then, and ArmStoppedError. 0 for `watched_s` watches nobody.
    """
    watched = watched_s > 0.0 and cell.clock.waits  # where time costs nothing nobody is late
    while watched and duration_s > look_s:
        await cell.glide(look_s)
        duration_s -= look_s
        if client.silent_s() > watched_s:
            cell.halt_robot()
            raise ProgramStoppedError("nothing was heard of the client", drops=True)
    await cell.glide(duration_s)


_ACCEPT_PAUSE_S = 0.5

Attend = Callable[[asyncio.StreamReader, asyncio.StreamWriter], Awaitable[None]]


class OneClientEndpoint:
    """An endpoint that serves one client and pauses between two."""

    def __init__(self, device: str, protocol: str, attend: Attend, *, pause_s: float) -> None:
        self.endpoint = Endpoint(device, protocol, self._serve)
        self._attend = attend
        self._pause_s = pause_s
        self._free = asyncio.Event()
        self._free.set()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if not self._free.is_set():
            await self._free.wait()
            return
        self._free.clear()
        try:
            await self._attend(reader, writer)
        finally:
            writer.close()
            self._free.set()
        if self._pause_s > 0.0:
            self.endpoint.stop_listening()
            await self._listen_after_pause()

    async def _listen_after_pause(self) -> None:
        while True:
            await asyncio.sleep(self._pause_s)
            # Meanwhile the system may have lent the port to somebody's outgoing connection: try again.
            with contextlib.suppress(EndpointUnavailableError):
                await self.endpoint.listen_again()
                return


def one_client_endpoint(device: str, protocol: str, attend: Attend, cell: Cell) -> Endpoint:
    """Build the endpoint of a program that serves one client at a time."""
    # At pace 0 nobody waits in wall time, not even for the controller's pause.
    pause_s = _ACCEPT_PAUSE_S if cell.clock.waits else 0.0
    return OneClientEndpoint(device, protocol, attend, pause_s=pause_s).endpoint
