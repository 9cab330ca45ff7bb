"""One place for the shop: people, what opens the service to them, and their acts."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.migrations.append_only import drop_protected, protect
from truepose.storage.migrations.chain import chain_anew, chained_tables
from truepose.storage.migrations.columns import number, recorded, reference

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None

_PEOPLE = ("people", "person_states", "credentials", "revocations", "acts")


def upgrade() -> None:
    """Make the tables, a part each."""
    _people()
    _acts()
    for table in _PEOPLE:
        protect(table)


def downgrade() -> None:
    """Drop the tables; where one holds records the chain begins anew over those that stay."""
    there = chained_tables()
    for table in reversed(_PEOPLE):
        drop_protected(table)
    if there.intersection(_PEOPLE):
        chain_anew(there.difference(_PEOPLE))


def _people() -> None:
    op.create_table(
        "people",
        number(),
        recorded(),
        sa.Column("name", sa.Text, nullable=False, unique=True),
        sqlite_autoincrement=True,
    )
    op.create_table(
        "person_states",
        number(),
        recorded(),
        reference("person_id", "people"),
        sa.Column("role", sa.Text, nullable=False),
        sa.Column("active", sa.Integer, nullable=False),
        sa.Column("by", sa.Text, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_table(
        "credentials",
        number(),
        recorded(),
        sa.Column("kind", sa.Text, nullable=False),
        reference("person_id", "people", nullable=True),
        sa.Column("hash", sa.Text, nullable=False),
        sa.Column("expires_at", sa.Text, nullable=True),
        sa.Column("document", sa.JSON, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_table(
        "revocations",
        number(),
        recorded(),
        reference("credential_id", "credentials"),
        sa.Column("by", sa.Text, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_revocations_credential_id", "revocations", ["credential_id"])


def _acts() -> None:
    op.create_table(
        "acts",
        number(),
        recorded(),
        sa.Column("happened_at", sa.Text, nullable=False),
        sa.Column("operation", sa.Text, nullable=False),
        sa.Column("resource", sa.Text, nullable=False),
        sa.Column("status", sa.Integer, nullable=False),
        *(
            sa.Column(name, sa.Text, nullable=True)
            for name in ("person", "role", "how", "tablet", "address", "reason")
        ),
        sqlite_autoincrement=True,
    )
