"""A journal line by line, as it is read where its cell is lost: what the cell had, and in which order."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from sqlalchemy import Connection, Row, Select, func, select

from truepose.storage.database import Database
from truepose.storage.parts import Part
from truepose.storage.records import Page
from truepose.storage.tables.of_plants import plant_branches, plant_cells, plant_journal

_MOST_CHARACTERS: Final = 8_000_000  # of a page; a campaign alone may have as many


@dataclass(frozen=True, slots=True)
class JournalLine:
    """A link of a cell's chain with its record, as it was collected."""

    id: int
    recorded_at: str  # when it was collected
    branch: int
    link: int
    stream: int
    record: str  # name of its table in the cell
    record_id: int
    hash: bytes
    row: dict[str, Any] | None  # every value with its kind; None: it never leaves the cell
    verified: bool


class JournalLines:
    """All queries that read journals line by line."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def of(self, cell: str, page: Page, record: str | None = None) -> Part[JournalLine]:
        """Return lines of a cell in the order of collecting, of one kind of record or of all.

        As many as the page wants, fewer where their records are large, one at least where there is any.
        """
        return await self._database.read(lambda connection: _lines(connection, cell, page, record))


def _lines(connection: Connection, cell: str, page: Page, record: str | None) -> Part[JournalLine]:
    query = _of_cell(cell, record)
    total = connection.scalar(query.with_only_columns(func.count(), maintain_column_froms=True)) or 0
    behind = query.where(plant_journal.c.id > page.after).order_by(plant_journal.c.id)
    sizes = behind.with_only_columns(plant_journal.c.id, func.length(plant_journal.c.content))
    found = connection.execute(sizes.limit(page.limit + 1)).all()
    count = _that_fit([size or 0 for _, size in found[: page.limit]])
    rows = connection.execute(behind.limit(count)).all() if count else []
    return Part(tuple(map(_line, rows)), total, rows[-1].id if count < len(found) else None)


def _of_cell(cell: str, record: str | None) -> Select[Any]:
    branches = (
        select(plant_branches.c.id)
        .join(plant_cells, plant_cells.c.id == plant_branches.c.cell_id)
        .where(plant_cells.c.name == cell)
    )
    query = select(plant_journal).where(plant_journal.c.branch_id.in_(branches))
    return query if record is None else query.where(plant_journal.c.record == record)


def _that_fit(sizes: Sequence[int]) -> int:
    """Return how many records make a page, by their characters."""
    characters = 0
    for count, size in enumerate(sizes):
        characters += size
        if count and characters > _MOST_CHARACTERS:
            return count
    return len(sizes)


def _line(row: Row[Any]) -> JournalLine:
    return JournalLine(
        row.id,
        row.recorded_at,
        row.branch_id,
        row.link,
        row.stream,
        row.record,
        row.record_id,
        bytes(row.hash),
        None if row.content is None else json.loads(row.content),
        bool(row.verified),
    )
