"""Inserting a record with its link in the chain: the one way that every repository shares."""

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Connection, Table, insert, literal_column

from truepose.storage.connection.plain import plain
from truepose.storage.integrity.chain import ROWID, link


def add_row(connection: Connection, table: Table, **values: Any) -> int:
    """Append a record to `table`, stamped with the time of day, and return its number."""
    stamp = datetime.now(UTC).isoformat(timespec="milliseconds")
    query = insert(table).returning(table.c.get("id", literal_column(ROWID)))
    number = int(connection.execute(query, {"recorded_at": stamp, **values}).scalar_one())
    link(plain(connection), table.name, number)
    return number
