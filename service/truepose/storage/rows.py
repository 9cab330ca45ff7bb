"""Inserting a record with its link in the chain: the one way that every repository shares."""

import functools
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Connection, Row, Select, Table, insert, literal_column, select
from sqlalchemy.sql.dml import ReturningInsert

from truepose.storage.connection.plain import plain
from truepose.storage.dialects import as_kept, newest_number
from truepose.storage.integrity.chain import ROWID
from truepose.storage.integrity.linking import linking


def add_row(connection: Connection, table: Table, **values: Any) -> int:
    """Append a record to `table`, stamped with the time of day, and return its number.

    Its link waits until the transaction is about to be committed.
    """
    row = connection.execute(_adding(table), {"recorded_at": _stamp(), **values}).one()
    return _link(connection, table, row)


def add_rows(connection: Connection, table: Table, rows: Sequence[Mapping[str, Any]]) -> list[int]:
    """Append records with the same columns to `table`, which has `id`, and return their numbers."""
    if not rows:
        return []
    newest, stamp = connection.scalar(_newest(table)) or 0, _stamp()
    numbered = [{"id": number, "recorded_at": stamp, **row} for number, row in enumerate(rows, newest + 1)]
    kept = connection.execute(_adding(table), numbered).all()
    return [_link(connection, table, row) for row in sorted(kept, key=_number)]


def _stamp() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _number(row: Row[Any]) -> int:
    return int(row.number)


def _link(connection: Connection, table: Table, row: Sequence[Any]) -> int:
    number, *kept = row
    linking(connection).add(plain(connection), table.name, int(number), _names(table), kept)
    return int(number)


@functools.cache
def _newest(table: Table) -> Select[Any]:
    return select(newest_number(table.name))


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
