"""A client that sends a request and goes away before the answer."""

import asyncio

from tests.helpers.machine import HANGS_S


class LeavingClient:
    """One request on a connection that ends when the test says so."""

    def __init__(self, app, path, body, media_type):
        self._received = asyncio.Queue()
        self._received.put_nowait({"type": "http.request", "body": body, "more_body": False})
        headers = {"host": "localhost", "content-type": media_type, "content-length": str(len(body))}
        scope = {
            "type": "http",
            "method": "POST",
            "path": path,
            "query_string": b"",
            "headers": [(name.encode(), value.encode()) for name, value in headers.items()],
            "client": ("127.0.0.1", 1),
            "server": ("127.0.0.1", 8000),
        }
        self._request = asyncio.create_task(app(scope, self._received.get, self._send))

    async def leave(self):
        """End the connection and wait until the service has noticed."""
        self._received.put_nowait({"type": "http.disconnect"})
        async with asyncio.timeout(HANGS_S):
            await self._request

    async def _send(self, message):
        pass


class Waiting:
    """Works for ever, until that is not wanted any more."""

    def __init__(self):
        self.begun, self.ended = asyncio.Event(), asyncio.Event()

    async def __call__(self, *_):
        self.begun.set()
        try:
            await asyncio.Event().wait()
        finally:
            self.ended.set()
