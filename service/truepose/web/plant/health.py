"""Health of a plant's service: whether it can keep what it collects."""

from http import HTTPStatus

from fastapi import Response

from truepose.web.plant.context import PlantContext, PlantHere
from truepose.web.plant.schemas import PlantHealth
from truepose.web.problems import problems
from truepose.web.resources import outside_the_api
from truepose.web.visiting.visits import Visited

router = outside_the_api(tags=["health"])


@router.get("/health", responses=problems(503), response_model_by_alias=True)
async def get_health(visit: Visited, here: PlantHere, response: Response) -> PlantHealth:
    """Say that the plant works; a cell that is away is no fault of the plant.

    Strangers learn of a fault of the records that there is one, and not which.
    """
    if here.database.condition.damaged:
        response.status_code = HTTPStatus.SERVICE_UNAVAILABLE
    known = visit.may("plant_page")
    fault = _fault(here, known=known) or await _away(here, known=known)
    return PlantHealth(
        status="ok" if fault is None else "degraded",
        fault=fault,
        doing=_doing(here),
        version=here.version,
        schema=here.database.schema,
        cells=len(here.collector.cells),
        newest_copy_age_s=None if here.copies is None else here.copies.age_s,
    )


def _doing(here: PlantContext) -> str | None:
    catching_up = here.journal.catching_up
    return None if catching_up is None or not catching_up.of else str(catching_up)


def _fault(here: PlantContext, *, known: bool) -> str | None:
    """Return what is amiss, of the records as anybody may hear it, or as those who are known may."""
    of_records = here.database.condition.fault
    if of_records is not None:
        return of_records if known else "Something is amiss; sign in to see what."
    if here.collector.has_ended:
        return "No cell is visited any more; the log says why, and a new start begins again."
    if here.copies is not None and here.copies.fault is not None:
        return "No copy of the database could be made; the log says why."
    return None


async def _away(here: PlantContext, *, known: bool) -> str | None:
    """Return that robots cannot be compared anew; where the workers are is told to those who are known."""
    why = await here.fleets.away()
    if not why:
        return None
    said = (
        "The workers of this plant cannot be used: robots are compared as far as campaigns were read before."
    )
    return f"{said} {why}" if known else said
