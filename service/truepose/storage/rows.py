"""Inserting a record with its link in the chain: the one way that every repository shares."""

import functools
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Connection, Table, insert, literal_column
from sqlalchemy.sql.dml import ReturningInsert

from truepose.storage.connection.plain import plain
from truepose.storage.dialects import as_kept
from truepose.storage.integrity.chain import ROWID
from truepose.storage.integrity.linking import linking


def add_row(connection: Connection, table: Table, **values: Any) -> int:
    """Append a record to `table`, stamped with the time of day, and return its number.

    Its link waits until the transaction is about to be committed.
    """
    stamp = datetime.now(UTC).isoformat(timespec="milliseconds")
    number, *kept = connection.execute(_adding(table), {"recorded_at": stamp, **values}).one()
    linking(connection).add(plain(connection), table.name, int(number), _names(table), kept)
    return int(number)


@functools.cache
def _adding(table: Table) -> ReturningInsert[Any]:
    """Return the statement that adds a record, and gives back its number and every value as it is kept."""
    number = table.c.get("id", literal_column(ROWID)).label("number")
    return insert(table).returning(
        number, *(as_kept(column).label(f"kept_{column.name}") for column in table.c)
    )


@functools.cache
def _names(table: Table) -> tuple[str, ...]:
    return tuple(column.name for column in table.c)
