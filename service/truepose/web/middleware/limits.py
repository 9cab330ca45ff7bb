r"""What a request may weigh and be made of, decided before anything reads it.

Half a character, `"\ud83d"` alone, is no text: JSON allows it, Python reads it, and the first that encodes
it fails. So it is refused before anything does.

A campaign of 100,000 rows is 4 MB zipped; 16 MB leaves room for torques and poses, and is stored before a
reading that comes next would notice. A program of 100,000 targets is 10 MB. All else that clients send is a
plan of some thousand stops: 8 MB.
"""

import contextlib
import json
import re
from typing import Final

from starlette.requests import Request
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.types import Message as Part

from truepose.messages.message import Message, message
from truepose.web.problems import problem_response

_SUSPECT: Final = re.compile(
    rb"\\u[dD][89a-fA-F]|\xed[\xa0-\xbf]|\x00"
)  # a zero: of UTF-16, which JSON may be


def has_half_character(body: bytes) -> bool:
    """Whether a body of JSON holds half a character; what is no JSON is told by whoever reads it."""
    if _SUSPECT.search(body) is None:
        return False
    try:
        json.dumps(json.loads(body), ensure_ascii=False).encode()
    except UnicodeEncodeError:
        return True
    except (ValueError, RecursionError):
        return False
    return False


UPLOAD_LIMIT_BYTES: Final = 16 * 2**20
DRAFT_LIMIT_BYTES: Final = 64 * 2**20  # goes to the disk as it comes
JSON_LIMIT_BYTES: Final = 8 * 2**20
_CAMPAIGNS: Final = re.compile("/api/v1/campaigns")
_PROGRAMS: Final = re.compile("/api/v1/models/[^/]+/corrections")
_DRAFTS: Final = re.compile("/api/v1/drafts/[^/]+/files")
_READING: Final = frozenset({"GET", "HEAD", "OPTIONS"})
_FORMS: Final = frozenset({"application/x-www-form-urlencoded", "multipart/form-data", "text/plain"})
_FORM: Final = "multipart/form-data"
_JSON: Final = "application/json"
_HALF: Final = message("refused.half_character", example=r"\ud83d")
_BYTES: Final = "application/octet-stream"
_UPLOADS: Final = {
    _CAMPAIGNS: ("application/zip", _FORM, _JSON),  # JSON names sessions
    _PROGRAMS: (_FORM,),
    _DRAFTS: (_BYTES,),
}


_ZERO_BYTE: Final = message("refused.zero_byte")


class _RefusedError(Exception):
    """The body is refused while it is read."""


class RequestLimits:
    """ASGI middleware: 413 for a body that is too large, 415 for a type not understood, 422 for no text."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or pass it on."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        request = Request(scope)
        limit = _limit_bytes(request)
        refusal = _refused_type(request)
        if _has_zero_byte(scope):
            await problem_response(request, 422, _ZERO_BYTE)(scope, receive, send)
        elif refusal is not None:
            await problem_response(request, 415, refusal)(scope, receive, send)
        elif _declared_length(request) > limit:
            await problem_response(request, 413, _too_large(limit))(scope, receive, send)
        else:
            await self._watched(request, receive, send, _Body(limit, sent_type(request) == _JSON))

    async def _watched(self, request: Request, receive: Receive, send: Send, body: "_Body") -> None:
        """Pass the request on and stop it where its body shows that it is refused."""

        async def look() -> Part:
            part = await receive()
            body.look_at(part)
            return part

        async def send_unless_refused(part: Part) -> None:
            # Whatever reads the body may have turned our error into an answer of its own.
            if body.refused is None:
                await send(part)

        with contextlib.suppress(_RefusedError):
            await self._app(request.scope, look, send_unless_refused)
        if body.refused is not None:
            await problem_response(request, *body.refused)(request.scope, receive, send)


class _Body:
    """A body as it comes in."""

    def __init__(self, limit: int, is_json: bool) -> None:
        self.refused: tuple[int, Message] | None = None  # status and sentence
        self._limit = limit
        self._seen_bytes = 0
        self._json = bytearray() if is_json else None

    def look_at(self, part: Part) -> None:
        """Look at a part of it; raises _RefusedError."""
        sent = part.get("body", b"")
        self._seen_bytes += len(sent)
        if self._seen_bytes > self._limit:
            self.refused = 413, _too_large(self._limit)
        elif self._json is not None and part["type"] == "http.request":
            self._json += sent
            if not part.get("more_body") and has_half_character(bytes(self._json)):
                self.refused = 422, _HALF
        if self.refused is not None:
            raise _RefusedError


def _has_zero_byte(scope: Scope) -> bool:
    # A server's database takes it for no text, wherever in a query it comes to.
    return "\0" in scope["path"] or b"%00" in scope["query_string"] or b"\0" in scope["query_string"]


def _limit_bytes(request: Request) -> int:
    if not is_upload(request):
        return JSON_LIMIT_BYTES
    return DRAFT_LIMIT_BYTES if _DRAFTS.fullmatch(request.scope["path"]) else UPLOAD_LIMIT_BYTES


def is_upload(request: Request) -> bool:
    """Return whether a request brings a file, not JSON as all others do."""
    here = _understood(request) != (_JSON,)
    return request.method == "POST" and here and sent_type(request) != _JSON


def _understood(request: Request) -> tuple[str, ...]:
    """Return the types of bodies that are understood at the path of a request."""
    path = request.scope["path"]
    return next((types for places, types in _UPLOADS.items() if places.fullmatch(path)), (_JSON,))


def sent_type(request: Request) -> str:
    """Return the type of the body that a request says it has, without its parameters."""
    return request.headers.get("content-type", "").split(";")[0].strip().lower()


def _declared_length(request: Request) -> int:
    declared = request.headers.get("content-length", "0")
    return int(declared) if declared.isdecimal() else 0


def _too_large(limit: int) -> Message:
    return message("refused.large_body", megabytes=limit // 2**20)


def _refused_type(request: Request) -> Message | None:
    sent = sent_type(request)
    has_body = _declared_length(request) > 0 or "transfer-encoding" in request.headers
    understood = _understood(request)
    # A page of anybody can send a form without asking first, an empty one too.
    if request.method in _READING or sent in understood or not (has_body or sent in _FORMS):
        return None
    if not sent:
        return message("refused.untyped_body", understood=understood)
    return message("refused.body_type", sent=sent, understood=understood)
