"""Health of a plant's service: whether it can keep what it collects."""

from http import HTTPStatus

from fastapi import Response

from truepose.web.plant.context import PlantContext, PlantHere
from truepose.web.plant.schemas import PlantHealth
from truepose.web.problems import problems
from truepose.web.resources import outside_the_api

router = outside_the_api(tags=["health"])


@router.get("/health", responses=problems(503), response_model_by_alias=True)
async def get_health(here: PlantHere, response: Response) -> PlantHealth:
    """Say that the plant works; a cell that is away is no fault of the plant."""
    if here.database.condition.damaged:
        response.status_code = HTTPStatus.SERVICE_UNAVAILABLE
    fault = _fault(here)
    return PlantHealth(
        status="ok" if fault is None else "degraded",
        fault=fault,
        version=here.version,
        schema=here.database.schema,
        cells=len(here.collector.cells),
    )


def _fault(here: PlantContext) -> str | None:
    """Return what is amiss as anybody may hear it."""
    if here.database.condition.fault is not None:
        return "Something is amiss; sign in to see what."
    if here.collector.has_ended:
        return "No cell is visited any more; the log says why, and a new start begins again."
    return None
