"""What happened, numbered in the order of the commits, so that a client can resume where it stopped.

An event is written in the transaction of the record that it tells of: neither exists without the other.
"""

from functools import cache
from typing import Any

from sqlalchemy import Connection, Row, Select, bindparam, select

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
        wanted = {"session_id": session_id, "job_id": job_id}
        asked = {name: number for name, number in wanted.items() if number is not None}
        query = _following(frozenset(asked))
        given = {"after": page.after, "most": page.limit} | {f"of_{name}": of for name, of in asked.items()}
        return await self._database.read(lambda c: [_event(row) for row in c.execute(query, given)])

    async def newest(self) -> int:
        """Return the number of the newest event, 0 before the first."""
        query = select(events.c.id).order_by(events.c.id.desc()).limit(1)
        return int(await self._database.read(lambda c: c.scalar(query)) or 0)


@cache  # asked at every commit by everybody who follows: making it takes longer than its answer
def _following(of: frozenset[str]) -> Select[Any]:
    """Return the query for events that follow `after`, of one session or job where those are named."""
    query = select(events).where(events.c.id > bindparam("after")).order_by(events.c.id)
    for name in sorted(of):
        query = query.where(events.c[name] == bindparam(f"of_{name}"))
    return query.limit(bindparam("most"))


def _event(row: Row[Any]) -> EventRecord:
    return EventRecord(row.id, row.recorded_at, row.kind, row.session_id, row.job_id, row.document)
