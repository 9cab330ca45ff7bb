"""Links of the records that a transaction adds, written with it in one statement.

The newest hash of each stream is remembered from one transaction to the next: nobody else writes.
"""

from collections.abc import Sequence
from typing import Any, Final

from sqlalchemy import Connection

from truepose.storage.integrity.chain import linked_hash, newest_hash, stream_of
from truepose.storage.integrity.seal import Left, newest_link

_KEY: Final = "links"  # in what a connection carries
_COLUMNS: Final = "INSERT INTO links (id, stream, record, record_id, hash) VALUES "
_MOST: Final = 150  # in one statement: SQLite took no more than 999 values once


class Linking:
    """Of one connection that writes; `forget` undoes what a transaction undoes."""

    def __init__(self) -> None:
        self._heads: dict[int, bytes] = {}  # by stream
        self._newest: Left | None = None  # link that is written; None: not known
        self._waiting: list[tuple[int, str, int, bytes]] = []  # stream, record, number, hash

    def add(
        self, connection: Any, record: str, record_id: int, names: tuple[str, ...], values: Sequence[Any]
    ) -> None:
        """Link a record that was just added, as it is kept."""
        stream = stream_of(record, names, values)
        before = self._heads.get(stream) or newest_hash(connection, stream)
        found = self._heads[stream] = linked_hash(before, record, names, values)
        self._waiting.append((stream, record, record_id, found))

    def write(self, connection: Any) -> Left:
        """Write what waits and return the newest link; raises what the library raises."""
        newest = self._newest or newest_link(connection)
        for some in range(0, len(self._waiting), _MOST):
            links = self._waiting[some : some + _MOST]
            values = [value for n, link in enumerate(links, newest.link + 1) for value in (n, *link)]
            connection.execute(_COLUMNS + ", ".join(["(?, ?, ?, ?, ?)"] * len(links)), values)
            newest = Left(newest.link + len(links), links[-1][-1].hex())
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
