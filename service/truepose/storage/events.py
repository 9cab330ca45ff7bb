"""What happened, numbered in the order of the commits, so that a client can resume where it stopped.

An event is written in the transaction of the record that it tells of: neither exists without the other.
"""

from typing import Any

from sqlalchemy import Connection, Row, select

from truepose.storage.database import Database
from truepose.storage.records import EventRecord, Page
from truepose.storage.rows import add_row
from truepose.storage.tables import events


def add_event(
    connection: Connection,
    kind: str,
    document: dict[str, Any],
    *,
    session_id: int | None = None,
    job_id: int | None = None,
) -> None:
    """Append an event inside the caller's transaction."""
    add_row(connection, events, kind=kind, session_id=session_id, job_id=job_id, document=document)


class EventRepository:
    """Reads events; they are written by the repositories of what happened."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def after(
        self, page: Page, *, session_id: int | None = None, job_id: int | None = None
    ) -> list[EventRecord]:
        """Return the events that follow number `page.after`, oldest first."""
        query = select(events).where(events.c.id > page.after).order_by(events.c.id).limit(page.limit)
        if session_id is not None:
            query = query.where(events.c.session_id == session_id)
        if job_id is not None:
            query = query.where(events.c.job_id == job_id)
        return await self._database.read(lambda c: [_event(row) for row in c.execute(query)])

    async def newest(self) -> int:
        """Return the number of the newest event, 0 before the first."""
        query = select(events.c.id).order_by(events.c.id.desc()).limit(1)
        return int(await self._database.read(lambda c: c.scalar(query)) or 0)


def _event(row: Row[Any]) -> EventRecord:
    return EventRecord(row.id, row.recorded_at, row.kind, row.session_id, row.job_id, row.document)
