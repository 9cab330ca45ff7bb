"""Series of readings that programs deliver; what a plant collects from cells and hands down to them."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.column_types import DOCUMENT, TEXT, WHOLE
from truepose.storage.migrations.append_only import drop_protected, protect
from truepose.storage.migrations.chain import chain_anew, chained_tables
from truepose.storage.migrations.columns import number, recorded, reference
from truepose.storage.migrations.of_plants import TABLES, make_tables_of_plants

revision = "0013"
down_revision = "0012"
branch_labels = None
depends_on = None

_TABLES = ("series", "deliveries", *TABLES)


def upgrade() -> None:
    """Make the tables."""
    op.create_table(
        "series",
        number(),
        recorded(),
        sa.Column("name", TEXT, nullable=False),
        sa.Column("columns", DOCUMENT, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_table(
        "deliveries",
        number(),
        recorded(),
        reference("series_id", "series"),
        sa.Column("first", WHOLE, nullable=False),
        sa.Column("count", WHOLE, nullable=False),
        sa.Column("document", DOCUMENT, nullable=False),
        sa.UniqueConstraint("series_id", "first"),
        sqlite_autoincrement=True,
    )
    make_tables_of_plants()
    for table in _TABLES:
        protect(table)


def downgrade() -> None:
    """Drop the tables; where one holds records the chain begins anew over those that stay."""
    there = chained_tables()
    for table in reversed(_TABLES):
        drop_protected(table)
    if there.intersection(_TABLES):
        chain_anew(there.difference(_TABLES))
