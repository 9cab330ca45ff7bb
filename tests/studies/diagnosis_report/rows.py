"""Figures of the report beside their targets."""

import math
from collections.abc import Callable, Sequence

from tests.studies.diagnosis_report import tallies
from tests.studies.diagnosis_report.judging import Outcome
from tests.studies.report_command import target_row
from truepose.reports.table_report import Row, Verdict

Tally = Callable[[Sequence[Outcome]], float]


def at_least(figure: str, limit: float, outcomes: Sequence[Outcome], tally: Tally) -> Row:
    """Return a share that must reach a limit."""
    measured = tally(outcomes)
    return _share(figure, f">= {100 * limit:g} %", measured, measured >= limit)


def at_most(figure: str, limit: float, outcomes: Sequence[Outcome], tally: Tally) -> Row:
    """Return a share that must not exceed a limit."""
    measured = tally(outcomes)
    return _share(figure, f"<= {100 * limit:g} %", measured, measured <= limit)


def between(figure: str, low: float, high: float, outcomes: Sequence[Outcome], tally: Tally) -> Row:
    """Return a share that must lie between two limits."""
    measured = tally(outcomes)
    return _share(figure, f"{100 * low:g}-{100 * high:g} %", measured, low <= measured <= high)


def ratio_at_most(figure: str, limit: float, outcomes: Sequence[Outcome], tally: Tally) -> Row:
    """Return a ratio that must not exceed a limit."""
    measured = tally(outcomes)
    if math.isnan(measured):
        return Row(figure, f"<= {limit:g}", "no campaign", Verdict.NOT_MEASURED)
    return target_row(figure, f"<= {limit:g}", f"{measured:.3f}", measured <= limit)


def no_faults(outcomes: Sequence[Outcome]) -> Row:
    """Return how many diagnoses ended with an error."""
    sentences = tallies.faults(outcomes)
    measured = "; ".join([str(len(sentences)), *sentences[:3]])
    return target_row("diagnoses that ended with an error", "0", measured, not sentences)


def _share(figure: str, target: str, measured: float, good: bool) -> Row:
    if math.isnan(measured):
        return Row(figure, target, "no campaign", Verdict.NOT_MEASURED)
    return target_row(figure, target, f"{100 * measured:.1f} %", good)
