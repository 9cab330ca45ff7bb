"""The chain of a cell as its plant reads it: links in their order, each with its record where that leaves."""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import Connection, Row, RowMapping, select

from truepose.storage.connection.plain import plain
from truepose.storage.database import Database
from truepose.storage.dialects import as_kept
from truepose.storage.integrity.chain import TABLE_NOW
from truepose.storage.integrity.head import Head, head_after
from truepose.storage.leaving.decided import LEAVING
from truepose.storage.leaving.without_secrets import without_secrets
from truepose.storage.tables import LARGE, links, metadata

_AT_A_TIME: Final = 100  # links that are read in one turn: whoever measures is never behind more


@dataclass(frozen=True, slots=True)
class LeavingLink:
    """A link of the chain, with its record where that leaves the cell."""

    id: int
    stream: int
    record: str  # name of its table when it was made
    record_id: int
    hash: bytes
    row: Mapping[str, Any] | None = None  # None: it stays at home, or a secret was taken out of it
    told: Mapping[str, Any] | None = None  # the record without its secret; None: it has none


@dataclass(frozen=True, slots=True)
class Stand:
    """How far a chain goes, and what it was at some link of it."""

    newest: int
    head: Head  # at the link asked for, or at the newest one where it does not go that far
    hash: bytes | None  # of that link; None: of a chain without any


class LeavingRecords:
    """All queries about what leaves a cell."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def stand(self, at: int | None = None) -> Stand:
        """Return the head of the chain as it was at a link, by default as it is."""
        return await self._database.read(lambda connection: _stand(connection, at))

    async def newest(self) -> int:
        """Return the number of the newest link; 0: there is none."""
        return await self._database.read(_newest)

    async def after(self, number: int, limit: int) -> Sequence[LeavingLink]:
        """Return some links above a number, at most `limit`; none: there are no more.

        Large records come one at a time, so that memory holds no more than one of them.
        """
        most = min(limit, _AT_A_TIME)
        return await self._database.read(lambda connection: _after(connection, number, most))


def _stand(connection: Connection, at: int | None) -> Stand:
    newest = _newest(connection)
    number = newest if at is None else min(at, newest)
    found = connection.scalar(select(links.c.hash).where(links.c.id == number))
    head = head_after(plain(connection), number)
    return Stand(newest, head, None if found is None else bytes(found))


def _newest(connection: Connection) -> int:
    return int(connection.scalar(select(links.c.id).order_by(links.c.id.desc()).limit(1)) or 0)


def _after(connection: Connection, number: int, most: int) -> list[LeavingLink]:
    found = connection.execute(select(links).where(links.c.id > number).order_by(links.c.id).limit(most))
    some = _up_to_large(found.all())
    rows = _rows(connection, some)
    return [_leaving(link, rows.get((_table(link), link.record_id))) for link in some]


def _up_to_large(found: Sequence[Row[Any]]) -> Sequence[Row[Any]]:
    large = next((place for place, link in enumerate(found) if _table(link) in LARGE), len(found))
    return found[: max(large, 1)]


def _rows(connection: Connection, some: Iterable[Row[Any]]) -> dict[tuple[str, int], RowMapping]:
    wanted: defaultdict[str, list[int]] = defaultdict(list)
    for link in some:
        if _table(link) in LEAVING:
            wanted[_table(link)].append(link.record_id)
    return {
        (table, row["id"]): row
        for table, numbers in wanted.items()
        for row in _of(connection, table, numbers)
    }


def _of(connection: Connection, table: str, numbers: Sequence[int]) -> Sequence[RowMapping]:
    """Return records as they are kept, not as their columns are read: the hash is of what is kept."""
    kept = metadata.tables[table]
    query = select(*(as_kept(column).label(column.name) for column in kept.c))
    return connection.execute(query.where(kept.c.id.in_(numbers))).mappings().all()


def _table(link: Row[Any]) -> str:
    return TABLE_NOW.get(link.record, str(link.record))


def _leaving(link: Row[Any], kept: RowMapping | None) -> LeavingLink:
    named = (link.id, link.stream, link.record, link.record_id, bytes(link.hash))
    if kept is None:
        return LeavingLink(*named)
    row = dict(kept)
    told = without_secrets(row)
    return LeavingLink(*named, row) if told is row else LeavingLink(*named, told=told)
