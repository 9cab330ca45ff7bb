"""What happens in a ballbar session, and what was answered to those who asked for it."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.column_types import DOCUMENT, TEXT
from truepose.storage.migrations.append_only import delete_protected, drop_protected, protect
from truepose.storage.migrations.columns import number, recorded, reference

revision = "0006"
down_revision = "0005"
branch_labels = None
depends_on = None
_OF_BALLBAR = "IN (SELECT id FROM sessions WHERE role = 'ballbar')"


def upgrade() -> None:
    """Make the ledger and the table of answers."""
    op.create_table(
        "ballbar_entries",
        number(),
        recorded(),
        reference("session_id", "sessions"),
        sa.Column("step_id", TEXT, nullable=False),
        sa.Column("kind", TEXT, nullable=False),
        sa.Column("key", TEXT, nullable=True),
        sa.Column("document", DOCUMENT, nullable=False),
        sa.UniqueConstraint("session_id", "key", name="uq_ballbar_entries_key"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_ballbar_entries_session_id", "ballbar_entries", ["session_id", "id"])
    op.create_table(
        "ballbar_answers",
        number(),
        recorded(),
        reference("session_id", "sessions"),
        reference("entry_id", "ballbar_entries", nullable=True),
        sa.Column("key", TEXT, nullable=False),
        sa.Column("fingerprint", TEXT, nullable=False),
        sa.Column("sentence", TEXT, nullable=False),
        sa.UniqueConstraint("session_id", "key", name="uq_ballbar_answers_key"),
        sqlite_autoincrement=True,
    )
    for table in ("ballbar_entries", "ballbar_answers"):
        protect(table)


def downgrade() -> None:
    """Drop both, and the sessions that an older program cannot read."""
    drop_protected("ballbar_answers")
    drop_protected("ballbar_entries")
    for table in ("events", "session_states", "notes"):
        delete_protected(table, f"session_id {_OF_BALLBAR}")
    delete_protected("request_keys", f"resource = 'session' AND resource_id {_OF_BALLBAR}")
    delete_protected("sessions", "role = 'ballbar'")
