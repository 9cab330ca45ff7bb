"""Configurations that a person added to the plan of a session."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.column_types import DOCUMENT, TEXT
from truepose.storage.migrations.append_only import drop_protected, protect
from truepose.storage.migrations.columns import number, recorded, reference

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the table of what was added."""
    op.create_table(
        "added_stops",
        number(),
        recorded(),
        reference("session_id", "sessions"),
        reference("diagnosis_id", "diagnoses", nullable=True),
        sa.Column("person", TEXT, nullable=False),
        sa.Column("document", DOCUMENT, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_added_stops_session_id", "added_stops", ["session_id", "id"])
    protect("added_stops")


def downgrade() -> None:
    """Drop what was added; the readings taken there stay."""
    drop_protected("added_stops")
