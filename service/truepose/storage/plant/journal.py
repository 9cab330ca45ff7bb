"""The journal of a plant: each link of each cell once, in the order of the cell's chain, page by page.

A page, what follows from it and how far the cell was collected are one transaction: the position is the
newest link itself, so that nothing can be kept without it, or it without what it stands for.
"""

import asyncio
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Final

from sqlalchemy import Connection, select

from truepose.storage.database import Database
from truepose.storage.errors import CollectedMeanwhileError, ConflictError
from truepose.storage.integrity.head import Head, head_of
from truepose.storage.plant.chains import (
    accepted_branches,
    add_branch,
    all_branches,
    cell_number,
    enter_cell,
    heads,
    newest_branch,
    position,
)
from truepose.storage.plant.projections import project
from truepose.storage.plant.records import AcceptedBranch, Branch, ClockSeen, CollectedLink, Outcome
from truepose.storage.plant.told import tell_again, untold_links
from truepose.storage.plant.visits import newest_visit
from truepose.storage.rows import add_rows
from truepose.storage.tables.of_plants import plant_journal

_LOG: Final = logging.getLogger(__name__)
_CHAINS_AT_ONCE: Final = 1  # read for the first time: pages find a reader meanwhile
_RECORDS_AT_ONCE: Final = 20  # read again in one transaction: a campaign may have many megabytes


@dataclass(frozen=True, slots=True)
class Reached:
    """How far a cell was collected."""

    branch: Branch
    position: int  # newest link


@dataclass(frozen=True)
class Collected:
    """How far a cell was collected, and what the next links rest on."""

    branch: Branch
    position: int
    heads: Mapping[int, bytes]

    @cached_property
    def head(self) -> Head:
        """The head of what was collected, as the cell's reports print it."""
        return head_of(self.position, self.heads)


@dataclass(slots=True)
class CatchingUp:
    """How far records that were collected before are read again."""

    of: int
    done: int = 0

    def __str__(self) -> str:
        return (
            f"Records that an earlier version collected are read again, {self.done} of {self.of} so far; "
            "cells are visited afterwards."
        )


class JournalRepository:
    """All queries about journals.

    What the next links of a cell rest on is read once, when it first answers, and goes on with each page.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self._known: dict[int, Collected] = {}  # by branch
        self._reading = asyncio.Semaphore(_CHAINS_AT_ONCE)
        self.catching_up: CatchingUp | None = None  # while that lasts

    async def enter(self, *cells: str) -> None:
        """Enter cells where they are new."""
        await self._database.write(lambda connection: _enter(connection, cells))

    async def reached(self, cell: str) -> Reached:
        """Return how far a cell was collected; raises NotInPlantError for one that was never entered."""
        return await self._database.read(lambda connection: _reached(connection, cell))

    async def collected(self, reached: Reached) -> Collected:
        """Return what the next links of a cell rest on."""
        known = self._known_at(reached)
        if known is not None:
            return known
        found = await self._heads(reached.branch, reached.position)
        self._known[reached.branch.id] = Collected(reached.branch, reached.position, found)
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
        if known is not None:
            after = {**known.heads, **{link.stream: link.hash for link in page}}
            self._known[branch.id] = Collected(branch, page[-1].link, after)

    async def catch_up(self) -> None:
        """Read again what an earlier version of this program collected and did not look into.

        To be done before the next page is kept. Where the process is killed the next one goes on behind the
        last records that it kept.
        """
        untold = {
            branch: await self._database.read(partial(untold_links, branch_id=branch.id))
            for branch in await self._database.read(all_branches)
        }
        doing = self.catching_up = CatchingUp(sum(map(len, untold.values())))
        if doing.of:
            _LOG.info("%s", doing)
        try:
            for branch, links in untold.items():
                for first in range(0, len(links), _RECORDS_AT_ONCE):
                    some = links[first : first + _RECORDS_AT_ONCE]
                    await self._tell_again(branch, some)
                    doing.done += len(some)
        finally:
            self.catching_up = None

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
        return await self._database.read(lambda connection: connection.scalar(query))

    async def _tell_again(self, branch: Branch, links: Sequence[int]) -> None:
        try:
            await self._database.write(partial(tell_again, branch=branch, links=links))
        except ConflictError as error:  # of what one of them tells: that one alone tells nothing
            if len(links) == 1:
                _LOG.warning("link %d of branch %d tells nothing (%s)", links[0], branch.id, error)
                return
            for link in links:
                await self._tell_again(branch, [link])

    async def _heads(self, branch: Branch, at: int) -> Mapping[int, bytes]:
        async with self._reading:
            return await self._database.read(lambda connection: heads(connection, branch, at))

    def _known_at(self, reached: Reached) -> Collected | None:
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
    follows = position(connection, branch) + 1
    if not page or page[0].link != follows:
        raise CollectedMeanwhileError(f"Link {follows} comes next; somebody has collected meanwhile.")
    add_rows(connection, plant_journal, [_row(branch, link) for link in page])
    project(connection, branch, page, clock)


def _row(branch: Branch, link: CollectedLink) -> dict[str, Any]:
    return {
        "branch_id": branch.id,
        "link": link.link,
        "stream": link.stream,
        "record": link.record,
        "record_id": link.record_id,
        "hash": link.hash,
        "content": link.content,
        "verified": int(link.verified),
    }


def _accept(connection: Connection, cell: str, known: Collected, person: str, reason: str) -> None:
    number = cell_number(connection, cell)
    seen = newest_visit(connection, number)
    if seen is None or seen.visit.outcome is not Outcome.ANOTHER_CHAIN or seen.visit.fork is None:
        raise ConflictError(
            f"{cell} shows the chain that was collected from it; there is no other to accept."
        )
    branch = newest_branch(connection, number)
    if branch != known.branch or seen.visit.head != known.head.text:
        raise ConflictError(
            f"The other chain of {cell} was accepted already, and is being collected; look again after the "
            "next visit."
        )
    add_branch(connection, branch, seen.visit.fork, person, reason)
