"""Campaigns, jobs and what jobs make: identifications, models, validations."""

from typing import Any

import sqlalchemy as sa
from alembic import op

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
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("robot", sa.Text, nullable=False),
        sa.Column("summary", sa.JSON, nullable=False),
        sa.Column("session_ids", sa.JSON, nullable=False),
        sa.Column("archive", sa.LargeBinary, nullable=False),
    )
    _table("jobs", sa.Column("kind", sa.Text, nullable=False), sa.Column("request", sa.JSON, nullable=False))
    _table(
        "job_states",
        reference("job_id", "jobs"),
        sa.Column("state", sa.Text, nullable=False),
        sa.Column("message", sa.Text, nullable=False),
        sa.Column("result_id", sa.Integer, nullable=True),
    )
    op.create_index("ix_job_states_job_id", "job_states", ["job_id", "id"])
    _results()


def _results() -> None:
    _table("identifications", reference("job_id", "jobs"), reference("campaign_id", "campaigns"), _document())
    _table(
        "models",
        reference("identification_id", "identifications"),
        sa.Column("robot", sa.Text, nullable=False),
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
    return sa.Column("document", sa.JSON, nullable=False)


def _table(name: str, *columns: "sa.Column[Any]") -> None:
    op.create_table(name, number(), recorded(), *columns, sqlite_autoincrement=True)
    protect(name)


def downgrade() -> None:
    """Drop the tables of the evaluation, with every campaign and result."""
    for table in ("validations", "models", "identifications", "job_states", "jobs", "campaigns"):
        drop_protected(table)
