"""Authorisation: finds out who asks, and lets through what they may ask for, before anything else is read.

Whoever asks is known by the cookie of a browser that somebody signed in, or by a program's token. That what a
browser changes comes from a page of ours, `security.py` has seen to before (decision 0057).
"""

import re
from collections.abc import Sequence
from http import HTTPStatus
from typing import Any, Final
from urllib.parse import quote

from starlette.requests import Request
from starlette.responses import RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.types import Message as Part

from truepose.domain.people import Role
from truepose.messages.message import Message, message
from truepose.people.accounts import Accounts
from truepose.people.act_log import ActLog
from truepose.people.attempts import Guesses, address_block
from truepose.people.errors import FreshSignInNeededError, TooManyGuessesError
from truepose.people.register import NOBODY, Caller
from truepose.storage.people import PersonsAct
from truepose.web.middleware.rights import (
    FRESH,
    LEAST,
    OF_MACHINE,
    Anybody,
    RequestRecord,
    begin_request,
    may,
    may_ask,
)
from truepose.web.middleware.routing import Operation, RouteTable, requested_operation
from truepose.web.problems import FRESH_SIGN_IN, SIGN_IN, problem_response

COOKIE: Final = "truepose_sign_in"
SECURE_COOKIE: Final = f"__Host-{COOKIE}"  # browsers take it over TLS only, for this host and all paths
_CONTROLS: Final = re.compile(r"[\x00-\x1f\x7f]")
_LONGEST_REASON: Final = 2000
_BEARER: Final = re.compile(r"bearer +([A-Za-z0-9_-]{43})", re.ASCII | re.IGNORECASE)
_SECRET: Final = re.compile(r"[A-Za-z0-9_-]{43}", re.ASCII)
_READING: Final = frozenset({"GET", "HEAD", "OPTIONS"})
_REFUSED: Final = frozenset({HTTPStatus.UNAUTHORIZED, HTTPStatus.FORBIDDEN, HTTPStatus.TOO_MANY_REQUESTS})
_SIGN_IN_FIRST: Final = message("refused.sign_in_first")


def cookie_name(scope: Scope) -> str:
    """Return the name of the cookie that a sign-in has where a request came from."""
    return SECURE_COOKIE if scope["scheme"] == "https" else COOKIE


class AuthorizationMiddleware:
    """ASGI middleware: nobody asks for what is not theirs, and what they changed is on record."""

    def __init__(self, app: ASGIApp, operations: Sequence[Operation]) -> None:
        self._app = app
        self._operations = RouteTable((operation.path, operation) for operation in operations)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer it."""
        here = getattr(scope["app"].state, "context", None)
        if scope["type"] != "http" or here is None:  # without a context there is nothing to ask for
            await self._app(scope, receive, send)
            return
        operation = requested_operation(self._operations, scope["method"], scope["path"])
        client = scope.get("client")
        asked = RequestRecord(_caller(scope, here.people.accounts), client[0] if client else "")
        begin_request(asked)
        watch = _Watch(here.people.accounts, asked.caller, send)
        refusal = _refusal(scope, operation, asked.caller, here.people.accounts)
        try:
            await (refusal or self._app)(scope, receive, watch.send)
        except _NoLongerAllowedError:
            pass
        finally:
            # While nobody is asked who they are nothing is added (decision 0057); `about` names the first
            # person, whose own request closes the service.
            if not here.people.accounts.are_open or asked.about is not None:
                _record(scope, operation, asked, watch.status, here)


class _NoLongerAllowedError(Exception):
    """Somebody is sent something over hours, and may not have it any more."""


class _Watch:
    """Sees what is answered, and ends a stream whose reader may no longer have it."""

    def __init__(self, accounts: Accounts, caller: Caller, send: Send) -> None:
        self._accounts = accounts
        self._caller = caller
        self._send = send
        self.status = int(HTTPStatus.INTERNAL_SERVER_ERROR)

    async def send(self, part: Part) -> None:
        if part["type"] == "http.response.start":
            self.status = part["status"]
        elif part.get("more_body") and not self._lasts():
            await self._send({"type": "http.response.body", "body": b"", "more_body": False})
            raise _NoLongerAllowedError
        await self._send(part)

    def _lasts(self) -> bool:
        return self._caller is NOBODY or self._accounts.lasts(self._caller)


def _caller(scope: Scope, accounts: Accounts) -> Caller:
    cookies = _cookies(scope)
    told = [value for name, value in scope["headers"] if name == b"authorization"]
    if accounts.are_open:
        return accounts.caller_of(None, _bearer(told[0]) if len(told) == 1 else None)
    # Twice, or cookie and token at once, is nobody (decision 0057).
    if len(cookies) > 1 or len(told) > 1:
        return NOBODY
    cookie = next(iter(cookies), None)
    if not told:
        return accounts.caller_of(cookie, None) if cookie is None or _SECRET.fullmatch(cookie) else NOBODY
    bearer = _bearer(told[0])
    return NOBODY if bearer is None else accounts.caller_of(cookie, bearer)


def _bearer(told: bytes) -> str | None:
    found = _BEARER.fullmatch(told.decode("latin-1").strip())
    return None if found is None else found[1]


def _cookies(scope: Scope) -> list[str]:
    """Return the values of every cookie of ours; two of them are one too many."""
    wanted = cookie_name(scope)
    sent = [value.decode("latin-1") for name, value in scope["headers"] if name == b"cookie"]
    pairs = [pair.strip().partition("=") for line in sent for pair in line.split(";")]
    return [value for name, _, value in pairs if name == wanted]


def _refusal(
    scope: Scope, operation: Operation | None, caller: Caller, accounts: Accounts
) -> Response | None:
    name = None if operation is None else operation.name
    if caller.everybody or (name is not None and isinstance(LEAST[name], Anybody)):
        return None
    request = Request(scope)
    if caller.role is None:
        if _shows_page(scope, operation):
            return RedirectResponse(_sign_in_address(request), HTTPStatus.SEE_OTHER)
        headers = {"WWW-Authenticate": "Bearer"}
        return problem_response(request, HTTPStatus.UNAUTHORIZED, _SIGN_IN_FIRST, headers, kind=SIGN_IN)
    if not may_ask(caller, name) or (caller.machine and name not in OF_MACHINE):
        if _shows_page(scope, operation):
            return RedirectResponse(f"/not-yours?page={quote(scope['path'])}", HTTPStatus.SEE_OTHER)
        return problem_response(request, HTTPStatus.FORBIDDEN, _not_for(caller, name))
    if name in FRESH and caller.sign_in is not None and not accounts.sign_ins.is_fresh(caller):
        sentence = FreshSignInNeededError().text
        return problem_response(request, HTTPStatus.FORBIDDEN, sentence, kind=FRESH_SIGN_IN)
    return None


def _shows_page(scope: Scope, operation: Operation | None) -> bool:
    return operation is not None and operation.is_page and scope["method"] == "GET"


def _sign_in_address(request: Request) -> str:
    wanted = request.url.path + (f"?{request.url.query}" if request.url.query else "")
    return f"/sign-in?next={quote(wanted)}"


def _not_for(caller: Caller, operation: str | None) -> Message:
    least = str(Role.VIEWER if operation is None else LEAST[operation])
    owner = caller.person
    if owner is not None and caller.role is not None and may(caller.role, operation):
        return message(
            "refused.low_owner", name=caller.name, person=owner.name, role=str(owner.role), least=least
        )
    return message("refused.low_role", name=caller.name, role=str(caller.role), least=least)


def _record(scope: Scope, operation: Operation | None, asked: RequestRecord, status: int, here: Any) -> None:
    """Put on record what changed something or was refused, and who signed in."""
    refused = status in _REFUSED
    if (scope["method"] in _READING or asked.renews) and not refused:
        return
    if refused and not _is_told(here.people.refusals, asked):
        return
    log: ActLog = here.people.log
    log.note(
        PersonsAct(
            here.people.accounts.register.time.now().isoformat(timespec="milliseconds"),
            _name(scope, operation, asked),
            _resource(scope, operation),
            status,
            asked.caller.name or asked.about,
            None if asked.caller.role is None else asked.caller.role.value,
            "token" if asked.caller.token else "sign_in" if asked.caller.sign_in else None,
            asked.caller.tablet_name or None,
            asked.address or None,
            asked.reason and _as_kept(asked.reason),
        )
    )


def _name(scope: Scope, operation: Operation | None, asked: RequestRecord) -> str:
    """Return what a request is called on record: of a session's commands, each by its own name."""
    if operation is None:
        return f"{scope['method']} nothing"
    return operation.name if asked.command is None else f"{asked.command}_session"


def _is_told(refusals: Guesses, asked: RequestRecord) -> bool:
    """Whether a refusal is put on record: the first ones of an address; a flood of them is one event."""
    try:
        refusals.take(address_block(asked.address))
    except TooManyGuessesError:
        return False
    return True


def _resource(scope: Scope, operation: Operation | None) -> str:
    """Return where something was asked for, without a secret that stands in the path."""
    if operation is None:
        return "/"
    return operation.path if "{secret}" in operation.path else _as_kept(str(scope["path"]))[:200]


def _as_kept(text: str) -> str:
    """Return what somebody sent as it is put on record, whether it was refused or not."""
    # PostgreSQL keeps no zero byte, and a refused body may state a reason of megabytes.
    return _CONTROLS.sub(" ", text[:_LONGEST_REASON])
