"""The socket of the emScon server: one client, one command at a time, packets that nobody asked for."""

import asyncio
import contextlib
from collections import deque
from collections.abc import Callable

from truepose_drivers.leica_emscon import protocol
from truepose_drivers.leica_emscon.protocol.settings import SystemParameter
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.leica_emscon.conversation import Dialogue
from truepose_simulators.instruments.leica_emscon.settings import CutShort, HangUp, Step, Steps, Wait

_CHUNK_BYTES = 65_536
_POSITIONS_PER_S = 3.0
_STOPPABLE = frozenset({
    protocol.Command.START_MEASUREMENT,
    protocol.Command.GO_AND_MEASURE,
    protocol.Command.START_NIVEL_MEASUREMENT,
})


def tracker_endpoint(cell: Cell) -> Endpoint:
    """Build the emScon server of a cell's tracker."""
    dialogue = Dialogue(cell)
    owner: Connection | None = None  # the application that has the tracker

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        nonlocal owner
        connection = Connection(dialogue, cell.clock, writer)

        def may_ask() -> bool:
            nonlocal owner
            # One application at a time, as an AT40x has it: a second one is answered 10011 and may stay
            # connected.
            owner = owner or connection
            return owner is connection

        try:
            await connection.attend(reader, may_ask)
        finally:
            connection.leave()
            if owner is connection:
                owner = None

    return Endpoint("tracker", "emscon", serve)


class Connection:
    """One client's connection."""

    def __init__(self, dialogue: Dialogue, clock: CellClock, writer: asyncio.StreamWriter) -> None:
        self._dialogue = dialogue
        self._clock = clock
        self._writer = writer
        self._running: tuple[int, asyncio.Task[None]] | None = None
        self._queue: deque[protocol.Request] = deque()
        self._stream: asyncio.Task[None] | None = None

    async def attend(self, reader: asyncio.StreamReader, may_ask: Callable[[], bool]) -> None:
        """Read and answer requests until the client leaves."""
        frames = protocol.FrameReader()
        with contextlib.suppress(protocol.PacketError):  # no packet in sight any more: hang up
            while not self._writer.is_closing() and (data := await reader.read(_CHUNK_BYTES)):
                frames.receive_data(data)
                while (frame := frames.next_message()) is not None:
                    try:
                        request = protocol.decode_request(frame)
                    except protocol.ShortRequestError as error:
                        self._send(protocol.Answer(error.command, protocol.ResultStatus.WRONG_PARAMETER))
                        continue
                    if may_ask():
                        await self._receive(request)
                    else:
                        self._send(
                            protocol.Answer(
                                request.command, protocol.ResultStatus.MULTI_CONNECTIONS_NOT_ALLOWED
                            )
                        )
                await self._writer.drain()

    def leave(self) -> None:
        """Break off what runs for this client."""
        for task in (self._running and self._running[1], self._stream):
            if task:
                task.cancel()

    async def _receive(self, request: protocol.Request) -> None:
        if self._running is None:
            await self._run(request)
        elif request.command == protocol.Command.STOP_MEASUREMENT:
            await self._stop(request)
        elif request.command == protocol.Command.CLEAR_COMMAND_QUEUE:
            self._queue.clear()
            self._send(protocol.Answer(request.command))
        elif len(self._queue) < self._queue_size:
            self._queue.append(request)
        else:
            self._send(protocol.Answer(request.command, protocol.ResultStatus.SERVER_BUSY))

    async def _run(self, request: protocol.Request) -> None:
        """Take the steps of a request; as soon as one takes wall time, a task goes on with them."""
        steps = self._dialogue.handle(request)
        for step in steps:
            if isinstance(step, Wait) and self._takes_time(step):
                task = asyncio.get_running_loop().create_task(self._go_on(step, steps))
                self._running = (request.command, task)
                return
            await self._take(step)
        self._watch_stream()

    def _takes_time(self, wait: Wait) -> bool:
        return (self._clock.waits or wait.stoppable) and wait.duration_s > 0.0

    async def _go_on(self, wait: Wait, steps: Steps) -> None:
        await self._take(wait)
        for step in steps:
            await self._take(step)
        self._running = None
        self._watch_stream()
        while self._queue and self._running is None:
            await self._run(self._queue.popleft())

    async def _take(self, step: Step) -> None:
        match step:
            case Wait(duration_s, stoppable):
                await self._clock.sleep(duration_s)
                # In cell time that costs nothing a stream would never let the word through that ends it.
                if stoppable and not self._clock.waits:
                    await asyncio.sleep(duration_s)
            case HangUp():
                self._writer.close()
            case CutShort(packet):
                data = protocol.encode(packet)
                self._writer.write(data[: len(data) // 2])
                self._writer.close()
            case _:
                self._send(step)

    async def _stop(self, request: protocol.Request) -> None:
        """Break a running measurement off; other commands run to their end."""
        if self._running is not None and self._running[0] in _STOPPABLE:
            self._running[1].cancel()
            self._running = None
        await self._run(request)

    @property
    def _queue_size(self) -> int:
        return self._dialogue.settings.long_parameters[SystemParameter.TCP_COMMAND_QUEUE_SIZE]

    def _send(self, packet: protocol.FromServer) -> None:
        if not self._writer.is_closing():
            self._writer.write(protocol.encode(packet))

    def _watch_stream(self) -> None:
        """Start or end the stream of reflector positions, as the settings now say."""
        wanted = self._dialogue.settings.flag("send_reflector_position_data")
        if wanted and self._stream is None:
            self._stream = asyncio.get_running_loop().create_task(self._stream_positions())
        elif not wanted and self._stream is not None:
            self._stream.cancel()
            self._stream = None

    async def _stream_positions(self) -> None:
        while True:
            # A stream cannot run in cell time that stands still: its period is wall time.
            await asyncio.sleep(1.0 / _POSITIONS_PER_S)
            position = None if self._running else self._dialogue.shooting.reflector_position()
            if position is not None:
                self._send(position)
