"""An endpoint of one of our protocols of JSON lines: each line that arrives is answered with a line."""

import asyncio
from collections.abc import Awaitable, Callable

from truepose_drivers.json_lines import JsonLineError, LineReader, Refusal, encode_refusal
from truepose_simulators.instruments.endpoint import Endpoint

_CHUNK_BYTES = 4096


def line_endpoint(name: str, answer: Callable[[bytes], Awaitable[bytes]]) -> Endpoint:
    """Build the endpoint of a device that is called as its protocol is."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        lines = LineReader()
        while data := await reader.read(_CHUNK_BYTES):
            lines.receive_data(data)
            try:
                while (line := lines.next_message()) is not None:
                    writer.write(await answer(line))
            except JsonLineError as error:  # no end of line in sight: nothing can be read any more
                writer.write(encode_refusal(Refusal(str(error))))
                return
            await writer.drain()

    return Endpoint(name, name, serve)
