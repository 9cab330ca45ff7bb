"""Sessions, their states, readings, skipped stops, registrations and notes."""

from typing import Any

import sqlalchemy as sa
from alembic import op

from truepose.storage.column_types import DOCUMENT, REAL, TEXT, WHOLE
from truepose.storage.migrations.append_only import drop_protected, protect
from truepose.storage.migrations.columns import number, recorded, reference

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None

_OF_A_SESSION = ("session_states", "readings", "skipped_stops", "registrations", "notes")


def upgrade() -> None:
    """Make the tables of the measurement."""
    op.create_table(
        "sessions",
        number(),
        recorded(),
        sa.Column("name", TEXT, nullable=False),
        sa.Column("role", TEXT, nullable=False),
        sa.Column("setup", DOCUMENT, nullable=False),
        sa.Column("plan", DOCUMENT, nullable=False),
        sqlite_autoincrement=True,
    )
    protect("sessions")
    _of_a_session(
        "session_states",
        sa.Column("state", TEXT, nullable=False),
        sa.Column("reason", TEXT, nullable=False),
        sa.Column("person", TEXT, nullable=True),
    )
    _of_a_session(
        "readings",
        sa.Column("kind", TEXT, nullable=False),
        sa.Column("config", WHOLE, nullable=True),
        sa.Column("nest", WHOLE, nullable=False),
        sa.Column("time_s", REAL, nullable=False),
        sa.Column("supersedes", WHOLE, sa.ForeignKey("readings.id"), nullable=True, unique=True),
        sa.Column("document", DOCUMENT, nullable=False),
    )
    _of_a_session("skipped_stops", sa.Column("document", DOCUMENT, nullable=False))
    _of_a_session("registrations", sa.Column("document", DOCUMENT, nullable=False))
    _of_a_session("notes", sa.Column("text", TEXT, nullable=False))


def _of_a_session(table: str, *columns: "sa.Column[Any]") -> None:
    op.create_table(
        table, number(), recorded(), reference("session_id", "sessions"), *columns, sqlite_autoincrement=True
    )
    op.create_index(f"ix_{table}_session_id", table, ["session_id", "id"])
    protect(table)


def downgrade() -> None:
    """Drop the tables of the measurement, with everything measured."""
    for table in reversed(_OF_A_SESSION):
        drop_protected(table)
    drop_protected("sessions")
