"""The chain over all records: each has a link whose hash rests on its content and on the link before.

A stream is what belongs to one session; 0 holds everything else. A record that is changed, exchanged, taken
out or slipped in breaks the chain of its stream at that place, whoever did it and by whatever means.

The hash is SHA-256 over the hash before (32 bytes; zeros before the first), then the names of table and
columns and the values, each with its length before it, columns by name and without those that are null: a
column that a later schema adds leaves earlier hashes as they are. A link names its table as that was called
when it was made.
"""

import hashlib
import struct
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any, Final

TABLE_NOW: Final = {"ballbar_entries": "session_entries"}  # renamed by schema 0010
ROWID: Final = "rowid"  # numbers a table without the column `id`, and is in no hash
GENESIS: Final = bytes(32)
OF_NO_SESSION: Final = 0
_LENGTH: Final = struct.Struct(">I")
_FLOAT: Final = struct.Struct(">d")
_INSERT: Final = """
    INSERT INTO links (id, stream, record, record_id, hash)
    VALUES ((SELECT coalesce(max(id), 0) + 1 FROM links), ?, ?, ?, ?)
"""
_NEWEST: Final = "SELECT hash FROM links WHERE stream = ? ORDER BY id DESC LIMIT 1"


def linked_hash(before: bytes, record: str, names: tuple[str, ...], values: Sequence[Any]) -> bytes:
    """Return the hash of a record of the table `record` that follows the hash `before`."""
    parts = [before, *_framed(record.encode())]
    for index, name in _by_name(names):
        value = values[index]
        if value is not None:
            parts += _framed(name)
            parts += _framed(_encoded(value))
    return hashlib.sha256(b"".join(parts)).digest()


def stream_of(record: str, names: tuple[str, ...], values: Sequence[Any]) -> int:
    """Return the session that a record belongs to, or OF_NO_SESSION."""
    column = "id" if record == "sessions" else "session_id"
    found = values[names.index(column)] if column in names else None
    return found if isinstance(found, int) else OF_NO_SESSION


def link(connection: Any, record: str, record_id: int) -> None:
    """Append the link of a record that was just added, inside the caller's transaction.

    Parameters
    ----------
    connection : connection of the library
        See `connection.plain`.
    record : str
        Name of the table.
    record_id : int
    """
    found = connection.execute(f'SELECT * FROM "{record}" WHERE {numbered(record)} = ?', (record_id,))
    names, row = tuple(column[0] for column in found.description), found.fetchone()
    stream = stream_of(record, names, row)
    before = newest_hash(connection, stream)
    connection.execute(_INSERT, (stream, record, record_id, linked_hash(before, record, names, row)))


def newest_hash(connection: Any, stream: int) -> bytes:
    """Return the newest hash of a stream."""
    newest = connection.execute(_NEWEST, (stream,)).fetchone()
    return GENESIS if newest is None else bytes(newest[0])


def numbered(record: str) -> str:
    """Return the column that has the numbers of a table."""
    return ROWID if record == "request_keys" else "id"


def link_all(connection: Any, records: Iterable[str]) -> None:
    """Append the links of every record of these tables, of a database that has none yet."""
    heads: dict[int, bytes] = {}
    for record in records:
        number = numbered(record)
        rows = connection.execute(f'SELECT {number}, * FROM "{record}" ORDER BY {number}')
        names = tuple(column[0] for column in rows.description)[1:]
        connection.executemany(_INSERT, _links(rows, record, names, heads))


def _links(
    rows: Any, record: str, names: tuple[str, ...], heads: dict[int, bytes]
) -> Iterable[Sequence[Any]]:
    for record_id, *values in rows:
        stream = stream_of(record, names, values)
        heads[stream] = linked_hash(heads.get(stream, GENESIS), record, names, values)
        yield stream, record, record_id, heads[stream]


@lru_cache
def _by_name(names: tuple[str, ...]) -> tuple[tuple[int, bytes], ...]:
    return tuple(
        (index, name.encode()) for name, index in sorted((n, i) for i, n in enumerate(names) if n != ROWID)
    )


def _framed(content: bytes) -> tuple[bytes, bytes]:
    return _LENGTH.pack(len(content)), content


def _encoded(value: Any) -> bytes:
    """Return a value as it is kept, with its kind; text may come as a bytearray, not yet decoded."""
    match value:
        case str():
            return b"t" + value.encode()
        case bytearray():
            return b"t" + value
        case bytes():
            return b"b" + value
        case float():
            return b"f" + _FLOAT.pack(value)
        case _:
            return b"i" + str(value).encode()
