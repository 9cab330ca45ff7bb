"""psycopg as the chain asks: `?` for values, and every value as it is kept."""

from collections.abc import Iterable, Sequence
from typing import Any, Final

import psycopg
from psycopg.adapt import AdaptersMap
from psycopg.types.string import TextLoader

_AS_KEPT: Final = AdaptersMap(psycopg.adapters)
_AS_KEPT.register_loader("json", TextLoader)  # the text is in the hash, not what it means


class _KeptCursor(psycopg.Cursor[Any]):
    """Gives JSON as its text."""

    @property
    def adapters(self) -> AdaptersMap:
        return _AS_KEPT


class PlainConnection:
    """A connection of psycopg, asked like one of SQLite's library."""

    def __init__(self, server: "psycopg.Connection[Any]") -> None:
        self.server = server

    def execute(self, query: str, values: Sequence[Any] = ()) -> Any:
        """Run one statement and return what can be fetched; raises psycopg.Error."""
        return _KeptCursor(self.server).execute(query.replace("?", "%s"), values)

    def executemany(self, query: str, rows: Iterable[Sequence[Any]]) -> None:
        """Run one statement for each of some rows; raises psycopg.Error."""
        _KeptCursor(self.server).executemany(query.replace("?", "%s"), rows)

    def copy_in(self, statement: str, rows: Iterable[Sequence[Any]]) -> None:
        """Send rows to a COPY statement; raises psycopg.Error."""
        with self.server.cursor().copy(statement.encode()) as copy:
            for row in rows:
                copy.write_row(row)

    def close(self) -> None:
        """End the connection."""
        self.server.close()
