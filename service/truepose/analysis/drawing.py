"""Who draws reports: one worker at a time, so that a session under way keeps the other core."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from truepose.analysis.kept import KeptDrawings
from truepose.analysis.workers.drawing import DrawTask
from truepose.analysis.workers.process import Perform
from truepose.analysis.workers.turns import Turns

T = TypeVar("T")
A = TypeVar("A", str, bytes)


class DrawingDesk:
    """Has reports drawn and printed."""

    def __init__(self, perform: Perform, kept: KeptDrawings) -> None:
        self.kept = kept
        self._perform = perform
        self._turns = Turns("reports", at_once=1, waiting=8, patience_s=60.0)

    async def draw(self, function: Callable[[T], A], of: T) -> A:
        """Call a function of a module in a worker process; raises BusyError, TaskRefusedError."""
        async with self._turns.taken():
            return cast(A, await self._perform(DrawTask(function, of), _unheard))


async def _unheard(_fraction: float, _doing: Any) -> None:
    """Nobody watches a report being made: it takes seconds."""
