"""Lays what a plant has collected into an empty database of either engine, faster than it is collected."""

import os
import sqlite3
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from datetime import date
from pathlib import Path
from typing import Any, Final, Protocol

import psycopg
from sqlalchemy import Table

from tests.studies.plant_looks.rows import Laid, Row, rows
from truepose.storage.database import Database
from truepose.storage.engine.address import database_file

_TOGETHER: Final = 20_000


class Target(Protocol):
    """A database that rows are laid into."""

    def add(self, table: Table, some: Sequence[tuple[Any, ...]]) -> None:
        """Add rows of a table."""

    def close(self) -> None:
        """Have everything on disk."""


class OfSQLite:
    """A file of SQLite."""

    def __init__(self, url: str) -> None:
        self._connection = sqlite3.connect(_made(url), isolation_level=None)
        self._connection.execute("PRAGMA synchronous=OFF")
        self._connection.execute("BEGIN")

    def add(self, table: Table, some: Sequence[tuple[Any, ...]]) -> None:
        """Add rows of a table."""
        places = ", ".join("?" * len(table.c))
        self._connection.executemany(f"INSERT INTO {table.name} ({_columns(table)}) VALUES ({places})", some)

    def close(self) -> None:
        """Have everything on disk, and the log taken over."""
        self._connection.execute("COMMIT")
        self._connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        self._connection.close()


class OfPostgreSQL:
    """A database of a server."""

    def __init__(self, url: str) -> None:
        _made(url)
        self._connection = psycopg.connect(url)

    def add(self, table: Table, some: Sequence[tuple[Any, ...]]) -> None:
        """Add rows of a table."""
        with self._connection.cursor().copy(f"COPY {table.name} ({_columns(table)}) FROM STDIN") as copy:
            copy.write("".join(_line(row) for row in some))

    def close(self) -> None:
        """Have everything on disk, looked over as a server does by itself within minutes."""
        self._connection.commit()
        self._connection.autocommit = True
        self._connection.execute("VACUUM ANALYZE")
        self._connection.execute("CHECKPOINT")
        self._connection.close()


def lay(targets: Iterable[Target], robots: int, readings: int, today: date) -> Laid:
    """Lay the same rows into every target; what was laid is returned."""
    laid, to = Laid(), [*targets]
    for table, some in _some(rows(laid, robots, readings, today)):
        for target in to:
            target.add(table, some)
    for target in to:
        target.close()
    os.sync()  # nobody's commit waits for what was laid
    return laid


def _some(every: Iterable[Row]) -> Iterator[tuple[Table, list[tuple[Any, ...]]]]:
    """Yield rows some at a time by their tables, in the order in which one table refers to another."""
    waiting: defaultdict[Table, list[tuple[Any, ...]]] = defaultdict(list)
    for count, row in enumerate(every, 1):
        waiting[row.table].append(row.values)
        if count % _TOGETHER == 0:
            yield from waiting.items()
            waiting.clear()
    yield from waiting.items()


def _made(url: str) -> Path:
    """Make an empty database; that it is changed while no service has it is on purpose."""
    Database(url).close()
    file = database_file(url)
    file.with_name(f"{file.name}.seal").unlink(missing_ok=True)
    return file


def _columns(table: Table) -> str:
    return ", ".join(f'"{column.name}"' for column in table.c)


def _line(row: tuple[Any, ...]) -> str:
    return "\t".join(map(_text, row)) + "\n"


def _text(value: Any) -> str:
    match value:
        case None:
            return r"\N"
        case bytes():
            return rf"\\x{value.hex()}"
        case _:
            return str(value)
