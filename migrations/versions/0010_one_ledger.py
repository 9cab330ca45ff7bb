"""One ledger for sessions of every kind: the ballbar's takes the lines of the tracker's sessions.

No record that is there is changed. What an older program kept of a tracker session in several tables comes
as further lines, in the order of its times, so that the session can be taken up from them.
"""

import json
from collections.abc import Iterator
from typing import Any, NamedTuple

from alembic import op

from truepose.storage.connection.plain import plain
from truepose.storage.integrity.chain import link
from truepose.storage.migrations.append_only import delete_protected, protect, unprotect
from truepose.storage.migrations.chain import chain_anew, chained_tables
from truepose.storage.migrations.columns import on_sqlite

revision = "0010"
down_revision = "0009"
branch_labels = None
depends_on = None

_OF_TRACKER = "SELECT id FROM sessions WHERE role <> 'ballbar'"
# Of two records of one millisecond the kind decides, by the alphabet: a state, then what was read in it.
_RECORDS = """
SELECT session_id, recorded_at, 'entered' AS kind, id, NULL AS time_s, state AS told, reason AS text, person
  FROM session_states WHERE state <> 'planned'
UNION ALL SELECT session_id, recorded_at, 'identified', id, NULL, NULL, document, NULL
  FROM events WHERE kind = 'session.identity'
UNION ALL SELECT session_id, recorded_at, 'read', id, time_s,
  CASE WHEN config IS NOT NULL THEN 'stop-' || config
       WHEN json_extract(document, '$.phase') = 'reference' THEN 'fixed-nests' ELSE 'world-frame' END,
  NULL, NULL FROM readings
UNION ALL SELECT session_id, recorded_at, 'registered', id, NULL, NULL, document, NULL FROM registrations
UNION ALL SELECT session_id, recorded_at, 'skipped', id, json_extract(document, '$.time_s'),
  'stop-' || json_extract(document, '$.config'), json_extract(document, '$.reason'), NULL FROM skipped_stops
UNION ALL SELECT session_id, recorded_at, 'spoken', id, NULL, NULL, text, NULL FROM notes
"""
_OF_SESSIONS = f"SELECT * FROM ({_RECORDS}) WHERE session_id IN ({_OF_TRACKER}) ORDER BY 1, 2, 3, 4"
_FIRST_TIMES = "SELECT session_id, min(time_s) FROM readings GROUP BY session_id"
_INSERT = """
INSERT INTO session_entries (recorded_at, session_id, step_id, kind, document, reading_id)
VALUES (?, ?, ?, ?, ?, ?)
"""


class _Found(NamedTuple):
    """A record of a tracker session, as an older program kept it."""

    session_id: int
    recorded_at: str
    kind: str
    number: int
    time_s: float | None  # cell clock
    told: str | None  # state or step
    text: str | None
    person: str | None


def upgrade() -> None:
    """Rename the ledger, and take up what is known of tracker sessions."""
    _rename("ballbar_entries", "session_entries")
    whole = "INTEGER" if on_sqlite() else "BIGINT"
    op.execute(f"ALTER TABLE session_entries ADD COLUMN reading_id {whole} REFERENCES readings (id)")
    _index("session_entries")
    if on_sqlite():  # no server has records of an older program
        connection = plain(op.get_bind())
        for line in _lines(connection):
            added = connection.execute(_INSERT, line)
            link(connection, "session_entries", added.lastrowid)


def downgrade() -> None:
    """Give back the ballbar's ledger, whose chain begins anew with all others."""
    delete_protected("session_entries", f"session_id IN ({_OF_TRACKER})")
    op.execute("DROP INDEX ix_session_entries_session_id")
    op.execute("DROP INDEX ix_session_entries_kind")
    op.execute("ALTER TABLE session_entries DROP COLUMN reading_id")
    _rename("session_entries", "ballbar_entries")
    op.create_index("ix_ballbar_entries_session_id", "ballbar_entries", ["session_id", "id"])
    op.create_index("ix_ballbar_entries_kind", "ballbar_entries", ["session_id", "kind", "step_id"])
    chain_anew((chained_tables() - {"session_entries"}) | {"ballbar_entries"})


def _rename(old: str, new: str) -> None:
    unprotect(old)
    op.rename_table(old, new)
    protect(new)


def _index(table: str) -> None:
    op.execute("DROP INDEX ix_ballbar_entries_session_id")
    op.execute("DROP INDEX ix_ballbar_entries_kind")
    op.create_index(f"ix_{table}_session_id", table, ["session_id", "id"])
    op.create_index(f"ix_{table}_kind", table, ["session_id", "kind", "step_id"])


def _lines(connection: Any) -> Iterator[tuple[Any, ...]]:
    """Yield the columns of each line, oldest first; a record without a time has that of the one before."""
    times: dict[int, float] = dict(connection.execute(_FIRST_TIMES).fetchall())
    for row in connection.execute(_OF_SESSIONS):
        found = _Found(*row)
        if found.time_s is not None:
            times[found.session_id] = found.time_s
        step, kind, said = _said(found)
        document = {"step_id": step, "kind": kind, "time_s": times.get(found.session_id, 0.0), **said}
        reading = found.number if found.kind == "read" else None
        yield found.recorded_at, found.session_id, step, kind, json.dumps(document), reading


def _said(found: _Found) -> tuple[str, str, dict[str, Any]]:
    """Return step, kind and fields of the line that says what a record says."""
    text, told = found.text or "", found.told or ""
    match found.kind:
        case "entered":
            by = {} if found.person is None else {"person": found.person}
            return "", "control", {"entered": told, "text": text, **by}
        case "identified":
            return "", "control", {"identity": json.loads(text)}
        case "registered":
            return "world-frame", "computed", {"registration": json.loads(text)}
        case "skipped":
            return told, "skipped", {"text": text}
        case "read":
            return told, "measured" if told.startswith("stop-") else "read", {}
        case _:
            return "", "noted", {"text": text}
