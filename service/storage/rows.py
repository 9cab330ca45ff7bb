"""Inserting a record: the one statement that every repository shares."""

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Connection, Table, insert


def add_row(connection: Connection, table: Table, **values: Any) -> int:
    """Append a record to `table`, stamped with the time of day, and return its number."""
    stamp = datetime.now(UTC).isoformat(timespec="milliseconds")
    result = connection.execute(insert(table).values(recorded_at=stamp, **values))
    return int(result.lastrowid)
