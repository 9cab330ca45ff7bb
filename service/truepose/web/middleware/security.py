"""Whether a request may come in, by its host and the page it comes from; headers that protect answers.

A browser tells from which page a request comes (Origin, Sec-Fetch-*, Referer); scripts and spreadsheets tell
nothing of that kind and go on as they always did. What is told must be one of our own pages, on every route
and for every method: also reading is not for pages of others.
"""

import asyncio
import contextlib
import re
from collections.abc import Iterable
from dataclasses import dataclass
from http import HTTPStatus
from typing import Final, TypeAlias

from starlette.requests import Request
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.types import Message as Part

from truepose.messages.error_codes import code_named
from truepose.messages.message import Message, message
from truepose.web.middleware.hosts import AllowedHosts, AskedHost, Proxies, requested_host
from truepose.web.problems import problem_response
from truepose.web.schemas import TIME_HEADER, time_s

# Where a link on somebody else's page may lead; whatever is not here can only be asked by our own pages.
# A new page is added here; tests walk all routes (decision 0022).
PAGES: Final = re.compile(
    r"/|/docs|/work|/hand-downs|/operator(/[^/]+)?|/diagnoses(/[^/]+)?|/corrections(/[^/]+)?|/plan(/checklist)?|/faults|/errors(/[^/]+)?"
    r"|/(?:jobs|campaigns|identifications|validations|models)/[^/]+|/(?:robots|instruments|cells)/.+"
    r"|/(?:identifications|validations|diagnoses)/[^/]+/readings|/readings|/campaigns|/robots|/instruments"
    r"|/sessions(/[^/]+(/result|/closing|/checklist|/again)?)?|/reports(/[^/]+/[^/.]+)?"
    r"|/fleet|/bring(/[^/]+)?|/sign-in|/first-person/[^/]+|/welcome/[^/]+|/account|/not-yours|/people|/audit|/watch/[^/]+"
)
_READING: Final = frozenset({"GET", "HEAD", "OPTIONS"})
_FRAMES: Final = frozenset({"iframe", "frame", "fencedframe", "embed", "object", "portal"})
_OURS: Final = frozenset({"same-origin", "none"})  # none: typed in, or from the bookmarks
_ANOTHER_PAGE: Final = message("refused.another_page")
_LONGEST: Final = 100  # letters of what somebody sent, in a sentence
# A connection that is closed on bytes that nobody read is reset, and the reset overtakes the answer (RFC
# 9112, section 9.6): what still comes behind a refused request is taken in, for so long and so much.
LINGER_S: Final = 1.0
MOST_TAKEN_IN: Final = 65_536  # bytes; whoever sends more may find the connection reset


@dataclass(frozen=True, slots=True)
class Refusal:
    """The request may not come in."""

    status: HTTPStatus
    sentence: Message


def judge(asked: Request, hosts: AllowedHosts) -> str | Refusal:
    """Return the scheme under which browsers know the service, or why a request may not come in."""
    if not asked.scope["path"].startswith("/"):
        return Refusal(HTTPStatus.BAD_REQUEST, message("refused.target"))
    host = _host(asked, hosts)
    if isinstance(host, Refusal):
        return host
    refused = _upgrade(asked) or _foreign_origin(asked, hosts, host) or _foreign_fetch(asked)
    return refused or _unproven_change(asked, hosts, host) or hosts.scheme(host) or "http"


def _all(asked: Request, name: str) -> list[str]:
    """Return every header of that name."""
    return [value.strip() for value in asked.headers.getlist(name)]


def _host(asked: Request, hosts: AllowedHosts) -> AskedHost | Refusal:
    sent = _all(asked, "host")
    host = requested_host(sent[0]) if len(sent) == 1 else None
    if host is None:
        return Refusal(HTTPStatus.BAD_REQUEST, message("refused.no_host"))
    if hosts.scheme(host) is None:
        sentence = message("refused.foreign_host", host=_shown(host.name))
        return Refusal(HTTPStatus.MISDIRECTED_REQUEST, sentence)
    return host


def _upgrade(asked: Request) -> Refusal | None:
    wanted = {token.strip().lower() for value in _all(asked, "upgrade") for token in value.split(",")}
    if "websocket" not in wanted:
        return None
    return Refusal(HTTPStatus.BAD_REQUEST, message("refused.web_sockets"))


def _foreign_origin(asked: Request, hosts: AllowedHosts, host: AskedHost) -> Refusal | None:
    foreign = [origin for origin in _all(asked, "origin") if not hosts.is_origin(origin, host)]
    return _foreign(message("refused.page_of", origin=_shown(foreign[0]))) if foreign else None


def _foreign_fetch(asked: Request) -> Refusal | None:
    if _FRAMES.intersection(_all(asked, "sec-fetch-dest")):
        return Refusal(HTTPStatus.FORBIDDEN, message("refused.frame"))
    sites = _all(asked, "sec-fetch-site")
    if _OURS.issuperset(sites) and (asked.method in _READING or "none" not in sites):
        return None
    return None if _is_link_to_page(asked) else _foreign(_ANOTHER_PAGE)


def _is_link_to_page(asked: Request) -> bool:
    return (
        asked.method == "GET"
        and _all(asked, "sec-fetch-mode") == ["navigate"]
        and _all(asked, "sec-fetch-dest") == ["document"]
        and PAGES.fullmatch(asked.scope["path"]) is not None
    )


def _unproven_change(asked: Request, hosts: AllowedHosts, host: AskedHost) -> Refusal | None:
    """Return a refusal of what would change something, comes from a browser, and does not say from where."""
    if asked.method in _READING or _all(asked, "origin") or _all(asked, "sec-fetch-site"):
        return None
    referers = _all(asked, "referer")
    if any(not hosts.is_origin(_origin_of(referer), host) for referer in referers):
        return _foreign(_ANOTHER_PAGE)
    told = any(name == "cookie" or name.startswith("sec-fetch-") for name in asked.headers)
    return _foreign(message("refused.unsaid_page")) if told and not referers else None


def _origin_of(address: str) -> str:
    scheme, _, rest = address.partition("://")
    return f"{scheme}://{re.split('[/?#]', rest, maxsplit=1)[0]}"


def _foreign(whence: Message) -> Refusal:
    return Refusal(HTTPStatus.FORBIDDEN, message("refused.foreign_page", whence=whence))


def _shown(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


RawHeaders: TypeAlias = list[tuple[bytes, bytes]]

_NOTHING: Final = b"default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
_PAGE: Final = (
    b"default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    b"base-uri 'none'; form-action 'self'; frame-ancestors 'none'"
)
_ALWAYS: Final[RawHeaders] = [
    (b"x-content-type-options", b"nosniff"),
    (b"x-frame-options", b"DENY"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
    # A tablet stays awake while somebody measures; of its other senses the pages need none.
    (
        b"permissions-policy",
        b"screen-wake-lock=(self), fullscreen=(self), camera=(), microphone=(), geolocation=(), "
        b"display-capture=(), payment=(), usb=(), serial=(), hid=(), midi=()",
    ),
]
_POLICY: Final = b"content-security-policy"
_CACHE: Final = b"cache-control"


def with_protection(headers: Iterable[tuple[bytes, bytes]]) -> RawHeaders:
    """Return the headers of an answer with those that every answer has.

    What an answer says of its keeping stands; else it is kept nowhere, as it is old a moment later.
    """
    given = [(name.lower(), value) for name, value in headers]
    named = dict(given)
    fixed = dict(_ALWAYS)
    fixed[_POLICY] = _PAGE if named.get(b"content-type", b"").startswith(b"text/html") else _NOTHING
    kept = [(name, value) for name, value in given if name not in fixed]
    missing = [] if _CACHE in named else [(_CACHE, b"no-store")]
    return [*kept, *fixed.items(), *missing, (TIME_HEADER, b"%.3f" % time_s())]


_POLICY_VIOLATION = 1008  # of the WebSocket protocol


class SecurityMiddleware:
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
        asked = Request(scope)
        if scope.get("client"):
            peer, port = scope["client"]
            scope["client"] = (self._proxies.who_asks(peer, _all(asked, "x-forwarded-for")), port)
        verdict = judge(asked, self._hosts)
        if isinstance(verdict, Refusal):
            # Without the headers: the address of a problem must not be made of a Host that is none.
            request = Request({**scope, "headers": []})
            code = code_named("ForeignPage") if verdict.status is HTTPStatus.FORBIDDEN else None
            headers = {"Connection": "close"}
            answer = problem_response(request, verdict.status, verdict.sentence, headers, code=code)
            await answer(scope, receive, _closing(receive, send))
        else:
            scope["scheme"] = verdict  # in place: who watches from outside learns of the route in it
            await self._app(scope, receive, send)


def _closing(receive: Receive, send: Send) -> Send:
    """Return what sends an answer and then takes in what is still on its way, before the connection ends."""

    async def close(part: Part) -> None:
        if part["type"] != "http.response.body" or part.get("more_body"):
            await send(part)
            return
        await send({**part, "more_body": True})
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(LINGER_S):
                await _take_in(receive)
        await send({"type": "http.response.body", "body": b""})

    return close


async def _take_in(receive: Receive) -> None:
    taken, part = 0, await receive()
    while part["type"] == "http.request" and part.get("more_body") and taken < MOST_TAKEN_IN:
        taken += len(part["body"])
        part = await receive()


def _protecting(send: Send) -> Send:
    async def protect(part: Part) -> None:
        if part["type"] == "http.response.start":
            part = {**part, "headers": with_protection(part.get("headers", ()))}
        await send(part)

    return protect
