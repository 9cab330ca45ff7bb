"""The page that a plant has of a cell: visits, its chain, and another chain accepted after a look."""

from collections.abc import Mapping
from dataclasses import dataclass
from http import HTTPStatus
from typing import Final

from fastapi import APIRouter
from fastapi.responses import HTMLResponse

from truepose.storage.plant.records import Outcome, Visit
from truepose.web.plant.context import PlantContext, PlantHere
from truepose.web.plant.pages.shown import shown_cells
from truepose.web.requests.parameters import Name
from truepose.web.visiting.moments import moment
from truepose.web.visiting.visits import Visited

router = APIRouter(include_in_schema=False)
_VISITS: Final = 50
_OUTCOMES: Final[Mapping[Outcome, str]] = {
    Outcome.WHOLE: "plant.cell.whole",
    Outcome.UNREACHABLE: "plant.cell.unreachable",
    Outcome.REFUSED: "plant.cell.refused",
    Outcome.ANOTHER_CHAIN: "plant.cell.another_chain",
}


@dataclass(frozen=True, slots=True)
class OtherChain:
    """What would be done with another chain that a cell shows."""

    common: int  # the last link that both have
    collected: int  # links that the plant has
    there: int  # links that the cell has now

    @property
    def in_plant_alone(self) -> int:
        """How many links the plant has that the cell has no longer."""
        return self.collected - self.common

    @property
    def to_collect(self) -> int:
        """How many links the cell has that the plant has not."""
        return self.there - self.common


@router.get("/cells/{name:path}", response_class=HTMLResponse)
async def plant_cell_page(visit: Visited, here: PlantHere, name: Name) -> HTMLResponse:
    """Show what visits to a cell found, and let a metrologist accept another chain that it shows."""
    newest = await here.visits.newest()
    if name not in newest:
        return visit.page("plant/missing.html", HTTPStatus.NOT_FOUND, sentence="plant.cell.missing", of=name)
    (cell,) = shown_cells(here, {name: newest[name]})
    return visit.page(
        "plant/cell.html",
        cell=cell,
        other=None if cell.newest is None else await _other_chain(here, name, cell.newest.visit),
        branches=await here.journal.accepted_branches(name),
        visits=await here.visits.of(name, _VISITS),
        outcomes=_OUTCOMES,
        moment=moment,
    )


async def _other_chain(here: PlantContext, name: str, seen: Visit) -> OtherChain | None:
    """Return the chain that waits to be accepted; None: there is none, or it was accepted since the visit."""
    if seen.outcome is not Outcome.ANOTHER_CHAIN or seen.fork is None or not here.collector.knows(name):
        return None
    known = await here.journal.collected(await here.journal.reached(name))
    if seen.head != known.head.text:
        return None
    return OtherChain(seen.fork, known.position, seen.newest or 0)
