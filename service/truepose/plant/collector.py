"""Visits every cell again and again, each in a loop of its own: one that is silent holds up no other."""

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass
from typing import Final

from truepose.exchange.cells.of_plant import PlantCell
from truepose.plant.asking import AskedCell
from truepose.plant.visit import Shelves, visit
from truepose.storage.errors import CollectedMeanwhileError, StorageError, StorageUnavailableError
from truepose.storage.plant.records import Outcome, Visit
from truepose.storage.plant.visits import VisitRepository

_LOG: Final = logging.getLogger(__name__)
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
        self, cells: Sequence[PlantCell], shelves: Shelves, visits: VisitRepository, pace: Pace
    ) -> None:
        self.cells = tuple(cells)
        self.has_ended = False  # no cell is visited any more
        self._asked = {cell.name: AskedCell(cell) for cell in cells}
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
            await self._catch_up()
            async with asyncio.TaskGroup() as group:
                for place, cell in enumerate(self.cells):
                    first_s = place * self._pace.apart_s(len(self.cells))
                    group.create_task(self._follow(cell.name, first_s), name=f"cell {cell.name}")
        finally:
            self.has_ended = True
            for asked in self._asked.values():
                await asked.close()

    async def _catch_up(self) -> None:
        while True:
            try:
                return await self._shelves.journal.catch_up()
            except StorageError as error:  # the plant's own disk
                _LOG.warning("what was collected before was not looked into: %s", error)
            except Exception:
                _LOG.exception("what was collected before was not looked into")
            await asyncio.sleep(self._pace.every_s)

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
            _LOG.warning("the visit to %s was not kept: %s", name, error)
            return False
        except Exception as error:  # whatever a cell makes go wrong here, no other cell waits for it
            _LOG.exception("the visit to %s failed", name)
            await self._note_failed(name, error)
            return False
        if found.sentence:
            _LOG.warning("visit to %s: %s", name, found.sentence)
        elif failures:
            _LOG.info("visit to %s: all is collected again, %d links came", name, found.collected)
        return found.outcome is Outcome.WHOLE

    async def _note_failed(self, name: str, error: Exception) -> None:
        sentence = f"The visit to {name} failed in the plant ({type(error).__name__}); its log says where."
        try:
            await self._visits.keep(name, Visit(Outcome.REFUSED, sentence))
        except Exception:
            _LOG.exception("that the visit to %s failed was not kept", name)


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
