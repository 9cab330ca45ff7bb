"""Ratios of errors over many robots."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tests.studies.report_command import informing, target_row
from truepose.reports.table_report import Row, Verdict


@dataclass(frozen=True, slots=True)
class Ratio:
    """What one error is of another, over n robots."""

    mean: float  # of the robots' own ratios; NaN without any robot
    standard_error: float  # NaN with fewer than two
    of_means: float  # mean of the one errors over mean of the others
    robots: int


def ratio_of(pairs: Sequence[tuple[float, float]]) -> Ratio:
    """Return the ratio of the first of each pair to the second."""
    if not pairs:
        return Ratio(math.nan, math.nan, math.nan, 0)
    first, second = np.array(pairs).T
    own, n = first / second, len(pairs)
    standard_error = float(own.std(ddof=1) / np.sqrt(n)) if n > 1 else math.nan
    return Ratio(float(own.mean()), standard_error, float(first.mean() / second.mean()), n)


def ratio_row(figure: str, ratio: Ratio, limit: float | None = None) -> Row:
    """Return a ratio beside the limit that its mean over robots must not exceed, where there is one."""
    measured = (
        f"{ratio.mean:.3f} ± {ratio.standard_error:.3f} "
        f"(ratio of the means {ratio.of_means:.3f}; {ratio.robots} robots)"
    )
    target = "" if limit is None else f"<= {limit:.2f}"
    if not ratio.robots:
        verdict = Verdict.NO_TARGET if limit is None else Verdict.NOT_MEASURED
        return Row(figure, target, "no robot", verdict)
    if limit is None:
        return informing(figure, measured)
    return target_row(figure, target, measured, ratio.mean <= limit)
