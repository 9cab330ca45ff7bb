"""The journal of a plant: each link of each cell once, in the order of the cell's chain, page by page.

A page, what follows from it and how far the cell was collected are one transaction: the position is the
newest link itself, so that nothing can be kept without it, or it without what it stands for.
"""

import asyncio
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final

from sqlalchemy import Connection, Row, Select, func, select

from truepose.storage.database import Database
from truepose.storage.errors import CollectedMeanwhileError, ConflictError
from truepose.storage.integrity.head_hash import Head, head_of
from truepose.storage.plant.cells import (
    accepted_branches,
    add_branch,
    cell_number,
    enter_cell,
    heads,
    newest_branch,
    newest_visit,
    position,
)
from truepose.storage.plant.projections import project
from truepose.storage.plant.records import AcceptedBranch, Branch, ClockSeen, CollectedLink, Outcome
from truepose.storage.plant.tables import plant_branches, plant_cells, plant_journal
from truepose.storage.queries import Part, Repository
from truepose.storage.record_insertion import add_rows
from truepose.storage.records import Page
from truepose.storage.rows import from_row, to_row

# With a reader for each of 40 cells that were away the plant's first page came after 8 to 15 s (commit
# b31a704e).
_CHAINS_AT_ONCE: Final = 1  # read for the first time: pages find a reader meanwhile


@dataclass(frozen=True, slots=True)
class Reached:
    """How far a cell was collected."""

    branch: Branch
    position: int  # newest link


@dataclass(frozen=True)
class CollectionProgress:
    """How far a cell was collected, and what the next links rest on."""

    branch: Branch
    position: int
    heads: Mapping[int, bytes]

    @cached_property
    def head(self) -> Head:
        """The head of what was collected, as the cell's reports print it."""
        return head_of(self.position, self.heads)


class JournalRepository(Repository):
    """All queries about journals.

    What the next links of a cell rest on is read once, when it first answers, and goes on with each page.
    """

    def __init__(self, database: Database) -> None:
        super().__init__(database)
        self._known: dict[int, CollectionProgress] = {}  # by branch
        self._reading = asyncio.Semaphore(_CHAINS_AT_ONCE)

    async def enter(self, *cells: str) -> None:
        """Enter cells where they are new."""
        await self._database.write(lambda connection: _enter(connection, cells))

    async def reached(self, cell: str) -> Reached:
        """Return how far a cell was collected; raises NotInPlantError for one that was never entered."""
        return await self._database.read(lambda connection: _reached(connection, cell))

    async def collected(self, reached: Reached) -> CollectionProgress:
        """Return what the next links of a cell rest on."""
        known = self._known_at(reached)
        if known is not None:
            return known
        found = await self._heads(reached.branch, reached.position)
        self._known[reached.branch.id] = CollectionProgress(reached.branch, reached.position, found)
        return self._known[reached.branch.id]

    def head(self, branch: Branch) -> Head | None:
        """Return the head of what was collected; None: the cell has not answered since the start."""
        known = self._known.get(branch.id)
        return None if known is None else known.head

    async def head_at(self, branch: Branch, link: int) -> Head:
        """Return the head of what was collected as it was at a link."""
        return head_of(link, await self._heads(branch, link))

    async def keep(self, branch: Branch, page: Sequence[CollectedLink], clock: ClockSeen | None) -> None:
        """Keep links that follow what was collected, all or none.

        Raises CollectedMeanwhileError where they do not follow, ConflictError where they cannot be kept.
        """
        await self._database.write(lambda connection: _keep(connection, branch, page, clock))
        known = self._known_at(Reached(branch, page[0].link - 1))
        # Only now, and only from where it was known: a page that was refused must leave the old position.
        if known is not None:
            after = {**known.heads, **{link.stream: link.hash for link in page}}
            self._known[branch.id] = CollectionProgress(branch, page[-1].link, after)

    async def accept_other_chain(self, cell: str, person: str, reason: str) -> None:
        """Collect the other chain that a cell shows into a branch of its own, once; raises ConflictError."""
        known = await self.collected(await self.reached(cell))
        await self._database.write(lambda connection: _accept(connection, cell, known, person, reason))

    async def accepted_branches(self, cell: str) -> list[AcceptedBranch]:
        """Return the chains of a cell that somebody accepted, the newest first; raises NotInPlantError."""
        return await self._database.read(lambda connection: accepted_branches(connection, cell))

    async def content(self, branch_id: int, record: str, record_id: int) -> str | None:
        """Return a record as it came, as JSON with typed values; None: it was not collected."""
        wanted = (plant_journal.c.record == record) & (plant_journal.c.record_id == record_id)
        query = select(plant_journal.c.content).where(plant_journal.c.branch_id == branch_id, wanted)
        return await self._value(query)

    async def _heads(self, branch: Branch, at: int) -> Mapping[int, bytes]:
        async with self._reading:
            return await self._database.read(lambda connection: heads(connection, branch, at))

    def _known_at(self, reached: Reached) -> CollectionProgress | None:
        known = self._known.get(reached.branch.id)
        return known if known is not None and known.position == reached.position else None


def _enter(connection: Connection, cells: Sequence[str]) -> None:
    for cell in cells:
        enter_cell(connection, cell)


def _reached(connection: Connection, cell: str) -> Reached:
    branch = newest_branch(connection, cell_number(connection, cell))
    return Reached(branch, position(connection, branch))


def _keep(
    connection: Connection, branch: Branch, page: Sequence[CollectedLink], clock: ClockSeen | None
) -> None:
    # In the writing transaction: two visits to one cell may have read the same position.
    follows = position(connection, branch) + 1
    if not page or page[0].link != follows:
        raise CollectedMeanwhileError(
            f"Link {follows} comes next; another collection has taken place in the meantime."
        )
    rows = [{"branch_id": branch.id, **to_row(link, plant_journal)} for link in page]
    add_rows(connection, plant_journal, rows)
    # In the same transaction: what can be looked up never lacks a link that is kept, nor knows one that is
    # not.
    project(connection, branch, page, clock)


def _accept(connection: Connection, cell: str, known: CollectionProgress, person: str, reason: str) -> None:
    number = cell_number(connection, cell)
    seen = newest_visit(connection, number)
    if seen is None or seen.visit.outcome is not Outcome.ANOTHER_CHAIN or seen.visit.fork is None:
        raise ConflictError(
            f"{cell} still has the chain that was collected from it; there is no other to accept."
        )
    branch = newest_branch(connection, number)
    # The person accepted what that visit saw. Until the next one the newest visit still shows another chain,
    # and a second acceptance would collect the same links twice (commit fa77a2ba).
    if branch != known.branch or seen.visit.head != known.head.text:
        raise ConflictError(
            f"The other chain of {cell} was accepted already, and is being collected; check again after the "
            "next collection."
        )
    add_branch(connection, branch, seen.visit.fork, person, reason)


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


class JournalLines(Repository):
    """All queries that read journals line by line."""

    async def of(self, cell: str, page: Page, record: str | None = None) -> Part[JournalLine]:
        """Return lines of a cell in the order of collecting, of one kind of record or of all.

        As many as the page wants, fewer where their records are large, one at least where there is any.
        """
        return await self._database.read(lambda connection: _lines(connection, cell, page, record))


def _lines(connection: Connection, cell: str, page: Page, record: str | None) -> Part[JournalLine]:
    query = _of_cell(cell, record)
    total = connection.scalar(query.with_only_columns(func.count(), maintain_column_froms=True)) or 0
    behind = query.where(plant_journal.c.id > page.after).order_by(plant_journal.c.id)
    # Sizes first: a campaign alone may have as many characters as a page, and a hundred of them would not
    # have room in memory.
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
    content = None if row.content is None else json.loads(row.content)
    return from_row(JournalLine, row, branch=row.branch_id, row=content)
