"""The service behind a real socket of the loopback interface, in a thread of the test's process."""

import asyncio
import contextlib
import socket
import threading

import uvicorn


@contextlib.contextmanager
def listening(app, door=None):
    """Serve `app` and yield its URL, at a port of its own or at a `door` that others listen at in turn."""
    with socket.create_server(("127.0.0.1", 0)) if door is None else door.dup() as listener:
        config = uvicorn.Config(app, log_config=None, timeout_graceful_shutdown=1)
        # As the service itself does: a client that rests for just the 5 s of the default, on a busy machine,
        # meets the end of its connection.
        config.timeout_keep_alive = 75
        server = uvicorn.Server(config)
        thread = threading.Thread(target=lambda: asyncio.run(_serve(server, listener)))
        thread.start()
        try:
            yield f"http://127.0.0.1:{listener.getsockname()[1]}"
        finally:
            server.should_exit = True
            thread.join()


async def _serve(server, listener):
    """Serve until the end, and close what the other side has not closed by then: a stream of a page, say."""
    await server.serve([listener])
    for connection in list(server.server_state.connections):
        connection.transport.abort()
    await asyncio.sleep(0)  # a transport closes its socket in the loop's next turn
