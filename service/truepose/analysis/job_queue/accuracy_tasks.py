"""What configurations of a cell or of a session under way promise, worked out in a worker process."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from truepose.analysis.campaigns.tracker import MeasuredSession
from truepose.domain.cell import Cell
from truepose.messages.message import Text, message

if TYPE_CHECKING:
    from truepose.analysis.predicted_accuracy import Promised


@dataclass(frozen=True, slots=True)
class PromiseTask:
    """Say what `n` configurations promise in a cell, or beside those that a session has measured."""

    of: Cell | MeasuredSession
    n: int | None  # None: as many as the knee of the curve says

    def perform(self, report: Callable[[float, Text], None]) -> "Promised":
        """Return the plan and what it is of; raises TrueposeError."""
        from truepose.analysis.predicted_accuracy import promise_of_cell, promise_of_session

        report(0.0, message("job.doing.choosing"))
        if isinstance(self.of, Cell):
            return promise_of_cell(self.of, self.n)
        return promise_of_session(self.of, self.n)


@dataclass(frozen=True, slots=True)
class ExpectedAccuracy:
    """Errors of position in the work space that so many configurations promise, once they are corrected."""

    configurations: int
    mean_mm: float
    worst_mm: float


@dataclass(frozen=True, slots=True)
class SessionForecast:
    """What can be expected of a session."""

    now: ExpectedAccuracy  # of what was measured
    at_end: ExpectedAccuracy  # once as many more are measured as are left


@dataclass(frozen=True, slots=True)
class OutlookTask:
    """Say what a session promises; `left` configurations are still to be measured."""

    session: MeasuredSession
    left: int

    def perform(self, report: Callable[[float, Text], None]) -> SessionForecast:
        """Return what can be expected; raises TrueposeError."""
        from truepose.analysis.predicted_accuracy import promise_of_session

        report(0.0, message("job.doing.promise"))
        # At least one more: the curve of a session that is complete still tells what it has come to.
        plan = promise_of_session(self.session, max(1, self.left)).plan
        points = [ExpectedAccuracy(one.n, one.mean_mm, one.worst_mm) for one in plan.curve]
        now = next(point for point in points if point.configurations >= plan.measured)
        at_end = next(point for point in points if point.configurations >= plan.total)
        return SessionForecast(now, at_end if self.left else now)
