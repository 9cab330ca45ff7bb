"""Errors as problem documents (RFC 9457), or as a page where somebody looks by a browser."""

from collections.abc import Mapping, Sequence
from http import HTTPStatus
from typing import Any, Final

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import HTMLResponse, JSONResponse, Response
from pydantic import BaseModel, Field
from starlette.exceptions import HTTPException
from starlette.requests import ClientDisconnect
from starlette.routing import Match

from truepose.analysis.errors import (
    BusyError,
    NeverDiagnosedError,
    NothingMeasuredError,
    NotReadyError,
    RobotsMixedError,
    RoleError,
    SessionsDifferError,
)
from truepose.domain.errors import RecordRefusedError, TrueposeError, UnsuitableModelError, text_of
from truepose.domain.people import NAME_PATTERN
from truepose.exchange.errors import InputFileError, UnknownRobotError
from truepose.messages.error_codes import code_named, code_of, explain
from truepose.messages.message import Text, message
from truepose.people.errors import (
    AccountRefusedError,
    FreshSignInNeededError,
    NotAllowedError,
    SignInRefusedError,
    SomebodyElseActsError,
    TooManyGuessesError,
    UnknownPersonError,
)
from truepose.planning.errors import WorkSpaceError
from truepose.sessions.errors import (
    CellChangedError,
    CertificateError,
    DeviceInUseError,
    MissingDeviceError,
    NoBallbarError,
    NotNowError,
    PersonMissingError,
    PersonUnknownError,
    PersonUnreadableError,
    PlanRefusedError,
    RealCellError,
    UnknownDeviceError,
    WatchingTabletError,
)
from truepose.storage.errors import ConflictError, NotFoundError, StorageUnavailableError
from truepose.web.middleware.language import in_words, reader_words
from truepose.web.pages.rendering import MissingPageError, visit_of
from truepose.web.schemas import ANOTHER_PERSON, KEY, VISIBLE
from truepose_drivers.errors import DeviceRefusedError, DriverError

_HTML = "text/html"
_API = "/api/"


def wants_a_page(request: Request) -> bool:
    """Whether somebody looks by a browser, and not at what is for programs."""
    return _HTML in request.headers.get("accept", "") and not request.url.path.startswith(_API)


def refused_page(request: Request, status: HTTPStatus, sentence: Text, code: str) -> HTMLResponse:
    """Return the page of a code with the sentence of what happened here."""
    visit = visit_of(request, request.app.state.context)
    return visit.page(
        "errors/error.html", status, told=explain(code, visit.words), sentence=visit.words.spoken(sentence)
    )


_IN_WORDS: Final[Mapping[object, Text]] = {  # of patterns
    VISIBLE: message("refused.unseen"),
    NAME_PATTERN: message("refused.name_signs"),
    KEY: message("refused.key_signs"),
}
FRESH_SIGN_IN: Final = "fresh-sign-in"  # that is solved by showing once more who it is
SIGN_IN: Final = "sign-in"  # that is solved by signing in
_NAME: Final = "name"  # the kind of problem that another person's name solves
_KINDS: Final[Mapping[type[Exception], str]] = {  # of problems that somebody can solve at once
    PersonMissingError: _NAME,
    PersonUnknownError: _NAME,
    PersonUnreadableError: _NAME,
    FreshSignInNeededError: FRESH_SIGN_IN,
    SomebodyElseActsError: "authority",
}
MEDIA_TYPE: Final = "application/problem+json"
UNKNOWN_PARAMETER: Final = "unknown_parameter"  # the type of the fault
_OF_FAULT: Final = {UNKNOWN_PARAMETER: "UnknownParameter", "json_invalid": "UnreadableRequest"}
_METHODS: Final = ("DELETE", "GET", "PATCH", "POST", "PUT")

# The first class that fits counts, so a subclass stands before its base.
_STATUS: Mapping[type[Exception], HTTPStatus] = {
    NotFoundError: HTTPStatus.NOT_FOUND,
    UnknownDeviceError: HTTPStatus.NOT_FOUND,
    UnknownRobotError: HTTPStatus.NOT_FOUND,
    NeverDiagnosedError: HTTPStatus.NOT_FOUND,
    ConflictError: HTTPStatus.CONFLICT,
    NotNowError: HTTPStatus.CONFLICT,
    WatchingTabletError: HTTPStatus.CONFLICT,
    DeviceInUseError: HTTPStatus.CONFLICT,
    MissingDeviceError: HTTPStatus.CONFLICT,
    CellChangedError: HTTPStatus.CONFLICT,
    NoBallbarError: HTTPStatus.CONFLICT,
    RealCellError: HTTPStatus.CONFLICT,
    CertificateError: HTTPStatus.CONFLICT,
    NothingMeasuredError: HTTPStatus.CONFLICT,
    NotReadyError: HTTPStatus.CONFLICT,
    SessionsDifferError: HTTPStatus.CONFLICT,
    RoleError: HTTPStatus.CONFLICT,
    RobotsMixedError: HTTPStatus.CONFLICT,
    WorkSpaceError: HTTPStatus.CONFLICT,
    UnsuitableModelError: HTTPStatus.CONFLICT,  # the request is sound, this model cannot
    PlanRefusedError: HTTPStatus.CONFLICT,  # the request is sound, this cell cannot do it
    DeviceRefusedError: HTTPStatus.CONFLICT,
    PersonUnreadableError: HTTPStatus.CONFLICT,  # what a schema cannot say; the rest of it is refused there
    PersonUnknownError: HTTPStatus.CONFLICT,
    PersonMissingError: HTTPStatus.UNPROCESSABLE_ENTITY,
    InputFileError: HTTPStatus.UNPROCESSABLE_ENTITY,
    SignInRefusedError: HTTPStatus.UNAUTHORIZED,
    FreshSignInNeededError: HTTPStatus.FORBIDDEN,
    NotAllowedError: HTTPStatus.FORBIDDEN,
    TooManyGuessesError: HTTPStatus.TOO_MANY_REQUESTS,
    UnknownPersonError: HTTPStatus.NOT_FOUND,
    AccountRefusedError: HTTPStatus.CONFLICT,
    SomebodyElseActsError: HTTPStatus.CONFLICT,
    StorageUnavailableError: HTTPStatus.SERVICE_UNAVAILABLE,
    RecordRefusedError: HTTPStatus.SERVICE_UNAVAILABLE,
    BusyError: HTTPStatus.SERVICE_UNAVAILABLE,
    DriverError: HTTPStatus.SERVICE_UNAVAILABLE,
    TrueposeError: HTTPStatus.UNPROCESSABLE_ENTITY,
}


# Python 3.13 words these otherwise, and the type of a problem follows its title: programs rely on one.
_TITLES: Mapping[int, str] = {413: "Request Entity Too Large", 422: "Unprocessable Entity"}
_OF_STATUS: Mapping[int, str] = {  # what has a status and no exception of its own
    400: "UnreadableRequest",
    401: "NotSignedIn",
    403: "NotAllowedError",
    404: "NoSuchPath",
    405: "MethodNotPossible",
    408: "BodyLate",
    409: "ConflictError",
    413: "TooLarge",
    415: "TypeNotUnderstood",
    421: "ForeignHost",
    422: "InvalidRequest",
    429: "TooMany",
    500: "ProgramFailed",
    503: "TooMany",
}


class Problem(BaseModel):
    """What went wrong, where, and what to do about it."""

    type: str = Field(
        description="Kind of problem; for `urn:truepose:problem:name`, send a different name.",
        examples=["urn:truepose:problem:not-found"],
    )
    title: str = Field(description="Reason phrase of the HTTP status.", examples=["Not Found"])
    status: int = Field(description="HTTP status code.", examples=[404])
    detail: str = Field(description="Explanation in one sentence.", examples=["There is no session 7."])
    instance: str = Field(description="Path of the request.", examples=["/api/v1/sessions/7"])
    code: str = Field(
        description="Error code to quote in support requests; the same in every language.",
        examples=["TP-1020"],
    )
    meaning: str = Field(description="Consequence for the data.", examples=["Nothing was stored or changed."])
    action: str = Field(
        description="What to do next.", examples=["Look up the number in the list of records."]
    )
    code_url: str = Field(description="Page that explains the error code.", examples=["/errors/TP-1020"])


def problem_response(
    request: Request,
    status: int,
    detail: Text,
    headers: Mapping[str, str] | None = None,
    kind: str | None = None,
    code: str | None = None,
) -> JSONResponse:
    """Return a problem document; its kind and code are those of the status unless others are given."""
    title, code = _title(status), code or code_named(_OF_STATUS[status])
    told = explain(code, reader_words())
    body = Problem(
        type=f"urn:truepose:problem:{kind or title.lower().replace(' ', '-')}",
        title=title,
        status=status,
        detail=in_words(detail),
        instance=request.url.path,
        code=code,
        meaning=told.data,
        action=told.do,
        code_url=f"/errors/{code}",
    )
    return JSONResponse(body.model_dump(), status, headers, media_type=MEDIA_TYPE)


def _title(status: int) -> str:
    return _TITLES.get(status) or HTTPStatus(status).phrase


def status_of(error: Exception) -> HTTPStatus:
    """Return the status that an error leaves with."""
    return next(status for kind, status in _STATUS.items() if isinstance(error, kind))


def install(app: FastAPI) -> None:
    """Let every error of `app` leave as a problem document."""
    app.add_exception_handler(RequestValidationError, _on_invalid)
    app.add_exception_handler(HTTPException, _on_http)
    app.add_exception_handler(TrueposeError, _on_refusal)
    app.add_exception_handler(DriverError, _on_refusal)
    app.add_exception_handler(MissingPageError, _on_missing_page)
    app.add_exception_handler(Exception, _on_failure)
    app.add_exception_handler(ClientDisconnect, _on_nobody)


async def _on_refusal(request: Request, error: Exception) -> Response:
    status = status_of(error)
    if wants_a_page(request):
        return refused_page(request, status, text_of(error), code_of(error))
    headers = None
    if isinstance(error, BusyError | TooManyGuessesError):
        headers = {"Retry-After": str(error.retry_after_s)}
    kind = next((kind for of, kind in _KINDS.items() if isinstance(error, of)), None)
    return problem_response(request, status, text_of(error), headers, kind, code_of(error))


async def _on_missing_page(request: Request, error: Exception) -> HTMLResponse:
    visit = visit_of(request, request.app.state.context)
    return visit.page("errors/missing.html", HTTPStatus.NOT_FOUND)


async def _on_nobody(request: Request, error: Exception) -> JSONResponse:
    # Nobody reads it, and the log is for what went wrong here.
    return problem_response(request, HTTPStatus.REQUEST_TIMEOUT, message("refused.connection_ended"))


async def _on_failure(request: Request, error: Exception) -> JSONResponse:
    """Answer for a fault of the program; its traceback goes to the log, not to whoever asked."""
    told = message("refused.failed", fault=type(error).__name__)
    return problem_response(request, HTTPStatus.INTERNAL_SERVER_ERROR, told)


async def _on_http(request: Request, error: Exception) -> JSONResponse:
    if not isinstance(error, HTTPException):
        raise error
    detail: Text = str(error.detail)
    headers = dict(error.headers or {})
    if error.status_code == HTTPStatus.BAD_REQUEST:  # the framework's word for bytes that are no text
        detail = message("refused.unreadable_body")
    if error.status_code == HTTPStatus.NOT_FOUND:
        detail = message("refused.no_path", path=request.url.path)
    if error.status_code == HTTPStatus.METHOD_NOT_ALLOWED:
        headers["Allow"] = ", ".join(_allowed_methods(request))
        said = {"method": request.method, "path": request.url.path, "allowed": headers["Allow"]}
        detail = message("refused.method", **said)
    return problem_response(request, error.status_code, detail, headers)


def _allowed_methods(request: Request) -> list[str]:
    """Return the methods of every route at this path; the framework names those of the first one only."""
    return [
        method
        for method in _METHODS
        if any(
            route.matches({**request.scope, "method": method})[0] is Match.FULL
            for route in request.app.routes
        )
    ]


async def _on_invalid(request: Request, error: Exception) -> JSONResponse:
    if not isinstance(error, RequestValidationError):
        raise error
    faults = error.errors()
    kind = _NAME if "person" in faults[0]["loc"][-1:] else None
    if faults[0]["type"] == ANOTHER_PERSON:
        code = code_named("NotAllowedError")
        sentence = message("refused.another_person", **faults[0]["ctx"])
        return problem_response(request, HTTPStatus.FORBIDDEN, sentence, kind=_NAME, code=code)
    code = code_named(_OF_FAULT.get(faults[0]["type"], "InvalidRequest"))
    said = _sentence(faults, error.body)
    return problem_response(request, HTTPStatus.UNPROCESSABLE_ENTITY, said, kind=kind, code=code)


def _sentence(faults: Any, body: Any) -> Text:
    """Return one sentence on the first fault: where, what, and how many more there are."""
    first = faults[0]
    if first["type"] == "json_invalid":
        return message("refused.not_json", fault=first["ctx"]["error"], at=first["loc"][-1])
    where = _place(first["loc"], body) or message("refused.body")
    what = _IN_WORDS.get(first.get("ctx", {}).get("pattern")) or _lowered(first["msg"])
    if len(faults) == 1:
        return message("refused.fault", where=where, what=what)
    return message("refused.faults", where=where, what=what, more=len(faults) - 1)


def _place(loc: Sequence[str | int], body: Any) -> str:
    """Return where in a body a fault is; without what tells the forms of a body apart, which nobody sent."""
    if loc[0] != "body":
        return ".".join(map(str, loc))
    if body is None:  # read by a route itself
        return ".".join(map(str, loc[1:]))
    found: list[str] = []
    for n, part in enumerate(loc[1:], start=2):
        is_there = _has(body, part)
        is_missing = n == len(loc) and isinstance(body, dict)
        if is_there or is_missing:
            found.append(str(part))
        body = body[part] if is_there else body
    return ".".join(found)


def _has(body: Any, part: str | int) -> bool:
    if isinstance(body, list):
        return isinstance(part, int) and part < len(body)
    return isinstance(body, dict) and part in body


def _lowered(text: Text) -> Text:
    """Return a sentence of the framework's as the end of one of ours."""
    return text[:1].lower() + text[1:].rstrip(".") if isinstance(text, str) else text
