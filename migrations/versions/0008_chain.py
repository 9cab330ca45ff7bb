"""A chain of hashes over all records, those that are there included."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.column_types import BYTES, TEXT, WHOLE
from truepose.storage.connection.plain import plain
from truepose.storage.integrity.chain import link_all
from truepose.storage.migrations.append_only import drop_protected, protect
from truepose.storage.migrations.columns import number, on_sqlite

revision = "0008"
down_revision = "0007"
branch_labels = None
depends_on = None

_RECORDS = (
    "sessions",
    "session_states",
    "readings",
    "skipped_stops",
    "registrations",
    "notes",
    "campaigns",
    "jobs",
    "job_states",
    "identifications",
    "diagnoses",
    "models",
    "validations",
    "added_stops",
    "ballbar_entries",
    "ballbar_answers",
    "events",
    "request_keys",
)


def upgrade() -> None:
    """Make the table of links and link what is there."""
    op.create_table(
        "links",
        number(),
        sa.Column("stream", WHOLE, nullable=False),
        sa.Column("record", TEXT, nullable=False),
        sa.Column("record_id", WHOLE, nullable=False),
        sa.Column("hash", BYTES, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_links_stream", "links", ["stream", "id"])
    link_all(plain(op.get_bind()), _RECORDS)
    # A number that was given and is gone tells of a record taken out; those of an older schema are no such.
    for table in _RECORDS[:-1] if on_sqlite() else ():
        newest = f"SELECT coalesce(max(id), 0) FROM {table}"
        op.execute(f"UPDATE sqlite_sequence SET seq = ({newest}) WHERE name = '{table}'")
    protect("links")


def downgrade() -> None:
    """Do without."""
    drop_protected("links")
