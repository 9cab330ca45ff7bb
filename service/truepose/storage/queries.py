"""What every repository does: it asks its database, for one record, a page of them, the newest."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, overload

from sqlalchemy import Column, ColumnElement, Connection, Row, Select, Table, func, select

from truepose.storage.database import Database
from truepose.storage.errors import NotFoundError
from truepose.storage.records import Page

R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class Part(Sequence[R], Generic[R]):
    """Some records of a list, oldest first."""

    records: tuple[R, ...]
    total: int  # of the whole list
    next_after: int | None  # number behind which the next part begins; None: this one is the last

    @overload
    def __getitem__(self, index: int) -> R: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[R, ...]: ...

    def __getitem__(self, index: int | slice) -> R | tuple[R, ...]:
        return self.records[index]

    def __len__(self) -> int:
        return len(self.records)


def part_of(
    connection: Connection,
    query: Select[Any],
    number: Column[int],
    page: Page,
    read: Callable[[Row[Any]], R],
) -> Part[R]:
    """Return the part of a query's rows that `page` wants; the rows are numbered by the column `number`."""
    # By the number of the last record and not by an offset: records that come meanwhile move nothing, and old
    # pages cost no more than new ones.
    wanted = query.where(number > page.after).order_by(number).limit(page.limit + 1)
    rows = connection.execute(wanted).all()
    some = rows[: page.limit]
    total = connection.scalar(query.with_only_columns(func.count(), maintain_column_froms=True)) or 0
    return Part(tuple(read(row) for row in some), total, some[-1].id if len(rows) > len(some) else None)


class Repository:
    """Asks a database about records of some kind."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def _rows(self, query: Select[Any]) -> Sequence[Any]:
        return await self._database.read(lambda c: c.execute(query).all())

    async def _row(self, query: Select[Any]) -> Row[Any] | None:
        """Return the one row that a query finds at most."""
        return await self._database.read(lambda c: c.execute(query).one_or_none())

    async def _values(self, query: Select[Any]) -> list[Any]:
        """Return the first column of each row."""
        return await self._database.read(lambda c: [*c.scalars(query)])

    async def _value(self, query: Select[Any]) -> Any | None:
        """Return the first column of the first row; None where there is no row."""
        return await self._database.read(lambda c: c.scalar(query))

    async def _each(self, query: Select[Any], read: Callable[[Row[Any]], R]) -> list[R]:
        """Return what `read` makes of each row."""
        # Documents are read where the query runs: of a long one the event loop would notice.
        return await self._database.read(lambda c: [read(row) for row in c.execute(query)])


class NumberedRecords(Repository, Generic[R]):
    """Records of one kind, each found by the number of its row in `table`.

    `select_all` makes the query of all of them, `read` a record of one of its rows.
    """

    def __init__(
        self,
        database: Database,
        kind: str,
        table: Table,
        select_all: Callable[[], Select[Any]],
        read: Callable[[Row[Any]], R],
    ) -> None:
        super().__init__(database)
        self._kind = kind
        self._id = table.c.id
        self._recorded_at = table.c.recorded_at
        self._select_all = select_all
        self._read = read

    async def get(self, number: int) -> R:
        """Return a record; raises NotFoundError."""
        found = await self._each(self._select_all().where(self._id == number), self._read)
        if not found:
            raise NotFoundError(self._kind, number)
        return found[0]

    async def require(self, number: int) -> None:
        """Raise NotFoundError where there is no record of that number; what it holds is not looked at."""
        await self._content(self._id, number)

    async def _content(self, column: Column[Any], number: int) -> Any:
        """Return what one record has in a column; raises NotFoundError."""
        found = await self._value(select(column).where(self._id == number))
        if found is None:
            raise NotFoundError(self._kind, number)
        return found

    async def page(self, page: Page, *conditions: ColumnElement[bool]) -> Part[R]:
        """Return records of which all conditions hold, oldest first."""
        query = self._select_all().where(*conditions)
        return await self._database.read(lambda c: part_of(c, query, self._id, page, self._read))

    async def newest(self, count: int, *conditions: ColumnElement[bool]) -> list[R]:
        """Return the latest records of which all conditions hold, newest first."""
        query = self._select_all().where(*conditions)
        return await self._each(query.order_by(self._id.desc()).limit(count), self._read)

    async def newest_of(self, count: int, month: str) -> list[R]:
        """Return the latest records of a month (`2026-11`), or of all where it is empty, newest first."""
        return await self.newest(count, self._recorded_at.startswith(month))
