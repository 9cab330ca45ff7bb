"""Columns that every record has, as the migrations write them."""

import sqlalchemy as sa
from alembic import op

from truepose.storage.column_types import TEXT, WHOLE


def number() -> sa.Column[int]:
    """Return the record's number; never given twice, even after the newest row is gone."""
    return sa.Column("id", WHOLE, primary_key=True, autoincrement=on_sqlite())


def recorded() -> sa.Column[str]:
    """Return when the record was written: UTC, ISO 8601."""
    return sa.Column("recorded_at", TEXT, nullable=False)


def reference(name: str, target: str, *, nullable: bool = False) -> sa.Column[int]:
    """Return a reference to the number of a record in `target`."""
    return sa.Column(name, WHOLE, sa.ForeignKey(f"{target}.id"), nullable=nullable)


def on_sqlite() -> bool:
    """Whether the database is a file of SQLite."""
    return op.get_bind().dialect.name == "sqlite"
