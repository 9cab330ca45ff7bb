"""What configurations promise, worked out in a worker process: it takes seconds of a processor."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from truepose.analysis.campaigns.assembly import MeasuredSession
from truepose.domain.cell.description import Cell

if TYPE_CHECKING:
    from truepose.analysis.promises import Promised


@dataclass(frozen=True, slots=True)
class PromiseTask:
    """Say what `n` configurations promise in a cell, or beside those that a session has measured."""

    of: Cell | MeasuredSession
    n: int | None  # None: as many as the knee of the curve says

    def perform(self, report: Callable[[float, str], None]) -> "Promised":
        """Return the plan and what it is of; raises TrueposeError."""
        from truepose.analysis.promises import promise_of_cell, promise_of_session

        report(0.0, "choosing configurations")
        if isinstance(self.of, Cell):
            return promise_of_cell(self.of, self.n)
        return promise_of_session(self.of, self.n)
