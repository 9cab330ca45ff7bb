"""Inserting a record with its link in the chain: the one way that every repository shares."""

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Connection, Table, insert

from truepose.storage.integrity.chain import link


def add_row(connection: Connection, table: Table, **values: Any) -> int:
    """Append a record to `table`, stamped with the time of day, and return its number."""
    stamp = datetime.now(UTC).isoformat(timespec="milliseconds")
    number = int(connection.execute(insert(table), {"recorded_at": stamp, **values}).lastrowid)
    link(connection.connection.cursor(), table.name, number)
    return number
