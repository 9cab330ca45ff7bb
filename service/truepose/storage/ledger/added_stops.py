"""What persons add to a session beside its ledger: further configurations, and what it was closed as."""

from typing import Any

from sqlalchemy import Connection, Row, select

from truepose.domain.cell import Closing, JudgedPaper
from truepose.domain.session import PlannedStop
from truepose.storage.documents import from_document, to_document
from truepose.storage.errors import ConflictError
from truepose.storage.queries import Repository
from truepose.storage.record_insertion import add_event, add_row, answered_number, once
from truepose.storage.records import AddedStops, AdditionRecord, RequestKey
from truepose.storage.rows import from_row, to_row
from truepose.storage.tables import added_stops, closings

_RESOURCE = "added stops"


class AddedStopsRepository(Repository):
    """All queries about what was added to plans."""

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
        return await self._value(asked)


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
    return from_row(AddedStops, row, stops=_stops(row.document))


def _stops(document: list[Any]) -> tuple[PlannedStop, ...]:
    return tuple(from_document(PlannedStop, entry) for entry in document)


def _add(connection: Connection, added: AddedStops) -> int:
    document = to_document(added.stops)
    number = add_row(connection, added_stops, **to_row(added, added_stops), document=document)
    told = {"person": added.person, "stops": document, "diagnosis_id": added.diagnosis_id}
    add_event(connection, "session.stops_added", told, session_id=added.session_id)
    return number


def _answered(connection: Connection, key: RequestKey) -> AddedStops | None:
    number = answered_number(connection, key, _RESOURCE)
    if number is None:
        return None
    row = connection.execute(select(added_stops).where(added_stops.c.id == number)).one()
    return _addition(row)


class ClosingRepository(Repository):
    """All queries about closings."""

    async def keep(self, closing: Closing) -> Closing:
        """Store a closing and return it with its time; raises ConflictError where there is one."""
        return await self._database.write(lambda connection: _keep(connection, closing))

    async def of_session(self, session_id: int) -> Closing | None:
        """Return what a session was closed as; None where it was not."""
        return await self._database.read(lambda connection: _found(connection, session_id))


def _keep(connection: Connection, closing: Closing) -> Closing:
    before = _found(connection, closing.session_id)
    if before is not None:
        raise ConflictError(f"Session {closing.session_id} was closed as {before.closed_as} already.")
    document = to_document(closing.certificates)
    add_row(connection, closings, **to_row(closing, closings), document=document)
    told = {"closed_as": closing.closed_as, "person": closing.person, "reason": closing.reason}
    add_event(connection, "session.closed", told, session_id=closing.session_id)
    return _closing(connection.execute(select(closings).order_by(closings.c.id.desc()).limit(1)).one())


def _found(connection: Connection, session_id: int) -> Closing | None:
    row = connection.execute(select(closings).where(closings.c.session_id == session_id)).one_or_none()
    return None if row is None else _closing(row)


def _closing(row: Row[Any]) -> Closing:
    certificates = tuple(from_document(JudgedPaper, one) for one in row.document)
    return from_row(Closing, row, certificates=certificates, closed_at=row.recorded_at)
