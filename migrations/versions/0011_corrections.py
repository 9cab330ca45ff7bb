"""Corrected files: what was asked, what became of each target, and the file itself."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.column_types import BYTES, DOCUMENT, TEXT
from truepose.storage.migrations.append_only import delete_protected, drop_protected, protect
from truepose.storage.migrations.chain import chain_anew, chained_tables
from truepose.storage.migrations.columns import number, recorded, reference

revision = "0011"
down_revision = "0010"
branch_labels = None
depends_on = None

_JOBS = "SELECT id FROM jobs WHERE kind = 'correction'"


def upgrade() -> None:
    """Make the table."""
    op.create_table(
        "corrections",
        number(),
        recorded(),
        reference("job_id", "jobs"),
        reference("model_id", "models"),
        sa.Column("name", TEXT, nullable=False),
        sa.Column("original_sha256", TEXT, nullable=False),
        sa.Column("corrected_sha256", TEXT, nullable=False),
        sa.Column("asked", DOCUMENT, nullable=False),
        sa.Column("document", DOCUMENT, nullable=False),
        sa.Column("targets", BYTES, nullable=False),
        sa.Column("file", BYTES, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_corrections_model_id", "corrections", ["model_id", "id"])
    protect("corrections")


def downgrade() -> None:
    """Drop every correction and its job, of a kind that the program of that schema does not know.

    The chain then begins anew; where there is none of them it stays as it is.
    """
    were_there = op.get_bind().scalar(sa.text(f"SELECT count(*) FROM ({_JOBS}) AS found"))
    tables = chained_tables() - {"corrections"}
    drop_protected("corrections")
    delete_protected("request_keys", "resource = 'correction job'")
    for table in ("events", "job_states"):
        delete_protected(table, f"job_id IN ({_JOBS})")
    delete_protected("jobs", "kind = 'correction'")
    if were_there:
        chain_anew(tables)
