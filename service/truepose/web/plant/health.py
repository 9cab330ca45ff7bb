"""Health of a plant's service: whether it can keep what it collects."""

from http import HTTPStatus

from fastapi import Response

from truepose.web.plant.context import PlantHere
from truepose.web.plant.schemas import PlantHealth
from truepose.web.problems import problems
from truepose.web.resources import outside_the_api

router = outside_the_api(tags=["health"])


@router.get("/health", responses=problems(503), response_model_by_alias=True)
async def get_health(here: PlantHere, response: Response) -> PlantHealth:
    """Say that the plant works; a cell that is away is no fault of the plant."""
    condition = here.database.condition
    if condition.damaged:
        response.status_code = HTTPStatus.SERVICE_UNAVAILABLE
    return PlantHealth(
        status="ok" if condition.fault is None else "degraded",
        fault=None if condition.fault is None else "Something is amiss; sign in to see what.",
        version=here.version,
        schema=here.database.schema,
        cells=len(here.collector.cells),
    )
