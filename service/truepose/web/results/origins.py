"""Sessions with what their plans were asked for."""

from collections.abc import Sequence

from truepose.storage.records import SessionRecord
from truepose.web.context import Context
from truepose.web.results.kinds import Origin


async def origins_of(here: Context, records: Sequence[SessionRecord]) -> list[Origin]:
    """Return sessions with what was asked of the jobs that planned them."""
    asked = await here.jobs.plans_of([record.id for record in records])
    return [Origin(record, asked.get(record.id, {})) for record in records]


async def origin_of(here: Context, session_id: int) -> Origin:
    """Return one session so; raises NotFoundError."""
    (found,) = await origins_of(here, [await here.sessions.get(session_id)])
    return found
