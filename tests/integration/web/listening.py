"""The service behind a real socket of the loopback interface, in a thread of the test's process."""

import asyncio
import contextlib
import socket
import threading

import uvicorn


@contextlib.contextmanager
def listening(app):
    """Serve `app` and yield its URL."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        server = uvicorn.Server(uvicorn.Config(app, log_config=None, timeout_graceful_shutdown=1))
        thread = threading.Thread(target=lambda: asyncio.run(server.serve([listener])))
        thread.start()
        try:
            yield f"http://127.0.0.1:{listener.getsockname()[1]}"
        finally:
            server.should_exit = True
            thread.join()
