"""The acts of people and programs, for whoever asks later: a page at a time, or all of them as lines."""

import json
from collections.abc import AsyncIterator
from typing import Annotated, Final

from fastapi import Query
from fastapi.responses import Response, StreamingResponse

from truepose.storage.records import Page
from truepose.web.context import Context, Here
from truepose.web.people.schemas import ActOfPersonReply, ActsReply
from truepose.web.problems import problems
from truepose.web.resources import resource
from truepose.web.schemas.base import NUMBER_LIMIT

router = resource("/audit", tags=["people"])
_TOGETHER: Final = 500
_LINES: Final = {"application/jsonl": {"schema": {"type": "string"}}}
Search = Annotated[
    str, Query(max_length=200, description="In person, operation, resource, reason or address.")
]
Before = Annotated[int | None, Query(ge=1, le=NUMBER_LIMIT, description="Number; acts before it.")]
Limit = Annotated[int, Query(ge=1, le=_TOGETHER, description="How many at most.")]


@router.get("", responses=problems(422, 503))
async def list_acts(here: Here, search: Search = "", before: Before = None, limit: Limit = 100) -> ActsReply:
    """List what was changed or refused, newest first."""
    await here.people.log.written()
    found = await here.people.acts.newest(before, limit, search)
    return ActsReply(
        acts=[ActOfPersonReply.about(record) for record in found], total=await here.people.acts.count(search)
    )


@router.get(
    "/lines",
    response_class=Response,
    responses={
        200: {"description": "One act a line, oldest first.", "content": _LINES},
        **problems(422, 503),
    },
)
async def download_acts(here: Here, search: Search = "") -> StreamingResponse:
    """Download all acts as JSON lines, oldest first."""
    headers = {"Content-Disposition": 'attachment; filename="acts.jsonl"'}
    return StreamingResponse(_lines(here, search), media_type="application/jsonl", headers=headers)


async def _lines(here: Context, search: str) -> AsyncIterator[str]:
    after = 0
    while found := await here.people.acts.page(Page(after, _TOGETHER), search):
        yield "".join(f"{json.dumps(ActOfPersonReply.about(act).model_dump())}\n" for act in found)
        after = found[-1].id
