"""Health: outside the versioned API, for whatever watches the service."""

from fastapi import APIRouter

from service.web.context import Here
from service.web.schemas.cells import Health

router = APIRouter(tags=["health"])


@router.get("/health", response_model_by_alias=True)
async def get_health(here: Here) -> Health:
    """Say that the service works, its version, its database's schema, and whether all is simulated."""
    fault = here.fault()
    return Health(
        status="ok" if fault is None else "degraded",
        fault=fault,
        version=here.version,
        simulated=here.simulated,
        people="announced" if here.cell.people else "anybody",
        schema=here.database.schema,
    )
