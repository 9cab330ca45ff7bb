"""Diagnoses, and models that come from them: a model has one origin, an identification or a diagnosis."""

from typing import Any

import sqlalchemy as sa
from alembic import op

from truepose.storage.column_types import DOCUMENT, TEXT
from truepose.storage.migrations.append_only import delete_protected, drop_protected, protect
from truepose.storage.migrations.columns import number, on_sqlite, recorded, reference

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None

_ONE_ORIGIN = "(identification_id IS NULL) <> (diagnosis_id IS NULL)"
_KEPT = "id, recorded_at, identification_id, robot, document"
_OF_DIAGNOSES = "SELECT id FROM models WHERE diagnosis_id IS NOT NULL"
_JOBS = "SELECT id FROM jobs WHERE kind = 'diagnosis'"


def upgrade() -> None:
    """Make the table of diagnoses and let models point to it."""
    op.create_table(
        "diagnoses",
        number(),
        recorded(),
        reference("job_id", "jobs"),
        reference("campaign_id", "campaigns"),
        sa.Column("measured_at", TEXT, nullable=False),
        sa.Column("robot_serial_number", TEXT, nullable=False),
        sa.Column("summary", DOCUMENT, nullable=False),
        sa.Column("document", DOCUMENT, nullable=False),
        sqlite_autoincrement=True,
    )
    protect("diagnoses")
    diagnosis = reference("diagnosis_id", "diagnoses", nullable=True)
    if on_sqlite():
        identification = reference("identification_id", "identifications", nullable=True)
        _rebuild_models(identification, diagnosis, sa.CheckConstraint(_ONE_ORIGIN))
    else:
        op.alter_column("models", "identification_id", nullable=True)
        op.add_column("models", diagnosis)
        op.create_check_constraint("models_one_origin", "models", _ONE_ORIGIN)


def _rebuild_models(*origin: Any) -> None:
    # SQLite cannot make a column nullable: the rows go into a table made anew, under their numbers.
    # Validations point to them, so the check of references waits for the commit.
    op.execute("PRAGMA defer_foreign_keys = ON")
    op.execute(f"CREATE TABLE models_before AS SELECT {_KEPT} FROM models")
    drop_protected("models")
    op.create_table(
        "models",
        number(),
        recorded(),
        *origin,
        sa.Column("robot", TEXT, nullable=False),
        sa.Column("document", DOCUMENT, nullable=False),
        sqlite_autoincrement=True,
    )
    op.execute(f"INSERT INTO models ({_KEPT}) SELECT {_KEPT} FROM models_before ORDER BY id")
    op.drop_table("models_before")
    protect("models")


def downgrade() -> None:
    """Drop every diagnosis, its job and its model, with the validations of that model."""
    delete_protected("validations", f"model_id IN ({_OF_DIAGNOSES})")
    delete_protected("models", "diagnosis_id IS NOT NULL")
    if on_sqlite():
        _rebuild_models(reference("identification_id", "identifications"))
    else:
        op.drop_column("models", "diagnosis_id")
        op.alter_column("models", "identification_id", nullable=False)
    drop_protected("diagnoses")
    # The program of that schema knows no such kind of job.
    delete_protected("request_keys", "resource = 'diagnosis job'")
    for table in ("events", "job_states"):
        delete_protected(table, f"job_id IN ({_JOBS})")
    delete_protected("jobs", "kind = 'diagnosis'")
