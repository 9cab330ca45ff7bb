"""The cells of a plant: how far each was collected, what came of the visits, and another chain accepted."""

from typing import Annotated

from fastapi import Query, status
from starlette.convertors import StringConvertor, register_url_convertor

from truepose.storage.errors import NotInPlantError
from truepose.storage.plant.records import VisitRecord
from truepose.web.people.asking import asking
from truepose.web.plant.context import PlantContext, PlantHere
from truepose.web.plant.schemas import (
    BranchRequest,
    PlantCellReply,
    PlantRecordReply,
    VisitReply,
    VisitsReply,
    record_reply,
    visit_reply,
)
from truepose.web.problems import problems
from truepose.web.requests.paging import Counted, Paged, listing
from truepose.web.requests.parameters import Name
from truepose.web.resources import resource
from truepose.web.schemas.base import VISIBLE


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
        description="Only records of this kind, as `readings`, `deliveries` or `campaigns`.",
        examples=["readings"],
    ),
]


@router.get("", responses=listing(422, 503))
async def list_plant_cells(here: PlantHere, paging: Counted) -> list[PlantCellReply]:
    """List the cells, by name, with the newest visit to each."""
    newest = await here.visits.newest()
    return paging.of([*newest.items()], lambda item: _reply(here, *item))


@router.get("/{name:path}/records", responses=listing(404, 422, 503))
async def list_plant_records(
    here: PlantHere, name: Name, paging: Paged, kind: KindOfRecord = None
) -> list[PlantRecordReply]:
    """List what was collected from a cell, in order: all that is left of a cell whose disk is lost."""
    if name not in await here.visits.newest():
        raise NotInPlantError(f"There is no cell '{name}' in this plant.")
    return paging.shown(await here.lines.of(name, paging.page, kind), record_reply)


@router.get("/{name:cell_name}", responses=problems(404, 422, 503))
async def get_plant_cell(here: PlantHere, name: Name) -> VisitsReply:
    """Show a cell, and the latest visits to it, newest first."""
    newest = await here.visits.newest()
    if name not in newest:
        raise NotInPlantError(f"There is no cell '{name}' in this plant.")
    visits = [visit_reply(record) for record in await here.visits.of(name, _VISITS)]
    return VisitsReply(cell=_reply(here, name, newest[name]), visits=visits)


@router.post(
    "/{name:path}/branches",
    status_code=status.HTTP_201_CREATED,
    responses=problems(400, 404, 409, 413, 415, 422, 503),
)
async def accept_branch(here: PlantHere, name: Name, wanted: BranchRequest) -> PlantCellReply:
    """Accept that a cell shows another chain than the one collected; it has a branch of its own."""
    _require(here, name)
    asking().reason = wanted.reason
    await here.journal.accept_other_chain(name, wanted.person, wanted.reason)
    here.collector.visit_soon(name)
    return _reply(here, name, (await here.visits.newest())[name])


@router.post("/{name:path}/visits", status_code=status.HTTP_202_ACCEPTED, responses=problems(404, 422, 503))
async def plan_visit(here: PlantHere, name: Name) -> PlantCellReply:
    """Have a cell visited now, and not only when it is due."""
    _require(here, name)
    here.collector.visit_soon(name)
    return _reply(here, name, (await here.visits.newest()).get(name))


def _require(here: PlantContext, name: str) -> None:
    if not here.collector.knows(name):
        raise NotInPlantError(f"There is no cell '{name}' in the cells file of this plant.")


def _reply(here: PlantContext, name: str, newest: VisitRecord | None) -> PlantCellReply:
    visit: VisitReply | None = None if newest is None else visit_reply(newest)
    return PlantCellReply(name=name, visited=here.collector.knows(name), newest_visit=visit)
