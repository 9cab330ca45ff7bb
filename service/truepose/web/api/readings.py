"""Readings of all sessions."""

from typing import Annotated

from fastapi import Query
from pydantic import Field

from truepose.domain.session import PointTaken
from truepose.exchange.results.document import Quantity
from truepose.storage.records import ReadingKind, ReadingRecord
from truepose.web.context import Here
from truepose.web.resources import LIST, LIST_OF_RECORD, READ, Id, Paged, resource
from truepose.web.schemas import NUMBER_LIMIT, Point, RecordedAt, RecordId, Reply


class PointReadingReply(Reply):
    """What was read at a stop, on a tool nest."""

    config: int = Field(examples=[12])
    commanded_deg: list[float] = Field(description="Joint angles that the robot was sent to.")
    reported_deg: list[float] = Field(description="Joint angles that the controller reported there.")
    direction: list[int] = Field(description="Sign of each joint's last motion; 0 unknown.")
    temperature_c: Quantity = Field(description="Of the air, at the instrument.", examples=[23.1])
    attachment: int = Field(description="How often the tool has been mounted.", examples=[1])
    rms_mm: Quantity = Field(description="Scatter of the samples.", examples=[0.012])
    samples: int = Field(examples=[1000])
    repeat_of: int | None = Field(description="Earlier configuration with the same joints.")
    group: int | None = Field(description="Of readings that belong together, as planned.")
    quaternion: list[float] | None = Field(
        description="Of the artefact in the world, w first; null of a tracker, which reads points."
    )
    rotation_uncertainty_deg: Quantity | None = Field(
        description="Of the orientation, per axis; null as above."
    )


class FixedNestReadingReply(Reply):
    """What was read on a fixed nest."""

    phase: str = Field(description="registration, two_face or reference.", examples=["reference"])
    face: int = Field(examples=[1])


class ReadingReply(Reply):
    """A reading; exactly one of `point` and `fixed_nest` is there."""

    id: RecordId
    session_id: RecordId
    recorded_at: RecordedAt
    kind: ReadingKind
    supersedes: int | None = Field(
        description="The earlier reading of the same stop, which no longer counts."
    )
    superseded_by: int | None = Field(description="The later reading that counts in its place.")
    nest: int = Field(description="Of the tool, or fixed.", examples=[2])
    time_s: float = Field(description="Cell time.", examples=[812.4])
    position_tracker_mm: Point = Field(description="In the tracker's frame.")
    position_world_mm: Point | None = Field(description="In the world; null before the registration.")
    standard_uncertainty_mm: Quantity = Field(description="Per axis.", examples=[0.015])
    instrument_serial: str = Field(description="As the instrument told it; empty where it does not.")
    point: PointReadingReply | None
    fixed_nest: FixedNestReadingReply | None


def reading_reply(record: ReadingRecord) -> ReadingReply:
    """Return a reading as it travels."""
    taken = record.reading
    if isinstance(taken, PointTaken):
        return ReadingReply.of(record, taken, point=taken, fixed_nest=None)
    return ReadingReply.of(record, taken, nest=taken.fixed_nest, point=None, fixed_nest=taken)


router = resource(tags=["readings"])
OfKind = Annotated[ReadingKind | None, Query(description="Only of this kind.")]
Superseded = Annotated[bool, Query(description="False: only readings that count.")]
OfSession = Annotated[int | None, Query(ge=1, le=NUMBER_LIMIT, description="Only of this session.")]


@router.get("/readings", responses=LIST)
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


@router.get("/readings/{id}", responses=READ)
async def get_reading(here: Here, id: Id) -> ReadingReply:
    """Show a reading as it was stored."""
    return reading_reply(await here.readings.get(id))


@router.get("/sessions/{id}/readings", responses=LIST_OF_RECORD)
async def list_readings_of_session(
    here: Here, id: Id, paging: Paged, kind: OfKind = None, superseded: Superseded = True
) -> list[ReadingReply]:
    """List the readings of a session in the order they were taken."""
    await here.sessions.require(id)
    found = await here.readings.page(paging.page, session_id=id, kind=kind, superseded=superseded)
    return paging.shown(found, reading_reply)
