"""The cell's clock as an endpoint: whoever sleeps here lets cell time go by."""

import asyncio

from truepose_drivers.cell_clock.protocol import Answer, Refusal, Sleep, Time, decode_request, encode
from truepose_drivers.json_lines import JsonLineError, LineReader
from truepose_simulators.cell.clock import CellClock
from truepose_simulators.instruments.endpoint import Endpoint

_CHUNK_BYTES = 4096


def clock_endpoint(clock: CellClock) -> Endpoint:
    """Build the endpoint of a clock."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        lines = LineReader()
        while data := await reader.read(_CHUNK_BYTES):
            lines.receive_data(data)
            try:
                while (line := lines.next_message()) is not None:
                    writer.write(encode(await answer(line, clock)))
            except JsonLineError as error:  # no end of line in sight: nothing can be read any more
                writer.write(encode(Refusal(str(error))))
                return
            await writer.drain()

    return Endpoint("clock", "clock", serve)


async def answer(line: bytes, clock: CellClock) -> Answer:
    """Carry out one request line."""
    try:
        request = decode_request(line)
    except JsonLineError as error:
        return Refusal(str(error))
    if isinstance(request, Sleep):
        await clock.sleep(request.duration_s)
    return Time(clock.now_s)
