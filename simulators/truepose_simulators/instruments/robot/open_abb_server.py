"""The two sockets of open_abb: motion server and logger, one client each.

After a client leaves, the real program closes its sockets and needs half a second before it accepts again.
A second client is let in by the operating system but hears nothing, until the first one leaves and takes
the server socket with it.
"""

import asyncio
import time

import numpy as np

from truepose_drivers.abb_open_abb.protocol import LogLine, encode_log_line
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.wire import LineStalls
from truepose_simulators.instruments.ballbars.bad_lines import write_with_stall
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.robot.one_client import one_client_endpoint
from truepose_simulators.instruments.robot.open_abb import MotionProgram
from truepose_simulators.instruments.robot.served_client import (
    Ear,
    ProgramStoppedError,
    until_client_leaves,
    while_listening,
)

_LOG_PERIOD_S = 0.1  # of a virtual controller
_CHUNK_BYTES = 4096


def robot_endpoint(cell: Cell, program: MotionProgram) -> Endpoint:
    """Build the motion server of a cell's robot."""

    async def attend(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        program.forget_client()
        while data := await reader.read(_CHUNK_BYTES):
            try:
                reply = await _answer(program, data, reader, cell)
            except ProgramStoppedError as stop:
                if not stop.drops:
                    await until_client_leaves(reader)
                program.restart()
                return
            if reply is None:
                return
            if cell.faults.holds(LineStalls, cell.clock.now_s):
                await write_with_stall(writer, reply)
            else:
                writer.write(reply)
            await writer.drain()

    return one_client_endpoint("robot", "open_abb", attend, cell)


async def _answer(
    program: MotionProgram, data: bytes, reader: asyncio.StreamReader, cell: Cell
) -> bytes | None:
    """Have the program answer; our own listens for its client meanwhile, open_abb's hears nothing."""
    if not program.is_ours:
        return await program.answer(data)
    ear = Ear(cell)
    return await while_listening(program.answer(data, ear), ear, reader)


def logger_endpoint(cell: Cell, program: MotionProgram) -> Endpoint:
    """Build the logger of a cell's robot: poses and joint angles in turn, as long as somebody listens."""
    date, clock_time = time.strftime("%Y-%m-%d"), time.strftime("%H:%M:%S")

    async def attend(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        gone = asyncio.ensure_future(until_client_leaves(reader))
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

    return one_client_endpoint("robot-log", "open_abb_log", attend, cell)
