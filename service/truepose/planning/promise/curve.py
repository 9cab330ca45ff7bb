"""The curve of promised accuracy against the number of configurations, and its knee."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.planning.promise.spread import Discrepancy, mean_norms, spread

FEWEST: Final = 11  # configurations that the thesis of A. Nubiola begins its choice with, section 2.5.2
STEP: Final = 10
MOST: Final = 100
# Ten more that gain less than a tenth of the error: the interval of one calibration reaches a quarter to
# either side, so that nobody could show the gain by one validation.
WORTH: Final = 0.1


@dataclass(frozen=True, slots=True)
class CurvePoint:
    """The accuracy that a number of configurations promises: norms of position errors over the volume."""

    n: int
    mean_mm: float
    worst_mm: float  # the largest that one calibration has anywhere in the volume, on average
    interval_90_mm: tuple[float, float]  # nine calibrations of ten have their mean error within
    visit_mean_mm: float  # the mean with the arm's own scatter at every visit


@dataclass(frozen=True, slots=True)
class Errors:
    """How errors follow from the number of configurations."""

    after: Callable[[int], FloatArray]  # -> (m, 3, S), what each independent cause does at m places [mm]
    discrepancy: Discrepancy
    repeatability_mm: float  # per axis, of the arm


def sizes(n: int | None, available: int, measured: int = 0) -> tuple[int, ...]:
    """Return the numbers of configurations that a curve is given for.

    Parameters
    ----------
    n : int or None
        A number that was asked for.
    available : int
        Configurations that can be measured, those `measured` already included.
    measured : int
        The curve begins there where something was measured.
    """
    first = measured + STEP if measured else 2 * STEP
    wanted = {max(FEWEST, measured), *range(first, measured + MOST + 1, STEP), *([] if n is None else [n])}
    return tuple(sorted({min(size, available) for size in wanted}))


def curve(errors: Errors, numbers: Sequence[int]) -> tuple[CurvePoint, ...]:
    """Return the curve at ascending numbers of configurations."""
    return tuple(_point(errors, n) for n in numbers)


def _point(errors: Errors, n: int) -> CurvePoint:
    after = errors.after(n)
    found = spread(after, errors.discrepancy)
    visited = float(np.hypot(errors.discrepancy.per_axis_mm, errors.repeatability_mm))
    visit = float(mean_norms(after, visited).mean())
    return CurvePoint(n, found.mean_mm, found.worst_mm, found.interval_90_mm, visit)


def gains_mm(points: Sequence[CurvePoint]) -> tuple[float, ...]:
    """Return what each step of the curve gains in the mean error [mm]; one fewer than there are points."""
    return tuple(before.mean_mm - after.mean_mm for before, after in pairwise(points))


def knee(points: Sequence[CurvePoint]) -> int:
    """Return the first number after which ten more would gain less than a tenth of the mean error.

    Steps of another length are counted as if they were of ten. Where every step gains more, the last.
    """
    for before, after in pairwise(points):
        gained = (before.mean_mm - after.mean_mm) * STEP / (after.n - before.n)
        if before.n > FEWEST and gained < WORTH * before.mean_mm:
            return before.n
    return points[-1].n
