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
    """A reading of a tool nest at a configuration."""

    config: int = Field(examples=[12])
    commanded_deg: list[float] = Field(description="Joint angles sent to the robot.")
    reported_deg: list[float] = Field(description="Joint angles reported by the controller.")
    direction: list[int] = Field(description="Direction of each joint's last motion: 1, -1, or 0 if unknown.")
    temperature_c: Quantity = Field(description="Air temperature at the instrument.", examples=[23.1])
    attachment: int = Field(description="Number of times the tool has been mounted.", examples=[1])
    rms_mm: Quantity = Field(description="Standard deviation of the samples.", examples=[0.012])
    samples: int = Field(examples=[1000])
    repeat_of: int | None = Field(description="Earlier configuration with the same joint angles.")
    group: int | None = Field(description="Group of readings in the plan to which this reading belongs.")
    quaternion: list[float] | None = Field(
        description="Orientation of the artefact in the world frame, w first; null for a tracker, which "
        "measures points."
    )
    rotation_uncertainty_deg: Quantity | None = Field(
        description="Standard uncertainty of the orientation, per axis; null for a tracker."
    )


class FixedNestReadingReply(Reply):
    """A reading of a fixed nest."""

    phase: str = Field(description="`registration`, `two_face` or `reference`.", examples=["reference"])
    face: int = Field(examples=[1])


class ReadingReply(Reply):
    """A reading; either `point` or `fixed_nest` is given."""

    id: RecordId
    session_id: RecordId
    recorded_at: RecordedAt
    kind: ReadingKind
    supersedes: int | None = Field(
        description="Number of the earlier reading of the same configuration that this reading replaces."
    )
    superseded_by: int | None = Field(description="Number of the later reading that replaces this reading.")
    nest: int = Field(description="Number of the tool nest or fixed nest.", examples=[2])
    time_s: float = Field(description="Cell time of the reading.", examples=[812.4])
    position_tracker_mm: Point = Field(description="Position in the tracker frame.")
    position_world_mm: Point | None = Field(
        description="Position in the world frame; null until the registration."
    )
    standard_uncertainty_mm: Quantity = Field(description="Standard uncertainty per axis.", examples=[0.015])
    instrument_serial: str = Field(
        description="Serial number reported by the instrument; empty if it reports none."
    )
    point: PointReadingReply | None
    fixed_nest: FixedNestReadingReply | None


def reading_reply(record: ReadingRecord) -> ReadingReply:
    """Return a reading as it travels."""
    taken = record.reading
    if isinstance(taken, PointTaken):
        return ReadingReply.of(record, taken, point=taken, fixed_nest=None)
    return ReadingReply.of(record, taken, nest=taken.fixed_nest, point=None, fixed_nest=taken)


router = resource(tags=["readings"])
OfKind = Annotated[ReadingKind | None, Query(description="Only readings of this kind.")]
Superseded = Annotated[bool, Query(description="False: omit readings that were replaced by later ones.")]
OfSession = Annotated[int | None, Query(ge=1, le=NUMBER_LIMIT, description="Only readings of this session.")]


@router.get("/readings", responses=LIST)
async def list_readings(
    here: Here,
    paging: Paged,
    session_id: OfSession = None,
    kind: OfKind = None,
    superseded: Superseded = True,
) -> list[ReadingReply]:
    """List readings in the order in which they were taken."""
    found = await here.readings.page(paging.page, session_id=session_id, kind=kind, superseded=superseded)
    return paging.shown(found, reading_reply)


@router.get("/readings/{id}", responses=READ)
async def get_reading(here: Here, id: Id) -> ReadingReply:
    """Return a reading as stored."""
    return reading_reply(await here.readings.get(id))


@router.get("/sessions/{id}/readings", responses=LIST_OF_RECORD)
async def list_readings_of_session(
    here: Here, id: Id, paging: Paged, kind: OfKind = None, superseded: Superseded = True
) -> list[ReadingReply]:
    """List the readings of a session in the order in which they were taken."""
    await here.sessions.require(id)
    found = await here.readings.page(paging.page, session_id=id, kind=kind, superseded=superseded)
    return paging.shown(found, reading_reply)
