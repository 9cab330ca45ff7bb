"""Rows as they are kept elsewhere, written with their numbers into an empty database."""

from collections.abc import Sequence
from typing import Any

from truepose.storage.integrity.chain import ROWID


def fill_in(connection: Any, record: str, names: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Add rows to a table of the database that a plain connection writes; raises what its library raises."""
    columns = ", ".join(f'"{name}"' for name in names)
    if hasattr(connection, "server"):
        connection.copy_in(f'COPY "{record}" ({columns}) FROM STDIN', rows)
    else:
        values = ", ".join("?" for _ in names)
        connection.executemany(f'INSERT INTO "{record}" ({columns}) VALUES ({values})', rows)


def renumber(connection: Any) -> None:
    """Have the numbers go on behind those that were filled in, where the engine counts by itself."""
    if hasattr(connection, "server"):
        counter = f"pg_get_serial_sequence('request_keys', '{ROWID}')"
        newest = f"(SELECT coalesce(max({ROWID}), 0) + 1 FROM request_keys)"
        connection.execute(f"SELECT setval({counter}, {newest}, false)")
