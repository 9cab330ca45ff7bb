"""The journal of a plant: each link of each cell once, in the order of the cell's chain, page by page.

A page, what follows from it and how far the cell was collected are one transaction: the position is the
newest link itself, so that nothing can be kept without it, or it without what it stands for.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy import Connection, select

from truepose.storage.database import Database
from truepose.storage.errors import ConflictError
from truepose.storage.integrity.head import Head, head_of
from truepose.storage.plant.chains import add_branch, cell_number, heads, newest_branch, position
from truepose.storage.plant.projections import project
from truepose.storage.plant.records import Branch, ClockSeen, CollectedLink, Outcome
from truepose.storage.plant.visits import newest_visit
from truepose.storage.rows import add_row
from truepose.storage.tables.of_plants import plant_journal


@dataclass(frozen=True, slots=True)
class Collected:
    """How far a cell was collected, and what the next links rest on."""

    branch: Branch
    position: int
    heads: Mapping[int, bytes]

    @property
    def head(self) -> Head:
        """The head of what was collected, as the cell's reports print it."""
        return head_of(self.position, self.heads)


class JournalRepository:
    """All queries about journals."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._known: dict[int, Collected] = {}  # by branch

    async def enter(self, cell: str) -> None:
        """Enter a cell where it is new."""
        await self._database.write(lambda connection: cell_number(connection, cell))

    async def collected(self, cell: str) -> Collected:
        """Return how far a cell was collected; it was entered."""
        found = await self._database.read(lambda connection: _collected(connection, cell, self._known))
        self._known[found.branch.id] = found
        return found

    async def head_at(self, branch: Branch, link: int) -> Head:
        """Return the head of what was collected as it was at a link."""
        return await self._database.read(lambda c: head_of(link, heads(c, branch, link)))

    async def keep(self, branch: Branch, page: Sequence[CollectedLink], clock: ClockSeen | None) -> None:
        """Keep links that follow what was collected, all or none; raises ConflictError where they do not."""
        await self._database.write(lambda connection: _keep(connection, branch, page, clock))

    async def accept_other_chain(self, cell: str, person: str, reason: str) -> None:
        """Collect the other chain that a cell shows into a branch of its own; raises ConflictError."""
        await self._database.write(lambda connection: _accept(connection, cell, person, reason))

    async def content(self, branch_id: int, record: str, record_id: int) -> str | None:
        """Return a record as it came, as JSON with typed values; None: it was not collected."""
        wanted = (plant_journal.c.record == record) & (plant_journal.c.record_id == record_id)
        query = select(plant_journal.c.content).where(plant_journal.c.branch_id == branch_id, wanted)
        return await self._database.read(lambda connection: connection.scalar(query))


def _collected(connection: Connection, cell: str, known: Mapping[int, Collected]) -> Collected:
    """Return how far a cell was collected; `heads` reads a whole chain, and what was kept never changes."""
    branch = newest_branch(connection, cell_number(connection, cell))
    newest, before = position(connection, branch), known.get(branch.id)
    if before is not None and before.position == newest:
        return before
    return Collected(branch, newest, heads(connection, branch))


def _keep(
    connection: Connection, branch: Branch, page: Sequence[CollectedLink], clock: ClockSeen | None
) -> None:
    follows = position(connection, branch) + 1
    if not page or page[0].link != follows:
        raise ConflictError(f"Link {follows} comes next; somebody has collected meanwhile.")
    for link in page:
        add_row(
            connection,
            plant_journal,
            branch_id=branch.id,
            link=link.link,
            stream=link.stream,
            record=link.record,
            record_id=link.record_id,
            hash=link.hash,
            content=link.content,
            verified=int(link.verified),
        )
    project(connection, branch, page, clock)


def _accept(connection: Connection, cell: str, person: str, reason: str) -> None:
    number = cell_number(connection, cell)
    seen = newest_visit(connection, number)
    if seen is None or seen.visit.outcome is not Outcome.ANOTHER_CHAIN or seen.visit.fork is None:
        raise ConflictError(
            f"{cell} shows the chain that was collected from it; there is no other to accept."
        )
    branch = newest_branch(connection, number)
    add_branch(connection, branch, seen.visit.fork, person, reason)
