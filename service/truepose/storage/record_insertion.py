"""How a record is added: its row with its link in the chain, its event, once for each Idempotency-Key.

An event is written in the transaction of the record that it tells of: neither exists without the other.
"""

import functools
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from functools import cache
from typing import Any

from sqlalchemy import Connection, Row, Select, Table, bindparam, insert, select
from sqlalchemy.sql.dml import ReturningInsert

from truepose.storage.engine.dialects import as_kept, newest_number
from truepose.storage.engine.raw_connection import plain
from truepose.storage.errors import KeyReusedError
from truepose.storage.integrity.hash_chain import linking
from truepose.storage.queries import Repository
from truepose.storage.records import EventRecord, Page, RequestKey
from truepose.storage.tables import events, readings, request_keys


def add_row(connection: Connection, table: Table, **values: Any) -> int:
    """Append a record to `table`, stamped with the time of day, and return its number.

    Its link waits until the transaction is about to be committed.
    """
    # RETURNING gives back what the engine keeps, which is what the hash is over: a whole number in a column
    # of reals comes back as a real.
    row = connection.execute(_adding(table), {"recorded_at": _stamp(), **values}).one()
    return _link(connection, table, row)


def add_rows(connection: Connection, table: Table, rows: Sequence[Mapping[str, Any]]) -> list[int]:
    """Append records with the same columns to `table` and return their numbers."""
    if not rows:
        return []
    # Numbers are given here, as one statement adds all rows: nobody else writes, so the newest one stays the
    # newest.
    newest, stamp = connection.scalar(_newest(table)) or 0, _stamp()
    numbered = [{"id": number, "recorded_at": stamp, **row} for number, row in enumerate(rows, newest + 1)]
    kept = connection.execute(_adding(table), numbered).all()
    # RETURNING promises no order, and links have that of the records.
    return [_link(connection, table, row) for row in sorted(kept, key=_number)]


def _stamp() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _number(row: Row[Any]) -> int:
    return int(row.number)


def _link(connection: Connection, table: Table, row: Sequence[Any]) -> int:
    number, *kept = row
    linking(connection).add(plain(connection), table.name, int(number), _names(table), kept)
    return int(number)


@functools.cache
def _newest(table: Table) -> Select[Any]:
    return select(newest_number(table.name))


@functools.cache
def _adding(table: Table) -> ReturningInsert[Any]:
    """Return the statement that adds a record, and gives back its number and every value as it is kept."""
    kept = (as_kept(column).label(f"kept_{column.name}") for column in table.c)
    return insert(table).returning(table.c.id.label("number"), *kept)


@functools.cache
def _names(table: Table) -> tuple[str, ...]:
    return tuple(column.name for column in table.c)


def once(
    connection: Connection, key: RequestKey | None, resource: str, create: Callable[[Connection], int]
) -> int:
    """Return the number that `create` gives, or gave when `key` was first seen; one transaction.

    Raises KeyReusedError where the key came with another request before.
    """
    # Within the transaction that writes: a request that is sent twice at once is two writes of one thread, of
    # which the second finds the first.
    known = None if key is None else answered_number(connection, key, resource)
    if known is not None:
        return known
    number = create(connection)
    if key is not None:
        add_row(
            connection,
            request_keys,
            key=key.key,
            fingerprint=key.fingerprint,
            resource=resource,
            resource_id=number,
        )
    return number


def answered_number(connection: Connection, key: RequestKey, resource: str) -> int | None:
    """Return the number that a request with this key got, None where it is new; raises KeyReusedError."""
    query = select(request_keys).where(request_keys.c.key == key.key)
    known = connection.execute(query).one_or_none()
    if known is None:
        return None
    # A key that comes with another request is a mistake of the client. Answering it with the earlier result
    # would hide that what it asks for was never done.
    if (known.fingerprint, known.resource) != (key.fingerprint, resource):
        raise KeyReusedError(
            f"The Idempotency-Key '{key.key}' was already used for another request; use a new key."
        )
    return int(known.resource_id)


def add_event(
    connection: Connection,
    kind: str,
    document: dict[str, Any],
    *,
    session_id: int | None = None,
    job_id: int | None = None,
    reading_id: int | None = None,
) -> None:
    """Append an event inside the caller's transaction; one of a reading says nothing but that."""
    of = {"session_id": session_id, "job_id": job_id, "reading_id": reading_id}
    add_row(connection, events, kind=kind, document=document, **of)


class EventRepository(Repository):
    """Reads events; they are written by the repositories of what happened."""

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
        return int(await self._value(query) or 0)


@cache  # asked at every commit by everybody who follows: making it takes longer than its answer
def _following(of: frozenset[str]) -> Select[Any]:
    """Return the query for events that follow `after`, of one session or job where those are named."""
    reading = (
        readings.c.kind.label("reading_kind"),
        readings.c.supersedes,
        readings.c.document.label("reading"),
    )
    told = events.outerjoin(readings, readings.c.id == events.c.reading_id)
    query = select(events, *reading).select_from(told).where(events.c.id > bindparam("after"))
    query = query.order_by(events.c.id)
    for name in sorted(of):
        query = query.where(events.c[name] == bindparam(f"of_{name}"))
    return query.limit(bindparam("most"))


def _event(row: Row[Any]) -> EventRecord:
    document = row.document
    # The event has no document of its own: a reading is on disk once, and whoever follows gets it with the
    # event (decision 0082).
    if row.reading_id is not None:
        document = {
            "reading_id": row.reading_id,
            "kind": row.reading_kind,
            "supersedes": row.supersedes,
            "reading": row.reading,
        }
    return EventRecord(row.id, row.recorded_at, row.kind, row.session_id, row.job_id, document)
