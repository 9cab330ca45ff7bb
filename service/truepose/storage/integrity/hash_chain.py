"""The hash chain over all records: each has a link whose hash rests on its content and on the link before.

A stream is what belongs to one session; 0 holds everything else. A record that is changed, exchanged, taken
out or slipped in breaks the chain of its stream at that place, whoever did it and by whatever means.

The hash is SHA-256 over the hash before (32 bytes; zeros before the first), then the names of table and
columns and the values, each with its length before it, columns by name and without those that are null: a
column that a later schema adds leaves earlier hashes as they are.

The newest hash of each stream is remembered from one transaction to the next: nobody else writes.
"""

import hashlib
import struct
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, Final

from sqlalchemy import Connection

from truepose.storage.integrity.database_identity import ClosingState, newest_link

GENESIS: Final = bytes(32)
OF_NO_SESSION: Final = 0
_LENGTH: Final = struct.Struct(">I")
_FLOAT: Final = struct.Struct(">d")
_NEWEST: Final = "SELECT hash FROM links WHERE stream = ? ORDER BY id DESC LIMIT 1"


def linked_hash(before: bytes, record: str, names: tuple[str, ...], values: Sequence[Any]) -> bytes:
    """Return the hash of a record of the table `record` that follows the hash `before`."""
    parts = [before, *_framed(record.encode())]
    for index, name in _by_name(names):
        value = values[index]
        # Null and absent are one: so a column that a later schema adds changes no earlier hash.
        if value is not None:
            # Lengths before contents: without them "ab" and "c" would hash as "a" and "bc" do.
            parts += _framed(name)
            parts += _framed(_encoded(value))
    return hashlib.sha256(b"".join(parts)).digest()


def stream_of(record: str, names: tuple[str, ...], values: Sequence[Any]) -> int:
    """Return the session that a record belongs to, or OF_NO_SESSION."""
    # A session's own record is the first of its stream. The tables of a plant have such a column too, with
    # numbers of its cells: their streams are the plant's own and mean no session.
    column = "id" if record == "sessions" else "session_id"
    found = values[names.index(column)] if column in names else None
    return found if isinstance(found, int) else OF_NO_SESSION


def newest_hash(connection: Any, stream: int) -> bytes:
    """Return the newest hash of a stream."""
    newest = connection.execute(_NEWEST, (stream,)).fetchone()
    return GENESIS if newest is None else bytes(newest[0])


# By name: a migration may put columns in another order.
@lru_cache
def _by_name(names: tuple[str, ...]) -> tuple[tuple[int, bytes], ...]:
    return tuple((index, name.encode()) for name, index in sorted((n, i) for i, n in enumerate(names)))


def _framed(content: bytes) -> tuple[bytes, bytes]:
    return _LENGTH.pack(len(content)), content


def _encoded(value: Any) -> bytes:
    """Return a value as it is kept, with its kind; text may come as a bytearray, not yet decoded."""
    match value:
        case str():
            # The kind goes in as well: the text "1", the number 1 and the byte 0x31 are three values.
            return b"t" + value.encode()
        case bytearray():
            return b"t" + value
        case bytes():
            return b"b" + value
        case float():
            return b"f" + _FLOAT.pack(value)
        case _:
            return b"i" + str(value).encode()


_KEY: Final = "links"  # in what a connection carries
_COLUMNS: Final = "INSERT INTO links (id, stream, record, record_id, hash) VALUES "
_MOST: Final = 150  # in one statement: SQLite took no more than 999 values once


class Linking:
    """Of one connection that writes; `forget` undoes what a transaction undoes."""

    def __init__(self) -> None:
        # Remembered from commit to commit, as nobody else writes: it saves a query for each record.
        self._heads: dict[int, bytes] = {}  # by stream
        self._newest: ClosingState | None = None  # link that is written; None: not known
        self._waiting: list[tuple[int, str, int, bytes]] = []  # stream, record, number, hash

    def add(
        self, connection: Any, record: str, record_id: int, names: tuple[str, ...], values: Sequence[Any]
    ) -> None:
        """Link a record that was just added, as it is kept."""
        stream = stream_of(record, names, values)
        before = self._heads.get(stream) or newest_hash(connection, stream)
        found = self._heads[stream] = linked_hash(before, record, names, values)
        # Written at the end in one statement: a reading takes seven statements so, where it took sixteen
        # (commit f126b768).
        self._waiting.append((stream, record, record_id, found))

    def write(self, connection: Any) -> ClosingState:
        """Write what waits and return the newest link; raises what the library raises."""
        # Numbers of links are counted here, not given by the engine: the noted newest link must be known with
        # the commit.
        newest = self._newest or newest_link(connection)
        for some in range(0, len(self._waiting), _MOST):
            links = self._waiting[some : some + _MOST]
            values = [value for n, link in enumerate(links, newest.link + 1) for value in (n, *link)]
            connection.execute(_COLUMNS + ", ".join(["(?, ?, ?, ?, ?)"] * len(links)), values)
            newest = ClosingState(newest.link + len(links), links[-1][-1].hex())
        self._waiting.clear()
        self._newest = newest
        return newest

    def forget(self) -> None:
        """Know nothing: the transaction was undone."""
        self._waiting.clear()
        self._heads.clear()
        self._newest = None


def linking(connection: Connection) -> Linking:
    """Return the links of a connection, which go with it."""
    found: Linking = connection.info.setdefault(_KEY, Linking())
    return found
