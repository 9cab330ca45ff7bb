"""Every request is named, timed and logged: outermost, so that what security refuses is too.

A line holds the operation and what came of it. It holds no address, query, header or body: addresses can be
secrets (the one-time link, the watch link), and so can the rest.
"""

import logging
import time
from typing import Final

from starlette.datastructures import Headers, MutableHeaders
from starlette.routing import BaseRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from truepose.correlation import REQUEST, request_named
from truepose.web.middleware.metrics import Metrics

HEADER: Final = "X-Request-ID"
LOGGER: Final = "truepose.requests"
_LOG: Final = logging.getLogger(LOGGER)
_FAILED: Final = 500
_STREAM: Final = "text/event-stream"
# Asked so often, by programs and pages, that their lines would hide all others.
_OFTEN: Final = {"get_health", "get_metrics", "static_file"}
NO_OPERATION: Final = "none"  # refused before a route was found


class RequestLog:
    """ASGI middleware: gives each request its name, and says what became of it."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self._app = app
        self._metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on and watch its answer."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        name = request_named(Headers(scope=scope).get(HEADER))
        before = REQUEST.set(name)
        answer = _Answer(name, scope, send, self._metrics)
        try:
            await self._app(scope, receive, answer.send)
        finally:
            answer.end()
            REQUEST.reset(before)


class _Answer:
    """One answer on its way."""

    def __init__(self, name: str, scope: Scope, send: Send, metrics: Metrics) -> None:
        self._name = name
        self._scope = scope
        self._send = send
        self._metrics = metrics
        self._begun_s = time.perf_counter()
        self._status: int | None = None
        self._streams = False

    async def send(self, message: Message) -> None:
        """Add the name to the head of the answer and count it."""
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            headers[HEADER] = self._name
            self._begin(message["status"], headers.get("content-type", "").startswith(_STREAM))
        await self._send(message)

    def _begin(self, status: int, streams: bool) -> None:
        self._status, self._streams = status, streams
        # Timed to the head of the answer: the body of a stream lasts for hours.
        self._metrics.answered(self._operation, status, time.perf_counter() - self._begun_s)
        if streams:
            self._metrics.streaming(+1)

    def end(self) -> None:
        """Say what became of the request."""
        if self._streams:
            self._metrics.streaming(-1)
        operation, status = self._operation, self._status
        told = {
            "operation": operation,
            "method": self._scope["method"],
            "status": status,
            "ms": round(1000 * (time.perf_counter() - self._begun_s), 1),
        }
        became = "client disconnected before the response" if status is None else f"answered with {status}"
        _LOG.log(_level(operation, status), "%s: %s", operation, became, extra={"fields": told})

    # Read when it is asked for: the route is found while the request is under way.
    @property
    def _operation(self) -> str:
        route = self._scope.get("route")
        return NO_OPERATION if not isinstance(route, BaseRoute) else str(getattr(route, "name", NO_OPERATION))


def _level(operation: str, status: int | None) -> int:
    if status is not None and status >= _FAILED:
        return logging.WARNING
    return logging.DEBUG if operation in _OFTEN else logging.INFO
