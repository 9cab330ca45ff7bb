"""The outermost of all: nothing reaches a route unjudged, and nothing leaves without its headers."""

from http import HTTPStatus

from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from truepose.web.door.admission import Asked, Refusal, judge
from truepose.web.door.headers import with_protection
from truepose.web.door.hosts import AllowedHosts
from truepose.web.door.proxies import Proxies
from truepose.web.problems import problem_response
from truepose.words.error_codes import code_named

_POLICY_VIOLATION = 1008  # of the WebSocket protocol


class Door:
    """ASGI middleware: refuses whom we do not know, and protects every answer."""

    def __init__(self, app: ASGIApp, hosts: AllowedHosts, proxies: Proxies) -> None:
        self._app = app
        self._hosts = hosts
        self._proxies = proxies

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or pass it on."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
        elif scope["type"] == "http":
            await self._request(scope, receive, _protecting(send))
        else:
            await send({"type": "websocket.close", "code": _POLICY_VIOLATION})

    async def _request(self, scope: Scope, receive: Receive, send: Send) -> None:
        asked = Asked(scope["method"], scope["path"], scope["headers"])
        if scope.get("client"):
            peer, port = scope["client"]
            scope["client"] = (self._proxies.who_asks(peer, asked.all(b"x-forwarded-for")), port)
        verdict = judge(asked, self._hosts)
        if isinstance(verdict, Refusal):
            # Without the headers: the address of a problem must not be made of a Host that is none.
            request = Request({**scope, "headers": []})
            code = code_named("ForeignPage") if verdict.status is HTTPStatus.FORBIDDEN else None
            headers = {"Connection": "close"}
            answer = problem_response(request, verdict.status, verdict.sentence, headers, code=code)
            await answer(scope, receive, send)
        else:
            scope["scheme"] = verdict.scheme  # in place: who watches from outside learns of the route in it
            await self._app(scope, receive, send)


def _protecting(send: Send) -> Send:
    async def protect(message: Message) -> None:
        if message["type"] == "http.response.start":
            message = {**message, "headers": with_protection(message.get("headers", ()))}
        await send(message)

    return protect
