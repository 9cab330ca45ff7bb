"""What pages ask of workers beside jobs: renderings, made once and kept, and predicted accuracy."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, TypeAlias, TypeVar, cast

from truepose.analysis.campaigns.tracker import MeasuredSession
from truepose.analysis.job_queue.accuracy_tasks import PromiseTask
from truepose.analysis.job_queue.supervisor import Perform, Turns, unheard
from truepose.analysis.job_queue.tasks import DrawTask
from truepose.domain.cell import Cell
from truepose.storage.caches import DrawnFolder, RenderedPage, rendered_page
from truepose.version import program_sha256

if TYPE_CHECKING:
    from truepose.analysis.predicted_accuracy import Promised


Draw: TypeAlias = Callable[[], Awaitable[str | bytes]]


class RenderCache:
    """Has what follows from records drawn once, by each version of the program."""

    def __init__(self, folder: DrawnFolder) -> None:
        self._folder = folder
        self._turns = Turns(at_once=2, waiting=32, patience_s=60.0)
        self._under_way: dict[str, asyncio.Task[RenderedPage]] = {}

    def drawing(self, of: str, draw: Draw) -> asyncio.Task[RenderedPage]:
        """Return the drawing of something, under way or kept; it goes on where nobody waits for it.

        Parameters
        ----------
        of : str
            All that the drawing follows from: kind, number and moment of a record, language, what was chosen.
        draw : callable
            Draws it.
        """
        # Two who ask at once share a drawing, and one who goes away leaves it to the next (decision 0060).
        task = self._under_way.get(of)
        if task is None:
            task = self._under_way[of] = asyncio.create_task(self._drawn(of, draw), name="drawing")
            task.add_done_callback(lambda done: self._ended(of, done))
        return task

    async def drawn(self, of: str, draw: Draw) -> RenderedPage:
        """Return what was drawn of something, once it is there; raises what `draw` raises, and BusyError."""
        # Cancelled is who waits, not what others wait for.
        return await asyncio.shield(self.drawing(of, draw))

    async def close(self) -> None:
        """Give up what is being drawn."""
        left = list(self._under_way.values())
        for task in left:
            task.cancel()
        await asyncio.gather(*left, return_exceptions=True)

    async def _drawn(self, of: str, draw: Draw) -> RenderedPage:
        # Another version may draw otherwise: with its hash in the name it never finds what this one drew.
        named = f"{await asyncio.to_thread(program_sha256)}\n{of}"
        # Before a turn is taken: what is kept is shown even while two others are being drawn.
        kept = await asyncio.to_thread(self._folder.get, named)
        if kept is not None:
            return kept
        async with self._turns.taken():
            made = await draw()
        drawn = rendered_page(made if isinstance(made, bytes) else made.encode())
        await asyncio.to_thread(self._folder.keep, named, drawn)
        return drawn

    def _ended(self, of: str, task: asyncio.Task[RenderedPage]) -> None:
        del self._under_way[of]
        if not task.cancelled():
            task.exception()  # told to whoever waits; nobody else has to hear of it


T = TypeVar("T")
A = TypeVar("A", str, bytes)


class Renderer:
    """Has reports drawn and printed."""

    def __init__(self, perform: Perform, kept: RenderCache) -> None:
        self.kept = kept
        self._perform = perform
        self._turns = Turns(at_once=1, waiting=8, patience_s=60.0)

    async def draw(self, function: Callable[[T], A], of: T) -> A:
        """Call a function of a module in a worker process; raises BusyError, TaskRefusedError."""
        async with self._turns.taken():
            return cast(A, await self._perform(DrawTask(function, of), unheard))


class AccuracyService:
    """Has promises worked out."""

    def __init__(self, perform: Perform) -> None:
        self._perform = perform
        self._turns = Turns(at_once=1, waiting=4, patience_s=60.0)

    async def promise(self, of: Cell | MeasuredSession, n: int | None) -> "Promised":
        """Return what n configurations promise; raises BusyError, TaskRefusedError."""
        async with self._turns.taken():
            return cast("Promised", await self._perform(PromiseTask(of, n), unheard))
