"""Parts of lists: what a page holds, how many records there are in all, and whether more follow."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, overload

from sqlalchemy import Column, Connection, Row, Select, func

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
    wanted = query.where(number > page.after).order_by(number).limit(page.limit + 1)
    rows = connection.execute(wanted).all()
    some = rows[: page.limit]
    total = connection.scalar(query.with_only_columns(func.count(), maintain_column_froms=True)) or 0
    return Part(tuple(read(row) for row in some), total, some[-1].id if len(rows) > len(some) else None)
