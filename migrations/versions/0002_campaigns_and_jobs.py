"""Campaigns, jobs and what jobs make: identifications, models, validations."""

from typing import Any

import sqlalchemy as sa
from alembic import op

from truepose.storage.column_types import BYTES, DOCUMENT, TEXT, WHOLE
from truepose.storage.migrations.append_only import drop_protected, protect
from truepose.storage.migrations.columns import number, recorded, reference

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Make the tables of the evaluation."""
    _table(
        "campaigns",
        sa.Column("name", TEXT, nullable=False),
        sa.Column("robot", TEXT, nullable=False),
        sa.Column("summary", DOCUMENT, nullable=False),
        sa.Column("session_ids", DOCUMENT, nullable=False),
        sa.Column("archive", BYTES, nullable=False),
    )
    _table("jobs", sa.Column("kind", TEXT, nullable=False), sa.Column("request", DOCUMENT, nullable=False))
    _table(
        "job_states",
        reference("job_id", "jobs"),
        sa.Column("state", TEXT, nullable=False),
        sa.Column("message", TEXT, nullable=False),
        sa.Column("result_id", WHOLE, nullable=True),
    )
    op.create_index("ix_job_states_job_id", "job_states", ["job_id", "id"])
    _results()


def _results() -> None:
    _table("identifications", reference("job_id", "jobs"), reference("campaign_id", "campaigns"), _document())
    _table(
        "models",
        reference("identification_id", "identifications"),
        sa.Column("robot", TEXT, nullable=False),
        _document(),
    )
    _table(
        "validations",
        reference("job_id", "jobs"),
        reference("model_id", "models"),
        reference("campaign_id", "campaigns"),
        _document(),
    )


def _document() -> "sa.Column[Any]":
    return sa.Column("document", DOCUMENT, nullable=False)


def _table(name: str, *columns: "sa.Column[Any]") -> None:
    op.create_table(name, number(), recorded(), *columns, sqlite_autoincrement=True)
    protect(name)


def downgrade() -> None:
    """Drop the tables of the evaluation, with every campaign and result."""
    for table in ("validations", "models", "identifications", "job_states", "jobs", "campaigns"):
        drop_protected(table)
