"""The simulated person's hands as an endpoint: JSON lines in, one deed after the other."""

import asyncio
import inspect
from collections.abc import Awaitable, Mapping
from typing import Protocol

from truepose_drivers.cell_hands.protocol import Answer, Detail, Done, Refusal, Who, decode_request, encode
from truepose_drivers.json_lines import JsonLineError, LineReader
from truepose_simulators.errors import SimulatorError
from truepose_simulators.instruments.endpoint import Endpoint

_CHUNK_BYTES = 4096
_WHO = "simulated hands"


class Hands(Protocol):
    """What the person at the cell can be asked to do."""

    def do(self, action: str, details: Mapping[str, Detail]) -> Awaitable[None] | None:
        """Do one thing, or raise SimulatorError with a sentence."""
        ...


def hands_endpoint(hands: Hands) -> Endpoint:
    """Build the endpoint of the hands; deeds asked for over several connections follow one another."""
    busy = asyncio.Lock()

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        lines = LineReader()
        while data := await reader.read(_CHUNK_BYTES):
            lines.receive_data(data)
            try:
                while (line := lines.next_message()) is not None:
                    async with busy:
                        writer.write(encode(await answer(line, hands)))
            except JsonLineError as error:  # no end of line in sight: nothing can be read any more
                writer.write(encode(Refusal(str(error))))
                return
            await writer.drain()

    return Endpoint("hands", "hands", serve)


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
