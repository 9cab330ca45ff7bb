"""What sessions were closed as: once each, by whom, on which certificates."""

from typing import Any

from sqlalchemy import Connection, Row, select

from truepose.domain.cell.certificates import Closing, JudgedPaper
from truepose.storage.database import Database
from truepose.storage.documents import from_document, to_document
from truepose.storage.errors import ConflictError
from truepose.storage.events import add_event
from truepose.storage.rows import add_row
from truepose.storage.tables import closings


class ClosingRepository:
    """All queries about closings."""

    def __init__(self, database: Database) -> None:
        self._database = database

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
    add_row(
        connection,
        closings,
        session_id=closing.session_id,
        closed_as=closing.closed_as,
        person=closing.person,
        reason=closing.reason,
        document=to_document(closing.certificates),
    )
    told = {"closed_as": closing.closed_as, "person": closing.person, "reason": closing.reason}
    add_event(connection, "session.closed", told, session_id=closing.session_id)
    return _closing(connection.execute(select(closings).order_by(closings.c.id.desc()).limit(1)).one())


def _found(connection: Connection, session_id: int) -> Closing | None:
    row = connection.execute(select(closings).where(closings.c.session_id == session_id)).one_or_none()
    return None if row is None else _closing(row)


def _closing(row: Row[Any]) -> Closing:
    certificates = tuple(from_document(JudgedPaper, one) for one in row.document)
    return Closing(row.session_id, row.closed_as, row.person, row.reason, certificates, row.recorded_at)
