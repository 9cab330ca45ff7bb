"""The cells of a plant: how far each was collected, visits, records, another chain; the plant's health."""

from http import HTTPStatus
from typing import Annotated, Any, Literal

from fastapi import Query, Response, status
from pydantic import Field
from starlette.convertors import StringConvertor, register_url_convertor

from truepose.messages.message import message
from truepose.storage.errors import NotInPlantError
from truepose.storage.plant.journal import JournalLine
from truepose.storage.plant.records import VisitRecord
from truepose.web.middleware.rights import current_request
from truepose.web.pages.rendering import Visited
from truepose.web.plant.context import PlantContext, PlantHere
from truepose.web.resources import (
    CHANGE,
    LIST,
    LIST_OF_RECORD,
    READ,
    Counted,
    Name,
    Paged,
    outside_the_api,
    problems,
    resource,
)
from truepose.web.schemas import VISIBLE, PersonName, RecordedAt, RecordId, Reply, Request


class PlantHealth(Reply):
    """Health of the plant service."""

    status: Literal["ok", "degraded"]
    fault: str | None
    version: str = Field(examples=["0.1.0"])
    schema_revision: str = Field(alias="schema", examples=["0001"])
    cells: int = Field(description="Number of cells in the cells file.", examples=[2])
    newest_copy_age_s: float | None = Field(
        description="Age of the latest backup of the database; null if there is none or backups are off.",
        examples=[3600.0],
    )


class VisitReply(Reply):
    """Result of a collection from a cell."""

    id: RecordId
    recorded_at: RecordedAt
    found_at: str = Field(
        description="Time of the latest collection with this result, since the start of the plant; "
        "otherwise equal to `recorded_at`.",
        examples=["2026-05-04T09:42:31.007+00:00"],
    )
    outcome: Literal["whole", "unreachable", "refused", "another_chain"]
    sentence: str = Field(description="Problem and remedy; empty if there is none.", examples=[""])
    collected: int = Field(description="Number of chain entries collected.", examples=[120])
    newest: int | None = Field(
        description="Number of the newest chain entry of the cell; null if it did not respond.",
        examples=[4711],
    )
    head: str | None = Field(
        description="Head hash of the collected entries, as printed in the cell's reports.",
        examples=["4711-K3QF-7ZWD-M2PA-XY5R"],
    )
    clock_offset_s: float | None = Field(description="Cell clock minus plant clock.", examples=[-1.25])
    clock_bound_s: float | None = Field(
        description="Bound on the error of `clock_offset_s`.", examples=[0.004]
    )
    version: str | None = Field(description="Version of the cell's software.", examples=["0.1.0"])


class PlantCellReply(Reply):
    """A cell of the plant."""

    name: str = Field(examples=["left arm"])
    visited: bool = Field(
        description="False if the cell is no longer in the cells file; the collected records are kept."
    )
    newest_visit: VisitReply | None


class VisitsReply(Reply):
    """A cell and the latest collections from it."""

    cell: PlantCellReply
    visits: list[VisitReply]


class BranchRequest(Request):
    """Person who accepts another chain of a cell, with the reason."""

    person: PersonName
    reason: str = Field(
        min_length=1, max_length=1000, pattern=VISIBLE, examples=["The disk was exchanged on Monday."]
    )


class PlantRecordReply(Reply):
    """A collected entry of a cell's hash chain, with its record."""

    id: RecordId
    recorded_at: RecordedAt
    branch: int = Field(
        description="Branch of the cell's chain; a new branch begins after a backup was restored.",
        examples=[1],
    )
    link: int = Field(description="Number of the entry in the cell's chain.", examples=[4711])
    stream: int = Field(
        description="Number of the session; 0 if the record belongs to no session.", examples=[3]
    )
    record: str = Field(description="Kind of record.", examples=["readings"])
    record_id: int = Field(description="Record number within the cell.", examples=[3])
    hash: str = Field(
        description="Hash of the entry, in hexadecimal.",
        examples=["9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"],
    )
    row: dict[str, Any] | None = Field(
        description="The record, each value with its type; null if the record never leaves the cell.",
        examples=[{"id": 3, "time_s": {"float": "0.1"}}],
    )
    verified: bool = Field(description="True if the hash matches the record.")


def visit_reply(record: VisitRecord) -> VisitReply:
    """Return a visit as it travels."""
    clock = record.visit.clock
    return VisitReply.of(
        record,
        record.visit,
        clock_offset_s=None if clock is None else clock.offset_s,
        clock_bound_s=None if clock is None else clock.bound_s,
    )


def record_reply(line: JournalLine) -> PlantRecordReply:
    """Return a line of a journal as it travels."""
    return PlantRecordReply.of(line, hash=line.hash.hex())


class _NameConvertor(StringConvertor):
    """A name with slashes in it, as `hall 2/left arm`, and nothing that is asked of a cell."""

    regex = r"(?!.*/(?:records|branches|visits)$).+"


register_url_convertor("cell_name", _NameConvertor())
router = resource("/plant/cells", tags=["plant"])
_VISITS = 200
KindOfRecord = Annotated[
    str | None,
    Query(
        min_length=1,
        max_length=80,
        pattern=VISIBLE,
        description="Only records of this kind, such as `readings`, `deliveries` or `campaigns`.",
        examples=["readings"],
    ),
]


@router.get("", responses=LIST)
async def list_plant_cells(here: PlantHere, paging: Counted) -> list[PlantCellReply]:
    """List the cells by name, each with the latest collection."""
    newest = await here.visits.newest()
    return paging.of([*newest.items()], lambda item: _reply(here, *item))


@router.get("/{name:path}/records", responses=LIST_OF_RECORD)
async def list_plant_records(
    here: PlantHere, name: Name, paging: Paged, kind: KindOfRecord = None
) -> list[PlantRecordReply]:
    """List the records collected from a cell, in order; they remain available if the cell's disk is lost."""
    if name not in await here.visits.newest():
        raise NotInPlantError(message("refused.no_cell", name=name))
    return paging.shown(await here.lines.of(name, paging.page, kind), record_reply)


@router.get("/{name:cell_name}", responses=READ)
async def get_plant_cell(here: PlantHere, name: Name) -> VisitsReply:
    """Return a cell and the latest collections from it, newest first."""
    newest = await here.visits.newest()
    if name not in newest:
        raise NotInPlantError(message("refused.no_cell", name=name))
    visits = [visit_reply(record) for record in await here.visits.of(name, _VISITS)]
    return VisitsReply(cell=_reply(here, name, newest[name]), visits=visits)


@router.post("/{name:path}/branches", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def accept_branch(here: PlantHere, name: Name, wanted: BranchRequest) -> PlantCellReply:
    """Accept that a cell now has a different chain from the one collected; it becomes a new branch."""
    require_in_file(here, name)
    current_request().reason = wanted.reason
    await here.journal.accept_other_chain(name, wanted.person, wanted.reason)
    here.collector.visit_soon(name)
    return _reply(here, name, (await here.visits.newest())[name])


@router.post("/{name:path}/visits", status_code=status.HTTP_202_ACCEPTED, responses=READ)
async def plan_visit(here: PlantHere, name: Name) -> PlantCellReply:
    """Collect the records of a cell now instead of at the next scheduled time."""
    require_in_file(here, name)
    here.collector.visit_soon(name)
    return _reply(here, name, (await here.visits.newest()).get(name))


def require_in_file(here: PlantContext, name: str) -> None:
    """Raise NotInPlantError where the cells file of the plant names no such cell."""
    if not here.collector.knows(name):
        raise NotInPlantError(message("refused.cell_not_in_file", name=name))


def _reply(here: PlantContext, name: str, newest: VisitRecord | None) -> PlantCellReply:
    visit: VisitReply | None = None if newest is None else visit_reply(newest)
    return PlantCellReply(name=name, visited=here.collector.knows(name), newest_visit=visit)


health_router = outside_the_api(tags=["health"])


@health_router.get("/health", responses=problems(503), response_model_by_alias=True)
async def get_health(visit: Visited, here: PlantHere, response: Response) -> PlantHealth:
    """Return the health of the plant service; an unreachable cell is not a fault of the plant.

    Without signing in, a fault of the records is reported without details.
    """
    if here.database.condition.damaged:
        response.status_code = HTTPStatus.SERVICE_UNAVAILABLE
    known = visit.may("plant_page")
    fault = _fault(here, known=known) or await _away(here, known=known)
    return PlantHealth(
        status="ok" if fault is None else "degraded",
        fault=fault,
        version=here.version,
        schema=here.database.schema,
        cells=len(here.collector.cells),
        newest_copy_age_s=None if here.copies is None else here.copies.age_s,
    )


def _fault(here: PlantContext, *, known: bool) -> str | None:
    """Return what is amiss, of the records as anybody may hear it, or as those who are known may."""
    of_records = here.database.condition.fault
    if of_records is not None:
        return of_records if known else "There is a problem; sign in for details."
    if here.collector.has_ended:
        return "Collection from the cells has stopped. See the log for the reason, then restart the service."
    if here.copies is not None and here.copies.fault is not None:
        return "The database could not be backed up. See the log for the reason."
    return None


async def _away(here: PlantContext, *, known: bool) -> str | None:
    """Return that robots cannot be compared anew; where the workers are is told to those who are known."""
    why = await here.fleets.away()
    if not why:
        return None
    said = (
        "The workers of this plant cannot be used, so robots are compared only with campaigns read earlier."
    )
    return f"{said} {why}" if known else said
