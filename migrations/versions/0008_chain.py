"""A chain of hashes over all records, those that are there included."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.integrity.chain import link_all
from truepose.storage.migrations.append_only import drop_protected, protect
from truepose.storage.migrations.columns import number

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
        sa.Column("stream", sa.Integer, nullable=False),
        sa.Column("record", sa.Text, nullable=False),
        sa.Column("record_id", sa.Integer, nullable=False),
        sa.Column("hash", sa.LargeBinary, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_links_stream", "links", ["stream", "id"])
    link_all(op.get_bind().connection.cursor(), _RECORDS)
    # A number that was given and is gone tells of a record taken out; those of an older schema are no such.
    for table in _RECORDS[:-1]:
        newest = f"SELECT coalesce(max(id), 0) FROM {table}"
        op.execute(f"UPDATE sqlite_sequence SET seq = ({newest}) WHERE name = '{table}'")
    protect("links")


def downgrade() -> None:
    """Do without."""
    drop_protected("links")
