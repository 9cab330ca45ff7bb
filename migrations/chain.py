"""The chain of records where a migration takes some away: it begins anew over those that stay."""

import itertools
from collections.abc import Iterable, Iterator
from typing import Any

import sqlalchemy as sa
from alembic import op

from truepose.storage.engine.raw_connection import plain
from truepose.storage.integrity.hash_chain import GENESIS, linked_hash, stream_of
from truepose.storage.migrations.append_only import delete_protected

_INSERT = "INSERT INTO links (id, stream, record, record_id, hash) VALUES (?, ?, ?, ?, ?)"


def chained_tables() -> set[str]:
    """Return the tables whose records are in the chain."""
    return set(op.get_bind().execute(sa.text("SELECT DISTINCT record FROM links")).scalars())


def chain_anew(tables: set[str]) -> None:
    """Begin the chain anew with the records of these tables."""
    delete_protected("links", "true")
    if op.get_bind().dialect.name == "sqlite":
        op.execute("DELETE FROM sqlite_sequence WHERE name = 'links'")  # who verifies misses no number
    connection, heads, numbers = plain(op.get_bind()), dict[int, bytes](), itertools.count(1)
    for record in sorted(tables):
        rows = connection.execute(f'SELECT * FROM "{record}" ORDER BY id')
        names = tuple(column[0] for column in rows.description)
        connection.executemany(_INSERT, _links(rows.fetchall(), record, names, heads, numbers))


def _links(
    rows: Iterable[Any],
    record: str,
    names: tuple[str, ...],
    heads: dict[int, bytes],
    numbers: Iterator[int],
) -> Iterator[tuple[Any, ...]]:
    for values in rows:
        stream = stream_of(record, names, values)
        heads[stream] = linked_hash(heads.get(stream, GENESIS), record, names, values)
        yield next(numbers), stream, record, values[names.index("id")], heads[stream]
