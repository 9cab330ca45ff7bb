"""One connection: HTTP as the server speaks it, with an eye on how long everything takes."""

import asyncio
import json
from http import HTTPStatus
from typing import Any, Final

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.server import ServerState

from truepose.app.connections import Census, Pace
from truepose.web.middleware.security import LINGER_S, MOST_TAKEN_IN, with_protection

_MALFORMED: Final = {
    "type": "urn:truepose:problem:bad-request",
    "title": HTTPStatus.BAD_REQUEST.phrase,
    "status": HTTPStatus.BAD_REQUEST.value,
    "detail": "This is not an HTTP request.",
    "instance": "/",
}


class WatchedProtocol(H11Protocol):
    """Tells the census what it waits for, and since when."""

    def __init__(
        self,
        census: Census,
        *,
        config: uvicorn.Config,
        server_state: ServerState,
        app_state: dict[str, Any],
        _loop: asyncio.AbstractEventLoop | None = None,
    ) -> None:
        super().__init__(config, server_state, app_state, _loop)
        self._census = census
        limits = census.limits
        self._head_since_s = self.loop.time()
        self._is_idle = False  # since an answer; it is the server's keep-alive that ends it
        self._refused_bytes: int | None = None  # behind a malformed request; None while there is none
        self._body = Pace(limits.body_bytes_per_s, limits.body_grace_s)
        self._answer = Pace(limits.answer_bytes_per_s, limits.answer_grace_s)

    @property
    def peer(self) -> str:
        """Address of the other side."""
        return self.client[0] if self.client else ""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take the connection up."""
        super().connection_made(transport)
        self._head_since_s = self.loop.time()
        self._census.admit(self)

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget the connection."""
        super().connection_lost(exc)
        self._census.leave(self)

    def data_received(self, data: bytes) -> None:
        """Read on, and note how far a body has come; what follows a refused request is dropped."""
        if self._refused_bytes is not None:
            self._refused_bytes += len(data)
            if self._refused_bytes > MOST_TAKEN_IN:
                self.transport.close()
            return
        if self._is_idle:
            self._is_idle, self._head_since_s = False, self.loop.time()
        was_body = self.conn.their_state is h11.SEND_BODY
        super().data_received(data)
        if self.conn.their_state is h11.SEND_BODY:
            if was_body:
                self._body.move(len(data))
            else:
                self._body.begin(self.loop.time())

    def on_response_complete(self) -> None:
        """Wait for the next request from now on."""
        self._head_since_s = self.loop.time()
        self._is_idle = not self.conn.trailing_data[0]  # else the next request is here in part
        super().on_response_complete()

    def incomplete_since(self) -> float | None:
        """Since when a request is waited for [s]; None while one is under way.

        A body that comes as fast as it should, or that we do not read at present, is under way.
        """
        if self.conn.their_state is h11.IDLE:
            return self._head_since_s
        if self.conn.their_state is not h11.SEND_BODY or self.flow.read_paused:
            return None
        return self._body.since_s if self._body.is_behind(self.loop.time()) else None

    def too_slow(self, now_s: float) -> str | None:
        """Say why the connection has to be closed; None where it has not."""
        limits = self._census.limits
        if self._unread(now_s):
            return "did not read their response"
        if self.transport.is_closing():
            return None
        if self.conn.their_state is h11.IDLE:
            late = not self._is_idle and now_s - self._head_since_s > limits.head_s
            return "sent no complete request in time" if late else None
        if self.conn.their_state is h11.SEND_BODY:
            if self.flow.read_paused:  # it is we who do not read
                self._body.begin(now_s)
            late = self._body.too_slow(now_s) or self._body.lasted(now_s) > limits.body_s
            return "sent the request body too slowly" if late else None
        return None

    def cut(self) -> None:
        """Close at once."""
        self.transport.abort()

    def send_400_response(self, msg: str) -> None:
        """Answer what is no HTTP with a problem document; where an answer is on its way already, end it."""
        if self.cycle is not None:
            self.cycle.disconnected = True
            self.cycle.message_event.set()
        if self.conn.our_state not in {h11.IDLE, h11.SEND_RESPONSE}:
            self.transport.abort()
            return
        body = json.dumps(_MALFORMED).encode()
        told = [(b"content-type", b"application/problem+json"), (b"connection", b"close")]
        head = h11.Response(
            status_code=HTTPStatus.BAD_REQUEST,
            headers=with_protection([*told, (b"content-length", str(len(body)).encode())]),
            reason=HTTPStatus.BAD_REQUEST.phrase.encode(),
        )
        for event in (head, h11.Data(data=body), h11.EndOfMessage()):
            self.transport.write(self.conn.send(event) or b"")
        self._close_gently()

    def _close_gently(self) -> None:
        """Say that nothing more follows, and close once the other side has had time to read it."""
        self._refused_bytes = 0
        if self.transport.can_write_eof():  # TLS cannot
            self.transport.write_eof()
        self.loop.call_later(LINGER_S, self.transport.close)

    def _unread(self, now_s: float) -> bool:
        """Return whether what was written lies here because the other side does not take it."""
        unsent = self.transport.get_write_buffer_size()
        # All was taken, or more was written since: what lies here now is counted from this moment on.
        if unsent == 0 or unsent > self._answer.amount:
            self._answer.begin(now_s, unsent)
        return self._answer.amount > 0 and self._answer.too_slow(now_s, self._answer.amount - unsent)

    def resume_writing(self) -> None:
        """Go on writing, as the other side reads."""
        self._answer.begin(self.loop.time())
        super().resume_writing()
