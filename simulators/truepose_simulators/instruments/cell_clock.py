"""The cell's clock as an endpoint: whoever sleeps here lets cell time go by."""

from truepose_drivers.cell_clock.protocol import Answer, Sleep, Time, decode_request, encode
from truepose_drivers.json_lines import JsonLineError, Refusal
from truepose_simulators.cell.clock import CellClock
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.line_endpoint import line_endpoint


def clock_endpoint(clock: CellClock) -> Endpoint:
    """Build the endpoint of a clock."""

    async def reply(line: bytes) -> bytes:
        return encode(await answer(line, clock))

    return line_endpoint("clock", reply)


async def answer(line: bytes, clock: CellClock) -> Answer:
    """Carry out one request line."""
    try:
        request = decode_request(line)
    except JsonLineError as error:
        return Refusal(str(error))
    if isinstance(request, Sleep):
        await clock.sleep(request.duration_s)
    return Time(clock.now_s)
