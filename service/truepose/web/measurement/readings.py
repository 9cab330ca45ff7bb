"""Readings of all sessions."""

from typing import Annotated

from fastapi import Query

from truepose.storage.records import ReadingKind
from truepose.web.context import Here
from truepose.web.problems import problems
from truepose.web.requests.paging import Paged, listing
from truepose.web.requests.parameters import Id
from truepose.web.resources import resource
from truepose.web.schemas.base import NUMBER_LIMIT
from truepose.web.schemas.measurement.readings import ReadingReply, reading_reply

router = resource(tags=["readings"])
OfKind = Annotated[ReadingKind | None, Query(description="Only of this kind.")]
Superseded = Annotated[bool, Query(description="False: only readings that count.")]
OfSession = Annotated[int | None, Query(ge=1, le=NUMBER_LIMIT, description="Only of this session.")]


@router.get("/readings", responses=listing(422, 503))
async def list_readings(
    here: Here,
    paging: Paged,
    session_id: OfSession = None,
    kind: OfKind = None,
    superseded: Superseded = True,
) -> list[ReadingReply]:
    """List readings in the order they were taken."""
    found = await here.readings.page(paging.page, session_id=session_id, kind=kind, superseded=superseded)
    return paging.shown(found, reading_reply)


@router.get("/readings/{id}", responses=problems(404, 422, 503))
async def get_reading(here: Here, id: Id) -> ReadingReply:
    """Show a reading as it was stored."""
    return reading_reply(await here.readings.get(id))


@router.get("/sessions/{id}/readings", responses=listing(404, 422, 503))
async def list_readings_of_session(
    here: Here, id: Id, paging: Paged, kind: OfKind = None, superseded: Superseded = True
) -> list[ReadingReply]:
    """List the readings of a session in the order they were taken."""
    await here.sessions.require(id)
    found = await here.readings.page(paging.page, session_id=id, kind=kind, superseded=superseded)
    return paging.shown(found, reading_reply)
