"""Who is connected to a controller, one at a time, and what becomes of a motion when nobody is any more."""

import asyncio
import contextlib
import math
from collections.abc import Awaitable, Callable
from typing import Protocol, TypeVar

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import EndpointUnavailableError, SimulatorError
from truepose_simulators.faults.kinds import LineStalls
from truepose_simulators.instruments.endpoint import Endpoint, Writer, say

_CHUNK_BYTES = 4096
_BEAT_LOOK_S = 0.05  # between two looks at a beat

Answer = TypeVar("Answer")


async def say_to_client(cell: Cell, writer: Writer, data: bytes) -> None:
    """Write to the client of a robot, whose line may stall."""
    await say(writer, data, stalls=cell.faults.holds(LineStalls, cell.clock.now_s))


class ProgramStoppedError(SimulatorError):
    """The controller's program stopped; `drops` says whether its sockets die with it."""

    def __init__(self, message: str, *, drops: bool) -> None:
        super().__init__(message)
        self.drops = drops


class Client(Protocol):
    """Who is connected, as the program hears it while the arm moves."""

    def silent_s(self) -> float:
        """How long nothing was heard [s, cell time]; infinite once the connection is gone."""


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


class ServerProgram:
    """A controller's program that answers one client at a time; our own can watch whoever asks for it."""

    def __init__(self, cell: Cell, server: str | None = None) -> None:
        self._cell = cell
        self._server = server or cell.scenario.arm.server  # instead of which `server` may be stated
        self.forget_client()

    @property
    def is_ours(self) -> bool:
        """Whether the program is our own, which can watch its client."""
        return self._server == "truepose"

    def forget_client(self) -> None:
        """Watch nobody: a client that wants to be watched says so."""
        self._watched_s = 0.0
        self._client: Client = AlwaysThere()

    async def answer_meanwhile_heard(
        self, answer: Callable[[Client | None], Awaitable[Answer]], reader: asyncio.StreamReader
    ) -> Answer:
        """Return an answer; our own program listens for its client meanwhile, the makers' hear nothing."""
        if not self.is_ours:
            return await answer(None)
        ear = ClientMonitor(self._cell)
        return await while_listening(answer(ear), ear, reader)

    def _stopped(self, reason: str) -> ProgramStoppedError:
        return ProgramStoppedError(reason, drops=self._cell.scenario.arm.refusal == "drop")


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
            raise ProgramStoppedError("the client sent nothing", drops=True)
    await cell.glide(duration_s)


class Heartbeat:
    """A number that a client has to change all the time for a motion to go on.

    It is looked at every now and then, where the real programs look every step or are told by an interrupt.
    Where time costs nothing nobody is late.
    """

    def __init__(self, cell: Cell, beat: Callable[[], int], *, silence_s: float) -> None:
        self._cell = cell
        self._beat = beat
        self._silence_s = silence_s

    async def begins(self) -> bool:
        """Whether somebody gives a beat from now on, before the silence is too long."""
        beat, unheard_s = self._beat(), 0.0
        while self._cell.clock.waits and self._beat() == beat and unheard_s < self._silence_s:
            await self._cell.clock.sleep(_BEAT_LOOK_S)
            unheard_s += _BEAT_LOOK_S
        return unheard_s < self._silence_s

    async def lasts(self, duration_s: float) -> bool:
        """Whether the beat goes on while the arm moves for so long; raises ArmStoppedError."""
        beat, unheard_s = self._beat(), 0.0
        while self._cell.clock.waits and duration_s > _BEAT_LOOK_S:
            await self._cell.glide(_BEAT_LOOK_S)
            duration_s -= _BEAT_LOOK_S
            before, beat = beat, self._beat()
            unheard_s = unheard_s + _BEAT_LOOK_S if beat == before else 0.0
            if unheard_s >= self._silence_s:
                return False
        await self._cell.glide(duration_s)
        return True


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
