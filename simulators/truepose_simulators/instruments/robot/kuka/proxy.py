"""The variable proxy in front of the controller: any number of clients, and nobody who is silent for long."""

import asyncio
import contextlib

from truepose_drivers.kuka_variable_proxy.protocol.frames import (
    ProxyProtocolError,
    RequestReader,
    encode_answer,
)
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.wire import LineStalls
from truepose_simulators.instruments.ballbars.bad_lines import write_with_stall
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.robot.kuka.variables import Variables

_CHUNK_BYTES = 2048
_HANGS_UP_AFTER_S = 30.0  # of silence, wall time


def proxy_endpoint(cell: Cell, variables: Variables) -> Endpoint:
    """Build the proxy of a cell's robot."""

    async def say(writer: asyncio.StreamWriter, data: bytes) -> None:
        if cell.faults.holds(LineStalls, cell.clock.now_s):
            await write_with_stall(writer, data)
        else:
            writer.write(data)
        await writer.drain()

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        requests = RequestReader()
        with contextlib.suppress(ProxyProtocolError, TimeoutError):  # it hangs up
            while data := await asyncio.wait_for(reader.read(_CHUNK_BYTES), _HANGS_UP_AFTER_S):
                requests.receive_data(data)
                while (request := requests.next_message()) is not None:
                    await say(writer, encode_answer(variables.answer(request)))

    return Endpoint("robot", "kuka_variable_proxy", serve)
