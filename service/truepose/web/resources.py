"""What resources of the API are made of: routers, parameters, pages of lists, and the problems they list.

A parameter that an operation does not know is refused: a misspelt `limit` or `superseded` would otherwise be
answered with another list than the one asked for.

The framework makes every route of a router once more where another one includes it, and the service would
start a tenth later: whoever gathers routers takes their routes as they are.
"""

import asyncio
import contextlib
import difflib
import hashlib
from collections.abc import AsyncIterator, Callable, Coroutine, Mapping, Sequence
from http import HTTPStatus
from typing import Annotated, Any, Final, TypeVar

from fastapi import APIRouter, Depends, Header, HTTPException, Path, Query, Request, Response, params
from fastapi.dependencies.utils import get_flat_params
from fastapi.exceptions import RequestValidationError
from fastapi.routing import APIRoute
from pydantic import Field
from starlette.datastructures import QueryParams
from starlette.requests import ClientDisconnect
from starlette.types import Receive, Scope, Send

from truepose.messages.message import Message, message
from truepose.storage.queries import Part
from truepose.storage.records import Page, RequestKey
from truepose.web.middleware.rights import current_request, signed_in_name
from truepose.web.problems import MEDIA_TYPE, UNKNOWN_PARAMETER
from truepose.web.schemas import KEY, NUMBER_LIMIT, VISIBLE

_MEANING: Mapping[int, str] = {
    400: "The request cannot be parsed.",
    401: "Nobody is signed in, or the name and secret do not match.",
    403: "The caller is not permitted to do this, or must authenticate again.",
    404: "The resource does not exist.",
    408: "The body did not arrive in time.",
    409: "The request is not possible in the present state.",
    413: "The body is too large.",
    415: "The media type of the body is not supported.",
    422: "The request is well-formed but invalid; `detail` names the field.",
    429: "There were too many attempts; `Retry-After` says when to try again.",
    503: "A device or the disk does not respond, or too many requests are in progress.",
}


def problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return what a route lists under `responses` for the problems it may answer with."""
    schema = {"$ref": "#/components/schemas/Problem"}
    return {
        status: {"description": _MEANING[status], "content": {MEDIA_TYPE: {"schema": schema}}}
        for status in statuses
    }


_ALIKE: Final = 0.7  # `limt` and `limit` 0.89; `state` and `after`, which nobody confuses, 0.6


def require_known_parameters(route: APIRoute, scope: Scope) -> None:
    """Refuse a request with a parameter in its query that its operation does not take.

    Raises
    ------
    RequestValidationError
        Names the first one, and the known one that it resembles most, or all that there are.
    """
    known = _taken(route)
    unknown = next((name for name in QueryParams(scope["query_string"]) if name not in known), None)
    if unknown is not None:
        fault = {"type": UNKNOWN_PARAMETER, "loc": ("query", unknown), "msg": _hint(unknown, known)}
        raise RequestValidationError([fault])


def _taken(route: APIRoute) -> tuple[str, ...]:
    fields = get_flat_params(route.dependant)
    return tuple(field.alias for field in fields if isinstance(field.field_info, params.Query))


def _hint(unknown: str, known: tuple[str, ...]) -> Message:
    if not known:
        return message("refused.no_parameters")
    like = difflib.get_close_matches(unknown.lower(), known, n=1, cutoff=_ALIKE)
    if like:
        return message("refused.meant_parameter", name=like[0])
    return message("refused.known_parameters", names=", ".join(known))


def correct_parameters(document: dict[str, Any]) -> None:
    """Let a document say of parameters what is true of every one: never null, no zero byte in an address."""
    for methods in document["paths"].values():
        for operation in methods.values():
            for parameter in operation.get("parameters", []):
                # No address and no header can say null.
                parameter["schema"] = _without_null(parameter["schema"])
                _exclude_zero_byte(parameter)


def _without_null(schema: dict[str, Any]) -> dict[str, Any]:
    choices = [choice for choice in schema.get("anyOf", []) if choice != {"type": "null"}]
    if len(choices) != 1:
        return schema
    return {**choices[0], **{name: value for name, value in schema.items() if name != "anyOf"}}


_NO_ZERO_BYTE: Final = r"[^\u0000]*"
_VISIBLE_ALONE: Final = VISIBLE.replace("[^", r"[^\u0000", 1)
# Of a text in an address, by what its operation asks of it.
_IN_ADDRESS: Final = {
    None: f"^{_NO_ZERO_BYTE}$",
    VISIBLE: f"^{_NO_ZERO_BYTE}{_VISIBLE_ALONE}{_NO_ZERO_BYTE}$",
}


def _exclude_zero_byte(parameter: dict[str, Any]) -> None:
    """Let a text in an address be documented as `middleware.limits` wants every one."""
    schema = parameter["schema"]
    is_text = schema.get("type") == "string" and not schema.keys() & {"enum", "format"}
    if parameter["in"] in {"path", "query"} and is_text and schema.get("pattern") in _IN_ADDRESS:
        schema["pattern"] = _IN_ADDRESS[schema.get("pattern")]


_PREFIX: Final = "/api/v1"


class _Operation(APIRoute):
    """An operation that refuses a query that it does not understand."""

    async def handle(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request at the path of the operation."""
        if scope["query_string"] and scope["method"] in (self.methods or ()):
            require_known_parameters(self, scope)
        await super().handle(scope, receive, send)


def resource(prefix: str = "", *, tags: Sequence[str] = ()) -> APIRouter:
    """Return the router of a resource of the API."""
    return APIRouter(
        prefix=_PREFIX + prefix,
        tags=[*tags],
        route_class=_Operation,
        responses=problems(401, 403, 422),
        generate_unique_id_function=_operation_id,
    )


def outside_the_api(*, tags: Sequence[str]) -> APIRouter:
    """Return the router of what programs ask for that is in no version of the API."""
    return APIRouter(tags=[*tags], generate_unique_id_function=_operation_id)


def _operation_id(route: APIRoute) -> str:
    """Return what programs call an operation: the name of its function, as `start_session`."""
    return route.name


Id = Annotated[int, Path(ge=1, le=NUMBER_LIMIT, description="Number of the record.", examples=[3])]
ModelId = Annotated[int, Query(ge=1, le=NUMBER_LIMIT, description="Number of the model.", examples=[3])]
WantedModel = Annotated[
    int | None,
    Query(
        alias="model_id", ge=1, le=NUMBER_LIMIT, description="Number of the model that the form preselects."
    ),
]
ModelIds = Annotated[
    list[Annotated[int, Field(ge=1, le=NUMBER_LIMIT)]],
    Query(default_factory=list, max_length=8, description="Numbers of models.", examples=[[3]]),
]
Name = Annotated[str, Path(min_length=1, max_length=200, description="Name as given in the list.")]
IdempotencyKey = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=128,
        pattern=KEY,
        description="Text of your choice. A repeated request with the same key creates nothing new and "
        "returns the result of the first one.",
        examples=["3f1c6a9e-plan-left-arm"],
    ),
]

RESPOND_ASYNC: Final = "respond-async"
Prefer = Annotated[
    str | None,
    Header(
        max_length=200,
        description="`respond-async`: respond at once with a job (202), which can be followed and "
        "cancelled at `/jobs` (RFC 7240). Otherwise the response comes when the work is done.",
        examples=[RESPOND_ASYNC],
    ),
]


NeededKey = Annotated[
    str,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=128,
        pattern=KEY,
        description="Text of your choice. A repeated command with the same key is executed only once and "
        "returns the sentence and entry of the first one.",
        examples=["3f1c6a9e-store-leg-2-3"],
    ),
]


async def _json_key(request: Request, key: IdempotencyKey = None) -> RequestKey | None:
    return None if key is None else request_key(request, key, await request.body())


async def _needed_key(request: Request, key: NeededKey) -> RequestKey:
    return request_key(request, key, await request.body())


async def _sender(request: Request) -> str:
    """Return who asks, as far as workers are given out fairly: the person, else the computer."""
    return signed_in_name() or (request.client.host if request.client else "")


async def _respond_later(prefer: Prefer = None) -> bool:
    """Return whether a client would rather be told of a job than wait (RFC 7240)."""
    wishes = {wish.split(";")[0].strip().lower() for wish in (prefer or "").split(",")}
    return RESPOND_ASYNC in wishes


def number_of(text: str) -> int | None:
    """Return the number that a part of a page's address is; None where it is none."""
    if not (text.isascii() and text.isdecimal()) or len(text) > len(str(NUMBER_LIMIT)):
        return None
    number = int(text)
    return number if 1 <= number <= NUMBER_LIMIT else None


def request_key(request: Request, key: str, body: bytes) -> RequestKey:
    """Return the key with the fingerprint of the request it came with."""
    target = f"{request.url.path}?{request.url.query}"
    who = current_request().caller.name  # the same key of somebody else is no repetition
    said = b"\n".join((request.method.encode(), target.encode(), who.encode(), body))
    return RequestKey(key, hashlib.sha256(said).hexdigest())


Sender = Annotated[str, Depends(_sender)]
OptionalKey = Annotated[RequestKey | None, Depends(_json_key)]
Later = Annotated[bool, Depends(_respond_later)]
RequiredKey = Annotated[RequestKey, Depends(_needed_key)]


R = TypeVar("R")
T = TypeVar("T")
MOST: Final = 500  # of a page, however many are asked for
_TOTAL: Final = "Total-Count"
_HEADERS: Final[dict[str, Any]] = {
    _TOTAL: {
        "description": "Total number of records in the list.",
        "schema": {"type": "integer", "minimum": 0},
        "example": 1204,
    },
    "Link": {
        "description": 'Link to the next page, as `<...>; rel="next"` (RFC 8288); absent on the last page.',
        "schema": {"type": "string"},
        "example": '</api/v1/sessions?after=100&limit=100>; rel="next"',
    },
}
After = Annotated[int, Query(ge=0, le=NUMBER_LIMIT, description="Only records with a higher number.")]
LeftOut = Annotated[
    int, Query(ge=0, le=NUMBER_LIMIT, description="Number of entries to skip at the beginning of the list.")
]
Limit = Annotated[
    int, Query(ge=1, le=1000, description=f"Maximum number of records; a page has {MOST} at most.")
]


class Paging:
    """Which page of a list a request asks for, and what its answer says of the whole list."""

    def __init__(
        self,
        request: Request,
        response: Response,
        after: After = 0,
        limit: Limit = 100,
    ) -> None:
        self.page = Page(after, min(limit, MOST))
        self._request = request
        self._response = response

    def shown(self, part: Part[R], reply: Callable[[R], T]) -> list[T]:
        """Return a part as it travels; headers of the answer say how many there are and what comes next."""
        self.say(part.total, part.next_after)
        return [reply(record) for record in part]

    def say(self, total: int, next_after: int | None) -> None:
        """Let the answer say how many records there are, and behind which number the next page begins."""
        self._response.headers[_TOTAL] = str(total)
        if next_after is not None:
            url = self._request.url.include_query_params(after=next_after, limit=self.page.limit)
            self._response.headers["Link"] = f'<{url.path}?{url.query}>; rel="next"'


class Counting(Paging):
    """Paging of what has no numbers of its own: counted from the beginning, as many as a page may have."""

    def __init__(
        self,
        request: Request,
        response: Response,
        after: LeftOut = 0,
        limit: Limit = MOST,
    ) -> None:
        super().__init__(request, response, after, limit)

    def of(self, records: Sequence[R], reply: Callable[[R], T]) -> list[T]:
        """Return the part of a list that is asked for as it travels; headers tell of the whole."""
        end = self.page.after + self.page.limit
        self.say(len(records), end if end < len(records) else None)
        return [reply(record) for record in records[self.page.after : end]]


Paged = Annotated[Paging, Depends()]
Counted = Annotated[Counting, Depends()]


def listing(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Return what the route of a list has under `responses`: its headers, and its problems."""
    return {200: {"headers": _HEADERS}, **problems(*statuses)}


def sending(what: str, content: dict[str, Any]) -> dict[int | str, dict[str, Any]]:
    """Return what a route that sends a file or a stream lists under `responses`, beside its problems."""
    return {200: {"description": what, "content": content}}


# What most operations list under `responses`: those that show a record, that the present state may forbid,
# that take a body as well, and lists of everything or of what belongs to a record.
READ: Final = problems(404, 422, 503)
ACT: Final = problems(404, 409, 422, 503)
CHANGE: Final = problems(400, 404, 409, 413, 415, 422, 503)
LIST: Final = listing(422, 503)
LIST_OF_RECORD: Final = listing(404, 422, 503)


@contextlib.asynccontextmanager
async def receiving(within_s: float, what: str, lost: str) -> AsyncIterator[None]:
    """Answer with 408 where a body takes longer; `lost` says what became of what came so far."""
    try:
        async with asyncio.timeout(within_s):
            yield
    except TimeoutError as error:
        sentence = f"The {what} did not arrive within {within_s:.0f} s; {lost}. Send it again."
        raise HTTPException(HTTPStatus.REQUEST_TIMEOUT, sentence) from error


async def while_present(request: Request, work: Coroutine[Any, Any, T]) -> T:
    """Return what `work` returns; it is cancelled once the client has gone.

    The body of the request must have been read: what comes after it is the end of the connection.

    Raises
    ------
    ClientDisconnect
        The client has gone; nobody will see the answer.
    """
    working = asyncio.ensure_future(work)
    gone = asyncio.create_task(_gone(request))
    try:
        await asyncio.wait({working, gone}, return_when=asyncio.FIRST_COMPLETED)
        if not working.done():
            raise ClientDisconnect
        return working.result()
    finally:
        for task in (working, gone):
            task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await gone
        # Until it has let go of what it held: the next one may be waiting for that.
        await asyncio.wait({working})


async def _gone(request: Request) -> None:
    while (await request.receive())["type"] != "http.disconnect":
        pass
