"""The simulated person's hands as an endpoint: JSON lines in, one deed after the other."""

import asyncio
import inspect
from collections.abc import Awaitable, Mapping
from typing import Protocol

from truepose_drivers.cell_hands.protocol import Answer, Detail, Done, Who, decode_request, encode
from truepose_drivers.json_lines import JsonLineError, Refusal
from truepose_simulators.errors import SimulatorError
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.line_endpoint import line_endpoint

_WHO = "simulated hands"


class Hands(Protocol):
    """What the person at the cell can be asked to do."""

    def do(self, action: str, details: Mapping[str, Detail]) -> Awaitable[None] | None:
        """Do one thing, or raise SimulatorError with a sentence."""
        ...


def hands_endpoint(hands: Hands) -> Endpoint:
    """Build the endpoint of the hands; deeds asked for over several connections follow one another."""
    busy = asyncio.Lock()

    async def reply(line: bytes) -> bytes:
        async with busy:
            return encode(await answer(line, hands))

    return line_endpoint("hands", reply)


async def answer(line: bytes, hands: Hands) -> Answer:
    """Carry out one request line."""
    try:
        request = decode_request(line)
        if isinstance(request, Who):
            return Done(_WHO)
        doing = hands.do(request.action, request.details)
        if inspect.isawaitable(doing):
            await doing
    except (JsonLineError, SimulatorError) as error:
        return Refusal(str(error))
    return Done()
