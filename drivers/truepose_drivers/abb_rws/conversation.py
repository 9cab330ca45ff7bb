"""A session with Robot Web Services: one request at a time, logged in by digest, known again by its cookies.

Answers carry no number, but HTTP's own order: an exchange that is left before its end closes the connection.
"""

import asyncio
import contextlib
import secrets
from collections.abc import Callable
from typing import Final, TypeVar

from truepose_drivers.abb_rws import http
from truepose_drivers.abb_rws.protocol import CONTROLLER_STATE, LOGOUT, controller_state, error_sentence
from truepose_drivers.errors import ConfigurationError, ConnectionLostError, DeviceRefusedError, DriverError
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link, OverPort, introduction

# A controller ends a connection after 400 requests, in the middle of whatever.
_MOST_REQUESTS: Final = 300
_REPLY_S: Final = 1.5
_GOODBYE_S: Final = 0.3
_UNAUTHORISED: Final = 401
_BUSY: Final = 503

Value = TypeVar("Value")


class RwsSession(OverPort):
    """Asks for resources and acts on them."""

    def __init__(self, link: Link, login: http.Login) -> None:
        self._conversation = Conversation[http.HttpResponse](
            link, http.ResponseReader, harmless=(DeviceRefusedError,)
        )
        super().__init__(self._conversation)
        self._login = login
        self._forget()

    def _forget(self) -> None:
        self._challenge: http.Challenge | None = None
        self._answered = 0  # requests that answered this challenge
        self._cookies: dict[str, str] = {}
        self._requests = 0  # on this connection
        self._ends = False  # the controller said that it closes the connection

    async def open(self) -> None:
        """Connect and begin a session of its own; raises ConnectFailedError."""
        self._forget()
        await self._conversation.open()

    async def log_in(self) -> None:
        """Open, and ask a first question; raises ConnectFailedError, DeviceRefusedError."""
        await self.open()
        async with introduction(self):
            # The login goes with it, so a wrong password shows here and not under way.
            await self.get(CONTROLLER_STATE, controller_state)

    async def leave(self) -> None:
        """Log out, for sessions are few, then close the connection; never raises."""
        if self.is_open and not self._conversation.taken:
            with contextlib.suppress(DriverError, TimeoutError):
                async with asyncio.timeout(_GOODBYE_S):
                    await self.get(LOGOUT, _nothing)
        await self.close()

    async def get(self, target: str, decode: Callable[[http.HttpResponse], Value]) -> Value:
        """Return what a resource tells; raises DeviceRefusedError where there is none, LinkError.

        An answer that `decode` cannot read closes the connection.
        """
        return await self._exchange("GET", _in_json(target), b"", decode)

    async def act(self, target: str, action: str, form: dict[str, str] | None = None) -> None:
        """Do something to a resource; raises DeviceRefusedError, LinkError."""
        await self._exchange(
            "POST", _in_json(f"{target}?action={action}"), http.form_body(form or {}), _nothing
        )

    async def _exchange(
        self, method: str, target: str, body: bytes, decode: Callable[[http.HttpResponse], Value]
    ) -> Value:
        async with self._conversation.turn():
            response = await self._answer(method, target, body)
            # The first question brings the challenge, and so does one whose nonce has expired. It is asked
            # again once: a second 401 is a wrong password.
            if response.status == _UNAUTHORISED:
                self._challenge, self._answered = (
                    http.decode_challenge(response.header("www-authenticate")),
                    0,
                )
                response = await self._answer(method, target, body)
            self._require_success(response, f"{method} {target.partition('?')[0]}")
            return decode(response)

    def _require_success(self, response: http.HttpResponse, asked: str) -> None:
        if response.status == _UNAUTHORISED:
            raise DeviceRefusedError(
                f"the robot rejected user {self._login.user!r}: check the options user and password"
            )
        if not 200 <= response.status < 300:
            more = ": too many clients are connected, close some" if response.status == _BUSY else ""
            raise DeviceRefusedError(f"the robot refused {asked} ({error_sentence(response)}){more}")

    async def _answer(self, method: str, target: str, body: bytes) -> http.HttpResponse:
        """Ask once, on a connection that lasts for it."""
        await self._connect_anew_where_it_ends()
        await self._conversation.drain()
        question = self._question(method, target, body)
        silence = (
            f"the robot at {self._conversation.address} is connected but does not respond: check the network"
        )
        await self._conversation.send(question, timeout_s=_REPLY_S, silence=silence)
        response = await self._conversation.next()
        if not await self._conversation.is_quiet():
            raise http.RwsProtocolError("the robot sent more data than requested: connect again")
        self._requests += 1
        self._ends = response.ends_connection
        # A controller has 70 sessions at most; without its cookies every question would begin another one.
        self._cookies |= response.cookies
        return response

    async def _connect_anew_where_it_ends(self) -> None:
        if not self._conversation.is_open:
            raise ConnectionLostError(f"not connected to {self._conversation.address}: connect first")
        # Between two exchanges, never within one. The session lasts beyond its connection, in its cookies.
        if self._ends or self._requests >= _MOST_REQUESTS:
            await self._conversation.open()
            self._requests = 0

    def _question(self, method: str, target: str, body: bytes) -> bytes:
        headers = {}
        if self._cookies:
            headers["cookie"] = "; ".join(f"{name}={value}" for name, value in self._cookies.items())
        if self._challenge is not None:
            self._answered += 1
            headers["authorization"] = http.authorization(
                self._challenge,
                self._login,
                method,
                target,
                count=self._answered,
                client_nonce=secrets.token_hex(8),
            )
        try:
            return http.encode_request(
                http.HttpRequest(method, target, headers, body), self._conversation.address
            )
        except ValueError as error:  # h11 sends no line ends or the like in a header
            raise ConfigurationError(f"user and password cannot be sent: {error}") from error


def _in_json(target: str) -> str:
    return f"{target}{'&' if '?' in target else '?'}json=1"


def _nothing(_: http.HttpResponse) -> None:
    """Read nothing in the answer to an action, which has no body."""
