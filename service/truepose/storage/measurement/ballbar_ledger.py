"""The ledger of ballbar sessions: appended when something happened; it says where a session stands."""

from dataclasses import replace
from typing import Any

from sqlalchemy import Connection, Row, func, select

from truepose.domain.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.session import SessionState
from truepose.storage.database import Database
from truepose.storage.documents import from_document, to_document
from truepose.storage.errors import KeyReusedError
from truepose.storage.events import add_event
from truepose.storage.measurement.sessions import add_state
from truepose.storage.records import ActAnswer, LedgerRecord, Page, RequestKey
from truepose.storage.rows import add_row
from truepose.storage.tables import ballbar_answers, ballbar_entries

_ALL = Page(limit=-1)  # SQLite: a negative limit is none
_RESTARTED_BEFORE = "The service was started anew."


class BallbarLedger:
    """All queries about what happened in ballbar sessions."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def append(self, session_id: int, entry: LedgerEntry) -> int:
        """Keep an entry and return its number once it is on disk.

        An entry whose key the session has already changes nothing; the earlier one's number comes back.
        """
        document = to_document(entry)  # outside the transaction: a pre-calibration is long
        return await self._database.write(lambda c: _append(c, session_id, entry, document))

    async def writable(self) -> None:
        """Return once entries are taken again, after one was refused."""
        await self._database.writable()

    async def page(self, session_id: int, page: Page = _ALL) -> list[LedgerRecord]:
        """Return the entries of a session, oldest first."""
        table = ballbar_entries
        query = (
            select(table)
            .where(table.c.session_id == session_id, table.c.id > page.after)
            .order_by(table.c.id)
            .limit(page.limit)
        )
        return await self._database.read(lambda c: [_record(row) for row in c.execute(query)])

    async def newest(self, session_id: int) -> int | None:
        """Return the number of the newest entry of a session; None before the first."""
        query = select(func.max(ballbar_entries.c.id)).where(ballbar_entries.c.session_id == session_id)
        return await self._database.read(lambda c: c.scalar(query))

    async def entry_with(self, session_id: int, key: str) -> LedgerRecord | None:
        """Return the entry that a request with this key caused; None where none did."""
        table = ballbar_entries
        query = select(table).where(table.c.session_id == session_id, table.c.key == key)
        row = await self._database.read(lambda c: c.execute(query).one_or_none())
        return None if row is None else _record(row)

    async def keep_answer(self, session_id: int, key: RequestKey, answer: ActAnswer) -> None:
        """Keep what was answered, before it is sent: the same key gets the same answer."""
        await self._database.write(lambda c: _keep_answer(c, session_id, key, answer))

    async def answer_to(self, session_id: int, key: RequestKey) -> ActAnswer | None:
        """Return what a request with this key was answered; raises KeyReusedError for another request's."""
        table = ballbar_answers
        query = select(table).where(table.c.session_id == session_id, table.c.key == key.key)
        row = await self._database.read(lambda c: c.execute(query).one_or_none())
        if row is None:
            return None
        if row.fingerprint != key.fingerprint:
            raise KeyReusedError(
                f"The Idempotency-Key '{key.key}' was used for another act; take a new key for a new act."
            )
        return ActAnswer(row.sentence, row.entry_id)


def _append(
    connection: Connection,
    session_id: int,
    entry: LedgerEntry,
    document: Any,
) -> int:
    known = None if entry.key is None else _number_of(connection, session_id, entry.key)
    if known is not None:
        return known
    number = add_row(
        connection,
        ballbar_entries,
        session_id=session_id,
        step_id=entry.step_id,
        kind=entry.kind.value,
        key=entry.key,
        document=document,
    )
    told = {"entry": number, "step_id": entry.step_id, "kind": entry.kind.value, "text": entry.told}
    add_event(connection, "session.entry", told, session_id=session_id)
    if entry.entered is not None:
        add_state(connection, session_id, entry.entered, entry.text, entry.person)
    return number


def _number_of(connection: Connection, session_id: int, key: str) -> int | None:
    table = ballbar_entries
    return connection.scalar(select(table.c.id).where(table.c.session_id == session_id, table.c.key == key))


def _keep_answer(connection: Connection, session_id: int, key: RequestKey, answer: ActAnswer) -> None:
    add_row(
        connection,
        ballbar_answers,
        session_id=session_id,
        entry_id=answer.entry,
        key=key.key,
        fingerprint=key.fingerprint,
        sentence=answer.sentence,
    )


def _record(row: Row[Any]) -> LedgerRecord:
    return LedgerRecord(row.id, row.recorded_at, _as_typed(from_document(LedgerEntry, row.document)))


def _as_typed(entry: LedgerEntry) -> LedgerEntry:
    """Return a line as it is written today: before, the text of a CONTROL said what it means."""
    if entry.kind is not EntryKind.CONTROL or entry.entered is not None or entry.control is not None:
        return entry
    state, _, reason = entry.text.partition(": ")
    if state in set(SessionState):
        restarted = Control.RESTARTED if reason.startswith(_RESTARTED_BEFORE) else None
        return replace(entry, entered=SessionState(state), control=restarted, text=reason)
    if entry.text in set(Control):
        return replace(entry, control=Control(entry.text), text="")
    return entry
