"""What results tell, certificates that were seen, and models that a plant handed down and a person accepted.

A plant fills both tables from its journal: of what it collected before, when it is next started.
"""

import sqlalchemy as sa
from alembic import op

from truepose.storage.column_types import DOCUMENT, REAL, TEXT, WHOLE
from truepose.storage.migrations.append_only import delete_protected, drop_protected, protect
from truepose.storage.migrations.chain import chain_anew, chained_tables
from truepose.storage.migrations.columns import number, on_sqlite, recorded, reference

revision = "0014"
down_revision = "0013"
branch_labels = None
depends_on = None

_TABLES = ("plant_told", "plant_certificates")
_BEFORE = ("identification_id", "diagnosis_id")
_ORIGINS = (*_BEFORE, "handed_down_id")
_ONE_OF_TWO = "(identification_id IS NULL) <> (diagnosis_id IS NULL)"
_ONE_OF_THREE = " + ".join(f"(CASE WHEN {origin} IS NULL THEN 0 ELSE 1 END)" for origin in _ORIGINS) + " = 1"
_ONE_ORIGIN = "models_one_origin"
_KEPT = "id, recorded_at, identification_id, diagnosis_id, robot, document"
_HANDED_DOWN = "SELECT id FROM models WHERE handed_down_id IS NOT NULL"


def upgrade() -> None:
    """Make the tables, and let models come from a plant."""
    _make_told()
    _make_certificates()
    for table in _TABLES:
        protect(table)
    _let_models_be_handed_down()


def downgrade() -> None:
    """Drop the tables and every accepted model with what was made of it; the chain then begins anew."""
    were_there = op.get_bind().scalar(sa.text(f"SELECT count(*) FROM ({_HANDED_DOWN}) AS found"))
    there = chained_tables()
    for table in ("validations", "corrections"):
        delete_protected(table, f"model_id IN ({_HANDED_DOWN})")
    delete_protected("models", "handed_down_id IS NOT NULL")
    _let_no_model_be_handed_down()
    for table in _TABLES:
        drop_protected(table)
    if were_there or there.intersection(_TABLES):
        chain_anew(there.difference(_TABLES))


def _make_told() -> None:
    op.create_table(
        "plant_told",
        number(),
        recorded(),
        reference("branch_id", "plant_branches"),
        sa.Column("kind", TEXT, nullable=False),
        sa.Column("link", WHOLE, nullable=False),
        sa.Column("record_id", WHOLE, nullable=False),
        sa.Column("robot_serial_number", TEXT, nullable=False),
        sa.Column("measured_on", TEXT, nullable=False),
        sa.Column("verdict", TEXT, nullable=False),
        sa.Column("figure_mm", REAL, nullable=True),
        sa.Column("limit_mm", REAL, nullable=True),
        sa.Column("document", DOCUMENT, nullable=False),
        sa.UniqueConstraint("branch_id", "link", name="uq_plant_told_link"),
        sqlite_autoincrement=True,
    )
    of_robot = ["robot_serial_number", "kind", "measured_on", "id"]
    op.create_index("ix_plant_told_robot", "plant_told", of_robot)
    op.create_index("ix_plant_told_record", "plant_told", ["branch_id", "kind", "record_id"])


def _make_certificates() -> None:
    names = ("what", "serial_number", "certificate", "expires", "stated_on")
    op.create_table(
        "plant_certificates",
        number(),
        recorded(),
        reference("branch_id", "plant_branches"),
        sa.Column("link", WHOLE, nullable=False),
        *(sa.Column(name, TEXT, nullable=False) for name in names),
        sqlite_autoincrement=True,
    )
    op.create_index(
        "ix_plant_certificates_of", "plant_certificates", ["serial_number", "branch_id", "what", "id"]
    )


def _let_models_be_handed_down() -> None:
    handed_down = reference("handed_down_id", "handed_down", nullable=True)
    accepted_by = sa.Column("accepted_by", TEXT, nullable=True)
    if on_sqlite():
        _rebuild_models(_ONE_OF_THREE, handed_down, accepted_by)
    else:
        op.drop_constraint(_ONE_ORIGIN, "models")
        op.add_column("models", handed_down)
        op.add_column("models", accepted_by)
        op.create_check_constraint(_ONE_ORIGIN, "models", _ONE_OF_THREE)
    op.create_index("uq_models_handed_down_id", "models", ["handed_down_id"], unique=True)


def _let_no_model_be_handed_down() -> None:
    op.drop_index("uq_models_handed_down_id", "models")
    if on_sqlite():
        _rebuild_models(_ONE_OF_TWO)
    else:
        op.drop_constraint(_ONE_ORIGIN, "models")
        op.drop_column("models", "accepted_by")
        op.drop_column("models", "handed_down_id")
        op.create_check_constraint(_ONE_ORIGIN, "models", _ONE_OF_TWO)


def _rebuild_models(one_origin: str, *further: sa.schema.SchemaItem) -> None:
    # SQLite cannot change a constraint: the rows go into a table made anew, under their numbers.
    # Validations and corrections point to them, so the check of references waits for the commit.
    op.execute("PRAGMA defer_foreign_keys = ON")
    op.execute(f"CREATE TABLE models_before AS SELECT {_KEPT} FROM models")
    drop_protected("models")
    op.create_table(
        "models",
        number(),
        recorded(),
        reference("identification_id", "identifications", nullable=True),
        reference("diagnosis_id", "diagnoses", nullable=True),
        sa.Column("robot", TEXT, nullable=False),
        sa.Column("document", DOCUMENT, nullable=False),
        *further,
        sa.CheckConstraint(one_origin),
        sqlite_autoincrement=True,
    )
    op.execute(f"INSERT INTO models ({_KEPT}) SELECT {_KEPT} FROM models_before ORDER BY id")
    op.drop_table("models_before")
    protect("models")
