"""Collects from cells: one visit after another, each verified and kept page by page.

However a visit ends, what was kept of it is whole, and the next one goes on behind it.
"""

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from truepose.exchange.cells.plant import PlantCell
from truepose.plant.cell_client import CellClient, CellHead, clock_seen
from truepose.plant.chain_verification import verify_page
from truepose.plant.errors import CellAnswerError, CellSilentError
from truepose.storage.errors import (
    AnotherChainError,
    CollectedMeanwhileError,
    ConflictError,
    StorageUnavailableError,
    TamperedRecordError,
    UnreadableRowError,
)
from truepose.storage.plant.cells import VisitRepository
from truepose.storage.plant.deployments import HandDownRepository
from truepose.storage.plant.journal import CollectionProgress, JournalRepository, Reached
from truepose.storage.plant.records import Branch, ClockSeen, HandDownState, Outcome, Visit

_LOG: Final = logging.getLogger(__name__)
_TIMES_ASKED: Final = 3  # for the time: one answer may come late
_LINKS: Final = 500  # a page


@dataclass(frozen=True, slots=True)
class PlantRepositories:
    """What a visit writes into."""

    journal: JournalRepository
    hand_downs: HandDownRepository


async def visit(name: str, cell: CellClient, shelves: PlantRepositories) -> Visit:
    """Visit a cell and return what came of it; nothing is raised for what a cell can do wrong.

    Raises StorageError where the plant itself cannot keep what it collects, or has collected meanwhile.
    """
    begun = Visit(Outcome.WHOLE)
    reached = await shelves.journal.reached(name)
    try:
        head, clock = await _greeted(cell, reached)
        begun = replace(begun, clock=clock, newest=head.newest, version=head.version, schema=head.schema)
        # Only once the cell has answered: read for 40 cells that were away, the newest hash of every stream
        # held up the plant's first page for 8 to 15 s (commit b31a704e).
        known = await shelves.journal.collected(reached)
        begun = replace(begun, head=known.head.text)
        if head.newest < known.position or head.head != known.head.text:
            return await _another_chain(name, cell, known, shelves, begun)
        return await _collected(name, cell, known, shelves, begun)
    except CellAnswerError as error:
        return _so_far(shelves, reached.branch, begun, Outcome.UNREACHABLE, error)
    except (TamperedRecordError, UnreadableRowError) as error:
        return _so_far(shelves, reached.branch, begun, Outcome.REFUSED, error)
    except CollectedMeanwhileError:
        raise
    except ConflictError as error:
        _LOG.warning("a page of %s was refused", name, exc_info=True)
        # Taken for a page that somebody else had collected, such a record left no line and no visit
        # (33fac5c5).
        unfit = ConflictError(f"{name} sends records that cannot be stored here: {error}")
        return _so_far(shelves, reached.branch, begun, Outcome.REFUSED, unfit)


async def _greeted(cell: CellClient, reached: Reached) -> tuple[CellHead, ClockSeen]:
    heads = [await cell.head(reached.position) for _ in range(_TIMES_ASKED)]
    return heads[-1], clock_seen([head.clock for head in heads])


async def _collected(
    name: str, cell: CellClient, known: CollectionProgress, shelves: PlantRepositories, begun: Visit
) -> Visit:
    position, heads, newest = known.position, known.heads, begun.newest or 0
    while position < newest:
        page = await cell.links(position, _LINKS)
        # Off the loop: a page may have megabytes, and whoever looks at the plant waits for none of them.
        links, heads = await asyncio.to_thread(verify_page, page.lines, position, heads)
        if not links:
            raise CellAnswerError(f"{name} has {newest} links but sends none after link {position}.")
        await shelves.journal.keep(known.branch, links, begun.clock)
        position, newest = links[-1].link, page.newest
    waits = await _handed_down(name, cell, shelves.hand_downs)
    collected, head = position - known.position, CollectionProgress(known.branch, position, heads).head
    return replace(begun, sentence=waits, collected=collected, newest=newest, head=head.text)


async def _handed_down(name: str, cell: CellClient, hand_downs: HandDownRepository) -> str:
    """Hand down what waits, and return why some of it still does; empty: nothing does."""
    waits = ""
    for record in await hand_downs.waiting(name):
        try:
            handed = await cell.hand_down(record, f"hand-down-{record.id}-{record.recorded_at}")
        except CellAnswerError as error:
            # What a proxy, a missing right or an older version answers may pass: it keeps none of the others
            # behind it (commit 2c1645d5). A cell that is silent is asked for no more.
            waits = waits or f"All records are collected, but deployment {record.id} is waiting: {error}"
            if isinstance(error, CellSilentError):
                break
            continue
        state = HandDownState.REFUSED if handed.number is None else HandDownState.DELIVERED
        await hand_downs.note(record.id, state, handed.sentence, handed.number)
    return waits


def _so_far(
    shelves: PlantRepositories, branch: Branch, begun: Visit, outcome: Outcome, error: Exception
) -> Visit:
    head = shelves.journal.head(branch)
    return replace(begun, outcome=outcome, sentence=str(error), head=None if head is None else head.text)


async def _another_chain(
    name: str, cell: CellClient, known: CollectionProgress, shelves: PlantRepositories, begun: Visit
) -> Visit:
    """State that a cell shows another chain, and up to where the two are one."""
    common = await _last_in_common(
        cell, known.branch, min(known.position, begun.newest or 0), shelves.journal
    )
    error = AnotherChainError(
        f"{name} has a different chain from the one collected: {known.position} links were collected, of "
        f"which only the first {common} are still there unchanged. If a backup was restored or a disk "
        "replaced, accept the new chain; otherwise check which database the cell has open. Nothing is "
        "collected until then."
    )
    return replace(begun, outcome=Outcome.ANOTHER_CHAIN, sentence=str(error), fork=common)


async def _last_in_common(cell: CellClient, branch: Branch, most: int, journal: JournalRepository) -> int:
    """Return the last link up to which both chains are one: the two part once and never meet again."""
    common, parted = 0, most + 1
    while parted - common > 1:
        middle = (common + parted) // 2
        there = await cell.head(middle)
        same = there.head == (await journal.head_at(branch, middle)).text
        common, parted = (middle, parted) if same else (common, middle)
    return common


_TWICE: Final = 2.0  # as long, after each visit that came to nothing
_LONGEST_S: Final = 300.0
_APART_S: Final = 0.05


@dataclass(frozen=True, slots=True)
class Pace:
    """How long a cell is left alone between two visits."""

    every_s: float = 30.0
    first_retry_s: float = 2.0

    def pause_s(self, failures: int) -> float:
        """Return how long to wait after so many visits in a row that came to nothing."""
        if not failures:
            return self.every_s
        return min(self.first_retry_s * _TWICE ** min(failures - 1, 20), _LONGEST_S)

    def apart_s(self, cells: int) -> float:
        """Return how long after one cell the next of so many is visited first: pages come in between."""
        return min(_APART_S, self.every_s / cells)


class Collector:
    """Visits the cells of a plant."""

    def __init__(
        self, cells: Sequence[PlantCell], shelves: PlantRepositories, visits: VisitRepository, pace: Pace
    ) -> None:
        self.cells = tuple(cells)
        self.has_ended = False  # no cell is visited any more
        self._asked = {cell.name: CellClient(cell) for cell in cells}
        self._shelves = shelves
        self._visits = visits
        self._pace = pace
        self._wanted = {cell.name: asyncio.Event() for cell in cells}

    def knows(self, name: str) -> bool:
        """Whether a cell stands in the cells file."""
        return name in self._asked

    def visit_soon(self, name: str) -> None:
        """Have a cell visited as soon as no visit is under way."""
        self._wanted[name].set()

    async def visit(self, name: str) -> Visit:
        """Visit a cell once and keep what came of it; raises StorageError."""
        asked, found = self._asked[name], None
        try:
            found = await visit(name, asked, self._shelves)
        finally:
            if found is None or found.sentence:
                await asked.close()  # another token, address or certificate may count at the next one
        await self._visits.keep(name, found)
        return found

    async def follow(self) -> None:
        """Visit every cell, which was entered, until cancelled."""
        try:
            async with asyncio.TaskGroup() as group:
                for place, cell in enumerate(self.cells):
                    first_s = place * self._pace.apart_s(len(self.cells))
                    group.create_task(self._follow(cell.name, first_s), name=f"cell {cell.name}")
        finally:
            self.has_ended = True
            for asked in self._asked.values():
                await asked.close()

    async def _follow(self, name: str, first_s: float) -> None:
        await asyncio.sleep(first_s)
        failures = 0
        while True:
            self._wanted[name].clear()
            failures = 0 if await self._went_well(name, failures) else failures + 1
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(self._pace.pause_s(failures)):
                    await self._wanted[name].wait()

    async def _went_well(self, name: str, failures: int) -> bool:
        try:
            found = await self.visit(name)
        except (StorageUnavailableError, CollectedMeanwhileError) as error:  # the plant's own disk
            _LOG.warning("the visit to %s could not be recorded: %s", name, error)
            return False
        except Exception as error:  # whatever a cell makes go wrong here, no other cell waits for it
            _LOG.exception("the visit to %s failed", name)
            await self._note_failed(name, error)
            return False
        if found.sentence:
            _LOG.warning("visit to %s: %s", name, found.sentence)
        elif failures:
            _LOG.info("visit to %s: collection works again, %d links collected", name, found.collected)
        return found.outcome is Outcome.WHOLE

    async def _note_failed(self, name: str, error: Exception) -> None:
        sentence = f"The visit to {name} failed in the plant service ({type(error).__name__}); see its log."
        try:
            await self._visits.keep(name, Visit(Outcome.REFUSED, sentence))
        except Exception:
            _LOG.exception("the failed visit to %s could not be recorded", name)


@contextlib.asynccontextmanager
async def collecting(collector: Collector) -> AsyncIterator[None]:
    """Have cells visited as long as the context lasts."""
    task = asyncio.create_task(collector.follow(), name="collector")
    try:
        yield
    finally:
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task
