"""Configurations that persons added to plans of sessions; the plans themselves stay as they were stored."""

from typing import Any

from sqlalchemy import Connection, Row, select

from truepose.domain.measurement.session import PlannedStop
from truepose.storage.database import Database
from truepose.storage.documents import from_document, to_document
from truepose.storage.events import add_event
from truepose.storage.records import AddedStops, AdditionRecord, RequestKey
from truepose.storage.request_keys import answered, once
from truepose.storage.rows import add_row
from truepose.storage.tables import added_stops

_RESOURCE = "added stops"


class AddedStopsRepository:
    """All queries about what was added to plans."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def add(self, added: AddedStops, key: RequestKey | None = None) -> int:
        """Keep what was added and return its number."""
        return await self._database.write(lambda c: once(c, key, _RESOURCE, lambda inner: _add(inner, added)))

    async def answered(self, key: RequestKey) -> AddedStops | None:
        """Return what a request with this key added before; raises KeyReusedError."""
        return await self._database.read(lambda c: _answered(c, key))

    async def diagnosis_to_repeat(self, session_id: int) -> int | None:
        """Return the diagnosis that somebody last wanted to be run again after a session."""
        table = added_stops
        query = select(table.c.diagnosis_id).where(table.c.session_id == session_id)
        asked = query.where(table.c.diagnosis_id.is_not(None)).order_by(table.c.id.desc()).limit(1)
        return await self._database.read(lambda c: c.scalar(asked))


def stops_added_to(connection: Connection, session_id: int) -> tuple[PlannedStop, ...]:
    """Return every stop that was added to a session, in the order of adding."""
    table = added_stops
    query = select(table.c.document).where(table.c.session_id == session_id).order_by(table.c.id)
    return tuple(stop for document in connection.scalars(query) for stop in _stops(document))


def additions_to(connection: Connection, session_id: int) -> list[AdditionRecord]:
    """Return who added what to a session, in the order of adding."""
    table = added_stops
    query = select(table).where(table.c.session_id == session_id).order_by(table.c.id)
    return [AdditionRecord(row.recorded_at, _addition(row)) for row in connection.execute(query)]


def _addition(row: Row[Any]) -> AddedStops:
    return AddedStops(row.session_id, row.person, _stops(row.document), row.diagnosis_id)


def _stops(document: list[Any]) -> tuple[PlannedStop, ...]:
    return tuple(from_document(PlannedStop, entry) for entry in document)


def _add(connection: Connection, added: AddedStops) -> int:
    document = to_document(added.stops)
    number = add_row(
        connection,
        added_stops,
        session_id=added.session_id,
        person=added.person,
        diagnosis_id=added.diagnosis_id,
        document=document,
    )
    told = {"person": added.person, "stops": document, "diagnosis_id": added.diagnosis_id}
    add_event(connection, "session.stops_added", told, session_id=added.session_id)
    return number


def _answered(connection: Connection, key: RequestKey) -> AddedStops | None:
    number = answered(connection, key, _RESOURCE)
    if number is None:
        return None
    row = connection.execute(select(added_stops).where(added_stops.c.id == number)).one()
    return _addition(row)
