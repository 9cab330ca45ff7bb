"""The two sockets of open_abb: motion server and logger, one client each.

After a client leaves, the real program closes its sockets and needs half a second before it accepts again.
A second client is let in by the operating system but hears nothing, until the first one leaves and takes
the server socket with it.
"""

import asyncio
import contextlib
import math
import time
from collections.abc import Awaitable, Callable

import numpy as np

from truepose_drivers.abb_open_abb.protocol import LogLine, encode_log_line
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import EndpointUnavailableError
from truepose_simulators.faults.wire import LineStalls
from truepose_simulators.instruments.ballbars.bad_lines import write_with_stall
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.robot.open_abb import MotionProgram, ProgramStoppedError

_ACCEPT_PAUSE_S = 0.5
_LOG_PERIOD_S = 0.1  # of a virtual controller
_CHUNK_BYTES = 4096

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


def robot_endpoint(cell: Cell, program: MotionProgram) -> Endpoint:
    """Build the motion server of a cell's robot."""

    async def attend(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        program.forget_client()
        while data := await reader.read(_CHUNK_BYTES):
            try:
                reply = await _answer(program, data, reader, cell)
            except ProgramStoppedError as stop:
                if not stop.drops:
                    await _until_client_leaves(reader)
                program.restart()
                return
            if reply is None:
                return
            if cell.faults.holds(LineStalls, cell.clock.now_s):
                await write_with_stall(writer, reply)
            else:
                writer.write(reply)
            await writer.drain()

    return _one_client("robot", "open_abb", attend, cell)


async def _answer(
    program: MotionProgram, data: bytes, reader: asyncio.StreamReader, cell: Cell
) -> bytes | None:
    """Have the program answer; our own listens for its client meanwhile, open_abb's hears nothing."""
    if not program.is_ours:
        return await program.answer(data)
    ear = _Ear(cell)
    listening = asyncio.create_task(ear.listen(reader))
    try:
        return await program.answer(data, ear)
    finally:
        listening.cancel()
        with contextlib.suppress(asyncio.CancelledError, ConnectionError):
            await listening


class _Ear:
    """What our program hears of its client while it does something else; the words are lost, as in RAPID."""

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


def logger_endpoint(cell: Cell, program: MotionProgram) -> Endpoint:
    """Build the logger of a cell's robot: poses and joint angles in turn, as long as somebody listens."""
    date, clock_time = time.strftime("%Y-%m-%d"), time.strftime("%H:%M:%S")

    async def attend(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        gone = asyncio.ensure_future(_until_client_leaves(reader))
        kind = 0
        try:
            while not gone.done():
                elapsed_s = cell.clock.now_s
                numbers = program.pose() if kind == 0 else np.degrees(program.joints()).tolist()
                writer.write(encode_log_line(LogLine(kind, date, clock_time, elapsed_s, tuple(numbers))))
                await writer.drain()
                kind = 1 - kind
                # A stream cannot run in cell time that stands still: its period is wall time.
                await asyncio.wait([gone], timeout=_LOG_PERIOD_S)
        finally:
            gone.cancel()

    return _one_client("robot-log", "open_abb_log", attend, cell)


def _one_client(device: str, protocol: str, attend: Attend, cell: Cell) -> Endpoint:
    # At pace 0 nobody waits in wall time, not even for the controller's pause.
    pause_s = _ACCEPT_PAUSE_S if cell.clock.waits else 0.0
    return OneClientEndpoint(device, protocol, attend, pause_s=pause_s).endpoint


async def _until_client_leaves(reader: asyncio.StreamReader) -> None:
    while await reader.read(_CHUNK_BYTES):
        pass
