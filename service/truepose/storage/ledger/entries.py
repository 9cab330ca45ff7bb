"""The ledger of sessions: readings, prompts, answers and states, appended as they happen.

It says where a session stands. A line is kept as a document with all that it says, the length of a ballbar
too. Only readings of a tracker have rows of their own (`tracker_readings`), to which the line that tells of
one refers.
"""

from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import Any, Final

from sqlalchemy import Connection, Row, Select, bindparam, func, select

from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.session import (
    FixedNestTaken,
    PointTaken,
    StopSkipped,
    config_of,
)
from truepose.storage.documents import from_document, to_document
from truepose.storage.errors import KeyReusedError
from truepose.storage.ledger.sessions import (
    IDENTITY,
    PROGRESS,
    add_note,
    add_state,
)
from truepose.storage.ledger.tracker_readings import add_fixed_nest, add_point
from truepose.storage.queries import Part, Repository, part_of
from truepose.storage.record_insertion import add_event, add_row
from truepose.storage.records import CommandAnswer, LedgerRecord, Page, RequestKey
from truepose.storage.results.campaigns import in_cell
from truepose.storage.rows import to_row
from truepose.storage.tables import act_answers, readings, session_entries, sessions


def add_line(
    connection: Connection, session_id: int, entry: LedgerEntry, document: Any, reading_id: int | None = None
) -> int:
    """Append a line inside the caller's transaction and return its number; its length is in `document`."""
    about = {"session_id": session_id, "document": document, "reading_id": reading_id}
    return add_row(connection, session_entries, **to_row(entry, session_entries), **about)


def tell_line(connection: Connection, session_id: int, entry: LedgerEntry, number: int) -> None:
    """Tell clients of a line of a ballbar session; those of other sessions are told what they bring."""
    told = {
        "entry": number,
        "step_id": entry.step_id,
        "kind": entry.kind.value,
        "text": to_document(entry.told),
    }
    add_event(connection, "session.entry", told, session_id=session_id)


def line_document(entry: LedgerEntry) -> dict[str, Any]:
    """Return what is kept of a line: its length and all else that it says, without a tracker's reading."""
    # A reading of a tracker is a record of its own, to which the line refers: on disk once (decision 0082).
    told = to_document(replace(entry, point=None, fixed_nest=None))
    # A line has some twenty fields of which few say anything; what is absent takes its default when it is
    # read. `step_id` has none.
    return {name: value for name, value in told.items() if value not in (None, [], "") or name == "step_id"}


# Asked at every line: made once, it takes a fifth of the time.
_ROLE: Final = select(sessions.c.role).where(sessions.c.id == bindparam("session_id"))


class LedgerRepository(Repository):
    """All queries about what happened in sessions."""

    async def append(self, session_id: int, entry: LedgerEntry) -> int:
        """Keep an entry and return its number once it is on disk.

        An entry whose key the session has already changes nothing; the earlier one's number comes back.
        """
        document = line_document(entry)  # outside the transaction: a pre-calibration is long
        return await self._database.write(lambda c: _append(c, session_id, entry, document))

    async def writable(self) -> None:
        """Return once entries are taken again, after one was refused."""
        await self._database.writable()

    async def page(self, session_id: int, page: Page) -> Part[LedgerRecord]:
        """Return some entries of a session, oldest first."""
        query, number = _records_of(session_id), session_entries.c.id
        return await self._database.read(lambda c: part_of(c, query, number, page, _record))

    async def whole(self, session_id: int) -> list[LedgerRecord]:
        """Return all entries of a session, oldest first."""
        query = _records_of(session_id).order_by(session_entries.c.id)
        return await self._each(query, _record)

    async def of_kinds(self, session_id: int, kinds: Collection[EntryKind]) -> list[LedgerRecord]:
        """Return the entries of some kinds, oldest first, but for those that are a tracker's readings."""
        entry = session_entries.c
        query = _records_of(session_id).where(entry.kind.in_(kinds), entry.reading_id.is_(None))
        return await self._each(query.order_by(entry.id), _record)

    async def of_session(self, session_id: int) -> "SessionLedger":
        """Return the ledger of one session, with what is in it so far."""
        return SessionLedger(session_id, self, await self.whole(session_id))

    async def newest(self, session_id: int) -> int | None:
        """Return the number of the newest entry of a session; None before the first."""
        query = select(func.max(session_entries.c.id)).where(session_entries.c.session_id == session_id)
        return await self._value(query)

    async def newest_at(self, *steps: str, simulated: bool) -> LedgerRecord | None:
        """Return the newest entry of these steps in any session of a simulated cell, or of a real one."""
        table = session_entries
        query = _records().join(sessions, sessions.c.id == table.c.session_id)
        query = query.where(table.c.step_id.in_(steps), in_cell(sessions.c.setup, simulated=simulated))
        row = await self._row(query.order_by(table.c.id.desc()).limit(1))
        return None if row is None else _record(row)

    async def entry_with(self, session_id: int, key: str) -> LedgerRecord | None:
        """Return the entry that a request with this key caused; None where none did."""
        table = session_entries
        query = _records().where(table.c.session_id == session_id, table.c.key == key)
        row = await self._row(query)
        return None if row is None else _record(row)

    async def keep_answer(self, session_id: int, key: RequestKey, answer: CommandAnswer) -> None:
        """Keep what was answered, before it is sent: the same key gets the same answer."""
        await self._database.write(lambda c: _keep_answer(c, session_id, key, answer))

    async def answer_to(self, session_id: int, key: RequestKey) -> CommandAnswer | None:
        """Return what a request with this key was answered; raises KeyReusedError for another request's."""
        table = act_answers
        query = select(table).where(table.c.session_id == session_id, table.c.key == key.key)
        row = await self._row(query)
        if row is None:
            return None
        if row.fingerprint != key.fingerprint:
            raise KeyReusedError(
                f"The Idempotency-Key '{key.key}' was already used for another command. Use a new key."
            )
        return CommandAnswer(row.sentence, row.entry_id)


class SessionLedger:
    """The ledger of one session under way, as its runner asks for it; `kept` is of earlier runs."""

    def __init__(self, session_id: int, ledger: LedgerRepository, kept: Sequence[LedgerRecord]) -> None:
        self._session_id = session_id
        self._ledger = ledger
        self.earlier = tuple(record.entry for record in kept)
        self.newest = kept[-1].id if kept else None  # number of the newest entry; None before the first

    async def append(self, entry: LedgerEntry) -> int:
        """Keep an entry and return its number once it is on disk."""
        number = await self._ledger.append(self._session_id, entry)
        # A repeated key returns the number of an earlier line.
        self.newest = max(number, self.newest or 0)
        return number

    async def writable(self) -> None:
        """Return once entries are taken again, after one was refused."""
        await self._ledger.writable()


def _append(
    connection: Connection,
    session_id: int,
    entry: LedgerEntry,
    document: Any,
) -> int:
    # In the writing transaction, so that of two requests with one key the second finds the first, whatever
    # the order of their answers.
    known = None if entry.key is None else _number_of(connection, session_id, entry.key)
    if known is not None:
        return known
    of_ballbar = _role(connection, session_id) == "ballbar"
    # The reading first: the line refers to its number.
    reading_id = None if of_ballbar else _tell(connection, session_id, entry)
    number = add_line(connection, session_id, entry, document, reading_id)
    if of_ballbar:
        tell_line(connection, session_id, entry, number)
    # The state is in the transaction of the line that enters it: after a kill neither is there without the
    # other.
    if entry.entered is not None:
        add_state(connection, session_id, entry.entered, entry.text, entry.person)
    if entry.progress is not None:
        add_event(connection, PROGRESS, to_document(entry.progress), session_id=session_id)
    return number


def _tell(connection: Connection, session_id: int, entry: LedgerEntry) -> int | None:
    """Tell clients of a line of a tracker session, and keep the reading that it brings; return that."""
    config = config_of(entry.step_id) if entry.kind is EntryKind.SKIPPED else None
    if config is not None:
        skipped = StopSkipped(config, entry.time_s, entry.text)
        add_event(connection, "session.stop_skipped", to_document(skipped), session_id=session_id)
    if entry.registration is not None:
        placed = {"rms_mm": entry.registration.rms_mm, "two_face_mm": entry.registration.two_face_mm}
        add_event(connection, "session.registered", placed, session_id=session_id)
    if entry.identity is not None:
        add_event(connection, IDENTITY, to_document(entry.identity), session_id=session_id)
    if entry.kind is EntryKind.NOTED:
        add_note(connection, session_id, entry.text)
    if entry.fixed_nest is not None:
        return add_fixed_nest(connection, session_id, entry.fixed_nest)
    return None if entry.point is None else add_point(connection, session_id, entry.point)


def _role(connection: Connection, session_id: int) -> str | None:
    return connection.scalar(_ROLE, {"session_id": session_id})


def _number_of(connection: Connection, session_id: int, key: str) -> int | None:
    table = session_entries
    return connection.scalar(select(table.c.id).where(table.c.session_id == session_id, table.c.key == key))


def _keep_answer(connection: Connection, session_id: int, key: RequestKey, answer: CommandAnswer) -> None:
    add_row(
        connection,
        act_answers,
        session_id=session_id,
        entry_id=answer.entry,
        key=key.key,
        fingerprint=key.fingerprint,
        sentence=answer.sentence,
    )


def _records() -> Select[Any]:
    # One query for a session's whole ledger: asked one by one, its readings cost as many queries.
    joined = session_entries.outerjoin(readings, readings.c.id == session_entries.c.reading_id)
    read = readings.c.kind.label("reading_kind"), readings.c.document.label("reading")
    return select(session_entries, *read).select_from(joined)


def _records_of(session_id: int) -> Select[Any]:
    return _records().where(session_entries.c.session_id == session_id)


def _record(row: Row[Any]) -> LedgerRecord:
    entry = from_document(LedgerEntry, row.document)
    if row.reading_kind == "point":
        entry = replace(entry, point=from_document(PointTaken, row.reading))
    elif row.reading_kind is not None:
        entry = replace(entry, fixed_nest=from_document(FixedNestTaken, row.reading))
    return LedgerRecord(row.id, row.recorded_at, entry)
