"""The one sentence that a plan begins with: error before and predicted after, and whether a limit is kept."""

from truepose.messages.message import Message, message
from truepose.planning.prediction.plan import PromisedPlan


def plan_outcome(
    plan: PromisedPlan, nominal_mm: float | None = None, limit_mm: float | None = None
) -> Message:
    """Return the mean error before and after measuring, with what is predicted of a limit.

    Parameters
    ----------
    plan : PromisedPlan
    nominal_mm : float, optional
        Mean error of the nominal robot on what was measured before; None: nothing was, and nobody knows it.
    limit_mm : float, optional
        That the largest error in the work volume is to stay within.
    """
    before = message("outcome.plan.unknown")
    if nominal_mm is not None:
        before = message("outcome.error", error_mm=nominal_mm)
    judged = message("outcome.plan.no_limit") if limit_mm is None else _judged(plan, limit_mm)
    return message("outcome.plan", before=before, after_mm=plan.promised.mean_mm, n=plan.total, judged=judged)


def _judged(plan: PromisedPlan, limit_mm: float) -> Message:
    largest_mm = plan.promised.worst_mm
    return message(
        "outcome.plan.largest", largest_mm=largest_mm, limit_mm=limit_mm, judged=_kept(plan, limit_mm)
    )


def _kept(plan: PromisedPlan, limit_mm: float) -> Message:
    """Return whether a plan promises to keep a limit; where it does not, how many configurations do."""
    if plan.promised.worst_mm <= limit_mm:
        return message("outcome.plan.pass")
    enough = (point.n for point in plan.curve if point.n > plan.total and point.worst_mm <= limit_mm)
    more = next(enough, None)
    if more is None:
        return message("outcome.plan.fail", most=plan.curve[-1].n)
    return message("outcome.plan.more", more=more)
