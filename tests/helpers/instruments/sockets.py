"""Connections to an instrument that is served for as long as a test takes."""

import asyncio
import contextlib


@contextlib.asynccontextmanager
async def connections_to(endpoint):
    """Open an endpoint on a free port and hand out a way to connect; all that was opened is closed."""
    address = await endpoint.open("127.0.0.1", 0)
    writers = []

    async def connect():
        reader, writer = await asyncio.open_connection("127.0.0.1", address.port)
        writers.append(writer)
        return reader, writer

    try:
        yield connect
    finally:
        for writer in writers:
            writer.close()
            with contextlib.suppress(ConnectionError):
                await writer.wait_closed()
        await endpoint.close()
