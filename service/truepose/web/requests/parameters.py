"""Parameters that several routes take."""

import hashlib
from typing import Annotated, Final

from fastapi import Depends, Header, Path, Query, Request
from pydantic import Field

from truepose.storage.records import RequestKey
from truepose.web.people.asking import signed_in_name
from truepose.web.schemas.base import KEY, NUMBER_LIMIT

Id = Annotated[int, Path(ge=1, le=NUMBER_LIMIT, description="Number of the record.", examples=[3])]
ModelId = Annotated[int, Query(ge=1, le=NUMBER_LIMIT, description="Number of the model.", examples=[3])]
WantedModel = Annotated[
    int | None, Query(alias="model_id", ge=1, le=NUMBER_LIMIT, description="Which model a form begins with.")
]
ModelIds = Annotated[
    list[Annotated[int, Field(ge=1, le=NUMBER_LIMIT)]],
    Query(default_factory=list, max_length=8, description="Numbers of models.", examples=[[3]]),
]
Name = Annotated[str, Path(min_length=1, max_length=200, description="Name as the list gives it.")]
IdempotencyKey = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=128,
        pattern=KEY,
        description="Any text of your own. A request sent again with the same key makes nothing twice: "
        "it answers with what the first one made.",
        examples=["3f1c6a9e-plan-left-arm"],
    ),
]

RESPOND_ASYNC: Final = "respond-async"
Prefer = Annotated[
    str | None,
    Header(
        max_length=200,
        description="`respond-async`: answer at once with the job that does it (202), which is watched and "
        "cancelled at `/jobs` (RFC 7240); else the answer comes when it is done.",
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
        description="Any text of your own. An act sent again with the same key is done once: it answers with "
        "the sentence and the entry of the first one.",
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
    said = b"\n".join((request.method.encode(), request.url.path.encode(), body))
    return RequestKey(key, hashlib.sha256(said).hexdigest())


Sender = Annotated[str, Depends(_sender)]
OptionalKey = Annotated[RequestKey | None, Depends(_json_key)]
Later = Annotated[bool, Depends(_respond_later)]
RequiredKey = Annotated[RequestKey, Depends(_needed_key)]
