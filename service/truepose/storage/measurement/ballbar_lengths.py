"""Lengths of a ballbar on disk: each stands in the line of the ledger that tells of it, as a document.

So does whatever else a line says. Only readings of a tracker have rows of their own (`tracker_readings`), to
which the line that tells of one refers.
"""

from dataclasses import replace
from typing import Any, Final

from sqlalchemy import Connection

from truepose.domain.measurement.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.measurement.session import SessionState
from truepose.storage.documents import from_document, to_document
from truepose.storage.events import add_event
from truepose.storage.rows import add_row
from truepose.storage.tables import session_entries

_RESTARTED_BEFORE: Final = "The service was started anew."


def add_line(
    connection: Connection, session_id: int, entry: LedgerEntry, document: Any, reading_id: int | None = None
) -> int:
    """Append a line inside the caller's transaction and return its number; its length is in `document`."""
    return add_row(
        connection,
        session_entries,
        session_id=session_id,
        step_id=entry.step_id,
        kind=entry.kind.value,
        key=entry.key,
        document=document,
        reading_id=reading_id,
    )


def tell_line(connection: Connection, session_id: int, entry: LedgerEntry, number: int) -> None:
    """Tell clients of a line of a ballbar session; those of other sessions are told what they bring."""
    told = {"entry": number, "step_id": entry.step_id, "kind": entry.kind.value, "text": entry.told}
    add_event(connection, "session.entry", told, session_id=session_id)


def line_document(entry: LedgerEntry) -> dict[str, Any]:
    """Return what is kept of a line: its length and all else that it says, without a tracker's reading."""
    told = to_document(replace(entry, point=None, fixed_nest=None))
    return {name: value for name, value in told.items() if value not in (None, [], "") or name == "step_id"}


def line_of(document: Any) -> LedgerEntry:
    """Return a line as it is written today: before, the text of a CONTROL said what it means."""
    entry = from_document(LedgerEntry, document)
    if entry.kind is not EntryKind.CONTROL or entry.entered is not None or entry.control is not None:
        return entry
    state, _, reason = entry.text.partition(": ")
    if state in set(SessionState):
        restarted = Control.RESTARTED if reason.startswith(_RESTARTED_BEFORE) else None
        return replace(entry, entered=SessionState(state), control=restarted, text=reason)
    if entry.text in set(Control):
        return replace(entry, control=Control(entry.text), text="")
    return entry
