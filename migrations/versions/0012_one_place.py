"""One place for the shop: people, what opens the service to them, and their acts."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.column_types import BYTES, DOCUMENT, TEXT, WHOLE
from truepose.storage.migrations.append_only import drop_protected, protect
from truepose.storage.migrations.chain import chain_anew, chained_tables
from truepose.storage.migrations.columns import number, recorded, reference

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None

_PEOPLE = ("people", "person_states", "credentials", "revocations", "acts")
_SIGNED = ("closings", "reports")
_TABLES = (*_PEOPLE, *_SIGNED)


def upgrade() -> None:
    """Make the tables, a part each."""
    _people()
    _acts()
    _closings()
    _reports()
    for table in _TABLES:
        protect(table)


def downgrade() -> None:
    """Drop the tables; where one holds records the chain begins anew over those that stay."""
    there = chained_tables()
    for table in reversed(_TABLES):
        drop_protected(table)
    if there.intersection(_TABLES):
        chain_anew(there.difference(_TABLES))


def _people() -> None:
    op.create_table(
        "people",
        number(),
        recorded(),
        sa.Column("name", TEXT, nullable=False, unique=True),
        sqlite_autoincrement=True,
    )
    op.create_table(
        "person_states",
        number(),
        recorded(),
        reference("person_id", "people"),
        sa.Column("role", TEXT, nullable=False),
        sa.Column("active", WHOLE, nullable=False),
        sa.Column("by", TEXT, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_table(
        "credentials",
        number(),
        recorded(),
        sa.Column("kind", TEXT, nullable=False),
        reference("person_id", "people", nullable=True),
        sa.Column("hash", TEXT, nullable=False),
        sa.Column("expires_at", TEXT, nullable=True),
        sa.Column("document", DOCUMENT, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_table(
        "revocations",
        number(),
        recorded(),
        reference("credential_id", "credentials"),
        sa.Column("by", TEXT, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_revocations_credential_id", "revocations", ["credential_id"])


def _acts() -> None:
    op.create_table(
        "acts",
        number(),
        recorded(),
        sa.Column("happened_at", TEXT, nullable=False),
        sa.Column("operation", TEXT, nullable=False),
        sa.Column("resource", TEXT, nullable=False),
        sa.Column("status", WHOLE, nullable=False),
        *(
            sa.Column(name, TEXT, nullable=True)
            for name in ("person", "role", "how", "tablet", "address", "reason")
        ),
        sqlite_autoincrement=True,
    )


def _closings() -> None:
    op.create_table(
        "closings",
        number(),
        recorded(),
        reference("session_id", "sessions"),
        sa.Column("closed_as", TEXT, nullable=False),
        sa.Column("person", TEXT, nullable=False),
        sa.Column("reason", TEXT, nullable=False),
        sa.Column("document", DOCUMENT, nullable=False),
        sa.UniqueConstraint("session_id"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_closings_session_id", "closings", ["session_id", "id"])


def _reports() -> None:
    op.create_table(
        "reports",
        number(),
        recorded(),
        sa.Column("kind", TEXT, nullable=False),
        sa.Column("subject_id", WHOLE, nullable=False),
        sa.Column("revision", WHOLE, nullable=False),
        sa.Column("language", TEXT, nullable=False),
        sa.Column("stated_sha256", TEXT, nullable=False),
        sa.Column("page", BYTES, nullable=False),
        sa.UniqueConstraint("kind", "subject_id", "revision", "language"),
        sqlite_autoincrement=True,
    )
