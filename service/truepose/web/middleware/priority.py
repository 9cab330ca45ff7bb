"""Who goes first when many ask at once: what stops the robot never waits behind what only looks.

A body is received before its request takes a place, so that a slow sender holds up nobody. Uploads have a
queue of their own behind their route, and are passed on as they come.
"""

import asyncio
import contextlib
import re
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from typing import Final

from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from truepose.messages.message import message
from truepose.web.middleware.limits import is_upload
from truepose.web.problems import problem_response

_WAIT_S: Final = 5.0
_FULL: Final = message("refused.many_requests")
_AGAIN_S: Final = 2  # after which a client that found no place may ask again
_FREE_BYTES: Final = 64 * 1024  # of each body; an act or a pause is always received
_BODIES_BYTES: Final = 128 * 2**20  # of all bodies together
# What halts a session has to be among these; a test holds all patterns against the routes (decision 0022).
_URGENT: Final = re.compile(r"/health|/api/v1/sessions/[^/]+/commands")
# In the body of a command. A place that is given to another one by mistake is still a place.
_HALTS: Final = re.compile(rb'"command"\s*:\s*"(pause|stop|abort)"')
_STREAMS: Final = re.compile(r"/api/v1/events|/api/v1/sessions/[^/]+/live|/watch/[^/]+/live")
_DRAWN: Final = re.compile(
    r"/corrections/[^/]+|/reports/[^/]+/[^/]+|/sessions/[^/]+/result"
    r"|/api/v1/cells/[^/]+/plan|/api/v1/sessions/[^/]+/(promise|proof|circles|sphere|accuracy|outlook)"
)
_COLLECTED: Final = re.compile(r"/api/v1/chain/links")


class _FullError(Exception):
    """There is no place, and there has been none for a while."""


@dataclass
class _Lane:
    places: int
    queue: int
    inside: asyncio.Semaphore = field(init=False)
    waiting: int = 0

    def __post_init__(self) -> None:
        self.inside = asyncio.Semaphore(self.places)

    @contextlib.asynccontextmanager
    async def place(self) -> AsyncIterator[None]:
        """Hold a place within the context; raises _FullError."""
        if self.inside.locked():
            await self._wait()
        else:
            await self.inside.acquire()  # at once
        try:
            yield
        finally:
            self.inside.release()

    async def _wait(self) -> None:
        if self.waiting >= self.queue:
            raise _FullError
        self.waiting += 1
        try:
            # not wait_for: before Python 3.12 it drops a cancellation that comes together with the place
            async with asyncio.timeout(_WAIT_S):
                await self.inside.acquire()
        except TimeoutError as error:
            raise _FullError from error
        finally:
            self.waiting -= 1


class ConcurrencyLimits:
    """ASGI middleware: so many requests of a kind at once, a few that wait, and 503 for the others."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app
        self._halting = _Lane(16, 64)  # not behind commands that wait for a disk that does not answer
        self._urgent = _Lane(16, 64)
        self._ordinary = _Lane(16, 240)
        # Of streams about half the connections that fit into a process; of drawings what its lock allows.
        self._streams = _Lane(384, 0)
        self._drawn = _Lane(2, 30)
        self._collected = _Lane(2, 2)  # a plant that takes a page slowly keeps nobody else from anything
        self._bodies_bytes = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on when it is its turn."""
        if scope["type"] != "http" or is_upload(Request(scope)):
            await self._app(scope, receive, send)
            return
        held: list[int] = []
        try:
            first = await self._whole(receive, held)
            async with self._lane(scope["path"], first.get("body", b"")).place():
                await self._app(scope, _handing_on(first, receive), send)
        except _FullError:
            answer = problem_response(Request(scope), 503, _FULL, {"Retry-After": str(_AGAIN_S)})
            await answer(scope, receive, send)
        finally:
            self._bodies_bytes -= sum(held)

    def _lane(self, path: str, body: bytes) -> _Lane:
        if _URGENT.fullmatch(path):
            return self._halting if _HALTS.search(body[:_FREE_BYTES]) else self._urgent
        if _STREAMS.fullmatch(path):
            return self._streams
        if _COLLECTED.fullmatch(path):
            return self._collected
        return self._drawn if _DRAWN.fullmatch(path) else self._ordinary

    async def _whole(self, receive: Receive, held: list[int]) -> Message:
        """Return a request with its whole body, or that it has ended; counts in `held`; raises _FullError."""
        received = bytearray()
        more = True
        while more:
            part = await receive()
            if part["type"] != "http.request":
                return part
            received += part.get("body", b"")
            more = part.get("more_body", False)
            if len(received) > _FREE_BYTES:
                held.append(len(part.get("body", b"")))
                self._bodies_bytes += held[-1]
                if self._bodies_bytes > _BODIES_BYTES:
                    raise _FullError
        return {"type": "http.request", "body": bytes(received), "more_body": False}


def _handing_on(first: Message, receive: Receive) -> Receive:
    left = [first]

    async def hand_on() -> Message:
        return left.pop() if left else await receive()

    return hand_on
