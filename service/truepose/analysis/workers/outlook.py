"""What the readings of a session under way promise, and what the rest of its plan will add."""

from collections.abc import Callable
from dataclasses import dataclass

from truepose.analysis.campaigns.assembly import MeasuredSession


@dataclass(frozen=True, slots=True)
class ExpectedAccuracy:
    """Errors of position in the work space that so many configurations promise, once they are corrected."""

    configurations: int
    mean_mm: float
    worst_mm: float


@dataclass(frozen=True, slots=True)
class Outlook:
    """What can be expected of a session."""

    now: ExpectedAccuracy  # of what was measured
    at_end: ExpectedAccuracy  # once as many more are measured as are left


@dataclass(frozen=True, slots=True)
class OutlookTask:
    """Say what a session promises; `left` configurations are still to be measured."""

    session: MeasuredSession
    left: int

    def perform(self, report: Callable[[float, str], None]) -> Outlook:
        """Return what can be expected; raises TrueposeError."""
        from truepose.analysis.promises import promise_of_session

        report(0.0, "looking what the readings promise")
        plan = promise_of_session(self.session, max(1, self.left)).plan
        points = [ExpectedAccuracy(one.n, one.mean_mm, one.worst_mm) for one in plan.curve]
        now = next(point for point in points if point.configurations >= plan.measured)
        at_end = next(point for point in points if point.configurations >= plan.total)
        return Outlook(now, at_end if self.left else now)
