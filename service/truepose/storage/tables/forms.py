"""What every table of records has, and the one place that all of them are listed in."""

import sqlalchemy as sa
from sqlalchemy.schema import SchemaItem

from truepose.storage.column_types import TEXT, WHOLE
from truepose.storage.dialects import next_number

metadata = sa.MetaData()


def number(table: str) -> sa.Column[int]:
    """Return the number of a record."""
    return sa.Column("id", WHOLE, primary_key=True, autoincrement=True, default=next_number(table))


def recorded() -> sa.Column[str]:
    """Return when a record was written."""
    return sa.Column("recorded_at", TEXT, nullable=False)


def reference(name: str, target: str, *, nullable: bool = False) -> sa.Column[int]:
    """Return a reference to a record of another table."""
    return sa.Column(name, WHOLE, sa.ForeignKey(f"{target}.id"), nullable=nullable)


def records(name: str, *columns: SchemaItem) -> sa.Table:
    """Return a table of records."""
    return sa.Table(name, metadata, number(name), recorded(), *columns, sqlite_autoincrement=True)


def records_of_sessions(name: str, *columns: SchemaItem) -> sa.Table:
    """Return a table of records that each belong to a session."""
    found = sa.Index(f"ix_{name}_session_id", "session_id", "id")
    return records(name, reference("session_id", "sessions"), *columns, found)
