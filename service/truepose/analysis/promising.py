"""Who works out what configurations promise: one worker at a time, which ends when nobody waits any more."""

from typing import TYPE_CHECKING, Any, cast

from truepose.analysis.campaigns.assembly import MeasuredSession
from truepose.analysis.workers.process import Perform
from truepose.analysis.workers.promising import PromiseTask
from truepose.analysis.workers.turns import Turns
from truepose.domain.cell.description import Cell

if TYPE_CHECKING:
    from truepose.analysis.promises import Promised


class PromiseDesk:
    """Has promises worked out."""

    def __init__(self, perform: Perform) -> None:
        self._perform = perform
        self._turns = Turns("plans", at_once=1, waiting=4, patience_s=60.0)

    async def promise(self, of: Cell | MeasuredSession, n: int | None) -> "Promised":
        """Return what n configurations promise; raises BusyError, TaskRefusedError."""
        async with self._turns.taken():
            return cast("Promised", await self._perform(PromiseTask(of, n), _unheard))


async def _unheard(_fraction: float, _doing: Any) -> None:
    """Nobody watches a promise being worked out: it takes seconds."""
