"""The two sockets of MAPPDK, one client each: both take all requests, and neither ends a reply.

The logger's has a task of its own on the controller, so that it tells joints while the arm moves.
"""

import asyncio

from truepose_drivers.fanuc_mappdk.protocol import GREETING, Command, RequestReader, encode_reply
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.wire import LineStalls
from truepose_simulators.instruments.ballbars.bad_lines import write_with_stall
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.robot.mappdk import MappdkProgram
from truepose_simulators.instruments.robot.one_client import one_client_endpoint
from truepose_simulators.instruments.robot.served_client import (
    Ear,
    ProgramStoppedError,
    until_client_leaves,
    while_listening,
)

_CHUNK_BYTES = 4096


def mappdk_endpoint(cell: Cell, program: MappdkProgram) -> Endpoint:
    """Build the motion server of a cell's robot."""
    return _endpoint("robot", "mappdk", cell, program)


def mappdk_logger_endpoint(cell: Cell, program: MappdkProgram) -> Endpoint:
    """Build the second server, for questions while the first one moves."""
    return _endpoint("robot-logger", "mappdk_log", cell, program)


def _endpoint(device: str, protocol: str, cell: Cell, program: MappdkProgram) -> Endpoint:
    async def attend(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        program.forget_client()
        writer.write(encode_reply(GREETING))
        await writer.drain()
        try:
            await _Attendance(cell, program, reader, writer).serve()
        except ProgramStoppedError as stop:
            if not stop.drops:
                await until_client_leaves(reader)

    return one_client_endpoint(device, protocol, attend, cell)


class _Attendance:
    """One client and the program."""

    def __init__(
        self, cell: Cell, program: MappdkProgram, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        self._cell = cell
        self._program = program
        self._reader = reader
        self._writer = writer

    async def serve(self) -> None:
        """Answer until the client says that it goes, or is gone."""
        lines = RequestReader()
        while data := await self._reader.read(_CHUNK_BYTES):
            lines.receive_data(data)
            while (line := lines.next_message()) is not None:
                await self._say(await self._answer(line))
                if line == Command.EXIT:
                    await until_client_leaves(self._reader)
                    return

    async def _answer(self, line: str) -> bytes:
        """Have the program answer; our own listens for its client meanwhile, the stock one hears nothing."""
        if not self._program.is_ours:
            return await self._program.answer(line)
        ear = Ear(self._cell)
        return await while_listening(self._program.answer(line, ear), ear, self._reader)

    async def _say(self, reply: bytes) -> None:
        if self._cell.faults.holds(LineStalls, self._cell.clock.now_s):
            await write_with_stall(self._writer, reply)
        else:
            self._writer.write(reply)
        await self._writer.drain()
