"""A small application behind the service's own protocol, in the loop of the test, with limits of its own."""

import asyncio
import contextlib
import functools
import socket

import pytest
import uvicorn

from tests.helpers.machine import HANGS_S
from truepose.app.connections import Census, Limits, close_slow_connections
from truepose.app.http_protocol import WatchedProtocol

TIGHT = Limits(
    connections=64,
    head_s=0.3,
    body_grace_s=0.3,
    body_s=30.0,
    answer_grace_s=0.3,
    answer_bytes_per_s=1e9,
)


async def application(scope, receive, send):
    """Answer as much as the path says, once the body is there; /events goes on until nobody listens."""
    if scope["type"] != "http":
        return
    more = True
    while more:
        message = await receive()
        if message["type"] != "http.request":
            return
        more = message.get("more_body", False)
    await send({"type": "http.response.start", "status": 200, "headers": []})
    if scope["path"] == "/events":
        while (await receive())["type"] != "http.disconnect":
            pass
        return
    await send({"type": "http.response.body", "body": b"x" * int(scope["path"].strip("/") or 0)})


@contextlib.asynccontextmanager
async def served(limits=TIGHT):
    """Serve and yield the port and the census."""
    census = Census(limits)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        protocol = functools.partial(WatchedProtocol, census)
        config = uvicorn.Config(application, http=protocol, ws="none", log_config=None, lifespan="off")
        config.timeout_graceful_shutdown = 1
        config.timeout_keep_alive = 60
        server = uvicorn.Server(config)
        server.capture_signals = contextlib.nullcontext
        async with close_slow_connections(census):
            serving = asyncio.create_task(server.serve([listener]))
            yield listener.getsockname()[1], census
            server.should_exit = True
            await serving


@pytest.fixture
async def port():
    async with served() as (found, _):
        yield found


async def connected(port, said=b"", **options):
    reader, writer = await asyncio.open_connection("127.0.0.1", port, **options)
    writer.write(said)
    await writer.drain()
    return reader, writer


async def until_closed(reader):
    """Return what came before the other side closed."""
    received = b""
    with contextlib.suppress(ConnectionError):
        async with asyncio.timeout(HANGS_S):
            while chunk := await reader.read(65536):
                received += chunk
    return received
