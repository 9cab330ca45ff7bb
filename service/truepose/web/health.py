"""Health: outside the versioned API, for whatever watches the service."""

from fastapi import APIRouter

from truepose.storage.connection.library import FAULTY as SQLITE_FAULTY
from truepose.storage.connection.library import VERSION as SQLITE_VERSION
from truepose.web.context import Here
from truepose.web.schemas.cells import Health, IntegrityReply

router = APIRouter(tags=["health"])


@router.get("/health", response_model_by_alias=True)
async def get_health(here: Here) -> Health:
    """Say that the service works, its version, its database's schema, and whether all is simulated.

    The status is 200 also where the disk refuses: the readings that wait for it are in this process, and
    whoever watches must not end it.
    """
    storage = here.database.condition
    fault = " ".join(told for told in (here.fault(), storage.fault) if told) or None
    return Health(
        status="ok" if fault is None else "degraded",
        fault=fault,
        version=here.version,
        simulated=here.simulated,
        people="announced" if here.cell.people else "anybody",
        schema=here.database.schema,
        writable=storage.trouble is None,
        integrity=IntegrityReply(state=storage.integrity, share=storage.verified_share),
        sqlite=SQLITE_VERSION,
        sqlite_mended=not SQLITE_FAULTY,
    )
