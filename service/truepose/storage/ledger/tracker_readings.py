"""Readings of a tracker: appended as they come, superseded when a stop is read again, never changed.

One of a stop that a person left out, or wanted once more, counts no more from that line of the ledger on.

Lengths of a ballbar are in `entries`.
"""

from collections.abc import Mapping
from typing import Any, Final, TypeVar

from sqlalchemy import ColumnElement, Connection, Row, Select, and_, bindparam, exists, or_, select

from truepose.domain.ledger import EntryKind
from truepose.domain.session import FixedNestTaken, PointTaken
from truepose.storage.database import Database
from truepose.storage.documents import from_document, to_document
from truepose.storage.queries import NumberedRecords, Part, Repository
from truepose.storage.record_insertion import add_event, add_row
from truepose.storage.records import Page, ReadingKind, ReadingRecord
from truepose.storage.rows import from_row
from truepose.storage.tables import readings, session_entries

Taken = TypeVar("Taken", PointTaken, FixedNestTaken)
_KINDS: Final[Mapping[type, ReadingKind]] = {PointTaken: "point", FixedNestTaken: "fixed_nest"}
_TYPES: Final = {kind: taken for taken, kind in _KINDS.items()}


def add_point(connection: Connection, session_id: int, point: PointTaken) -> int:
    """Append a reading of a tool nest inside the caller's transaction and return its number.

    An earlier one of the same configuration and nest is superseded.
    """
    # Found in the transaction that adds the new one: two readings of one configuration can never supersede
    # the same third, which the unique column refuses as well.
    earlier = _current(connection, session_id, point.config, point.nest)
    return _add(connection, session_id, point, point.config, point.nest, earlier)


def add_fixed_nest(connection: Connection, session_id: int, reading: FixedNestTaken) -> int:
    """Append a reading of a fixed nest; each of them counts, none supersedes another."""
    return _add(connection, session_id, reading, None, reading.fixed_nest, None)


class ReadingRepository(Repository):
    """All queries about readings; they are written with the line of the ledger that brings them."""

    def __init__(self, database: Database) -> None:
        super().__init__(database)
        self._every = NumberedRecords(database, "reading", readings, _records, _record)

    async def get(self, reading_id: int) -> ReadingRecord:
        """Return a reading; raises NotFoundError."""
        return await self._every.get(reading_id)

    async def page(
        self,
        page: Page,
        *,
        session_id: int | None = None,
        kind: ReadingKind | None = None,
        superseded: bool = True,
    ) -> Part[ReadingRecord]:
        """Return readings, oldest first; with `superseded` false only those that count."""
        wanted = [
            *([] if session_id is None else [readings.c.session_id == session_id]),
            *([] if kind is None else [readings.c.kind == kind]),
            *([] if superseded else [_COUNTS, readings.c.id.not_in(_revoked(session_id))]),
        ]
        return await self._every.page(page, *wanted)

    async def points(self, session_id: int) -> list[PointTaken]:
        """Return every reading of a tool nest that counts, in the order they were taken."""
        return await self._taken(PointTaken, session_id, _COUNTS, readings.c.id.not_in(_revoked(session_id)))

    async def fixed_nests(self, session_id: int) -> list[FixedNestTaken]:
        """Return every reading of a fixed nest, in the order they were taken."""
        return await self._taken(FixedNestTaken, session_id)

    async def _taken(
        self, kind: type[Taken], session_id: int, *conditions: ColumnElement[bool]
    ) -> list[Taken]:
        wanted = (readings.c.session_id == session_id, readings.c.kind == _KINDS[kind], *conditions)
        query = select(readings.c.document).where(*wanted).order_by(readings.c.id)
        return await self._each(query, lambda row: from_document(kind, row.document))


_SUCCESSOR = readings.alias("successor")
# Asked for beside a reading, not joined to it: a list of a million is counted without it.
_SUPERSEDED_BY = select(_SUCCESSOR.c.id).where(_SUCCESSOR.c.supersedes == readings.c.id).scalar_subquery()
# Asked at every reading: made once, it takes a fifth of the time.
_CURRENT = (
    select(readings.c.id)
    .where(readings.c.session_id == bindparam("of_session"))
    .where(readings.c.config == bindparam("at_config"), readings.c.nest == bindparam("of_nest"))
    .where(readings.c.kind == "point")
    .order_by(readings.c.id.desc())
    .limit(1)
)
_COUNTS = ~exists().where(_SUCCESSOR.c.supersedes == readings.c.id)


def _revoked(session_id: int | None) -> Select[Any]:
    """Select readings of stops that a person left out for good, or wanted again after they were read."""
    brought, revised, later = (session_entries.alias() for _ in range(3))
    # Lines are never changed, so what counts is what was said last: left out, wanted again, or left out once
    # more.
    wanted_again = exists().where(
        later.c.session_id == revised.c.session_id,
        later.c.kind == EntryKind.REOPENED.value,
        later.c.step_id == revised.c.step_id,
        later.c.id > revised.c.id,
    )
    # With a key a person skipped it; without one the session did, after a reading that failed, and then there
    # is nothing to revoke.
    left_out = and_(revised.c.kind == EntryKind.SKIPPED.value, revised.c.key.is_not(None), ~wanted_again)
    # Readings that come after the wish count again.
    reopened = and_(revised.c.kind == EntryKind.REOPENED.value, revised.c.id > brought.c.id)
    found = select(brought.c.reading_id).where(
        brought.c.session_id == revised.c.session_id,
        brought.c.kind == EntryKind.MEASURED.value,
        brought.c.step_id == revised.c.step_id,
        brought.c.reading_id.is_not(None),
        revised.c.kind.in_((EntryKind.SKIPPED.value, EntryKind.REOPENED.value)),
        or_(left_out, reopened),
    )
    return found if session_id is None else found.where(revised.c.session_id == session_id)


def _records() -> Select[Any]:
    return select(readings, _SUPERSEDED_BY.label("superseded_by"))


def _current(connection: Connection, session_id: int, config: int, nest: int) -> int | None:
    return connection.scalar(_CURRENT, {"of_session": session_id, "at_config": config, "of_nest": nest})


def _add(
    connection: Connection,
    session_id: int,
    reading: PointTaken | FixedNestTaken,
    config: int | None,
    nest: int,
    supersedes: int | None,
) -> int:
    number = add_row(
        connection,
        readings,
        session_id=session_id,
        kind=_KINDS[type(reading)],
        config=config,
        nest=nest,
        time_s=reading.time_s,
        supersedes=supersedes,
        document=to_document(reading),
    )
    add_event(connection, "session.reading", {}, session_id=session_id, reading_id=number)
    return number


def _record(row: Row[Any]) -> ReadingRecord:
    taken: PointTaken | FixedNestTaken = from_document(_TYPES[row.kind], row.document)
    return from_row(ReadingRecord, row, reading=taken)
