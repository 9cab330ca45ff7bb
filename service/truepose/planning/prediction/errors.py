r"""Predicted errors of a calibrated model over a work volume, and their curve over the configurations.

The errors of one calibration are one draw: e(x) = B(x) z + d(x), with z standard normal and common to all
places x (parameters, certificates, registration), and d of independent places (what no parameter expresses).
So the mean of |e| over the volume is itself a random figure. Its expectation has no closed form, but with
z = r u, r the length and u the direction of a normal vector of three components,

    E|e(x)| = 2 sqrt(2 / pi) * mean over directions u of sqrt(u' S u),        S = B B' + d^2 I

which never rises where S falls. Its quantiles, and the largest error to be found, come from draws.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray

DRAWS: Final = 600  # calibrations: the ends of the interval are right to about two parts in a hundred
BAND: Final = 0.90
_DIRECTIONS: Final = 200  # over half a sphere: means right to a part in a thousand
_SEED: Final = 2026  # the same plan promises the same


@dataclass(frozen=True, slots=True)
class Discrepancy:
    """What no parameter expresses: drawn at every place anew, of a size that is itself not known for sure.

    Attributes
    ----------
    per_axis_mm : float
        Standard deviation per axis.
    known_to : float
        Relative standard deviation of that figure from arm to arm [1].
    """

    per_axis_mm: float = 0.0
    known_to: float = 0.0


NONE: Final = Discrepancy()  # of an arm that the parameters describe wholly


@dataclass(frozen=True, slots=True)
class Spread:
    """Errors to expect over a volume: norms [mm]."""

    mean_mm: float  # expectation of the mean over the volume
    worst_mm: float  # expectation of the largest in the volume
    interval_90_mm: tuple[float, float]  # nine calibrations of ten have their mean within


def mean_norms(errors: FloatArray, own_mm: float) -> FloatArray:
    """Return the expected norm of the error at each place, without draws.

    E|e| = 2 sqrt(2 / pi) mean over directions u of sqrt(u' S u): a normal vector of three components has the
    mean length 2 sqrt(2 / pi), and u' S u is the variance along u. The mean is taken over half a sphere, as u
    and -u give the same.

    Parameters
    ----------
    errors : ndarray, shape (m, 3, S)
        What a standard deviation of each of S independent causes does at m places [mm].
    own_mm : float
        Standard deviation per axis of what is drawn at each place anew.

    Returns
    -------
    ndarray, shape (m,)
        [mm].

    References
    ----------
    Own derivation, from the independence of length and direction of a standard normal vector.
    """
    covariance = errors @ np.swapaxes(errors, 1, 2) + own_mm**2 * np.eye(3)
    ways = _half_sphere()
    squared = np.einsum("ki,mij,kj->mk", ways, covariance, ways, optimize=True)
    return np.asarray(2.0 * np.sqrt(2.0 / np.pi) * np.sqrt(np.maximum(squared, 0.0)).mean(axis=1))


def _half_sphere() -> FloatArray:
    """Evenly spread directions, one of each opposite pair, shape (k, 3) (Fibonacci's spiral)."""
    index = np.arange(_DIRECTIONS)
    height = (index + 0.5) / _DIRECTIONS
    turn = np.pi * (1.0 + np.sqrt(5.0)) * index
    radius = np.sqrt(1.0 - height**2)
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])


def error_distribution(errors: FloatArray, own: Discrepancy, draws: int = DRAWS) -> Spread:
    """Return what errors to expect over a volume.

    The same numbers are drawn at every call, so that two plans are compared on the same calibrations.

    Parameters
    ----------
    errors : ndarray, shape (m, 3, S)
        As in `mean_norms`.
    own : Discrepancy
    draws : int
        How many calibrations are drawn.

    Returns
    -------
    Spread
        The mean in closed form, the largest and the interval from the draws.
    """
    norms = drawn_norms(errors, own, draws)
    ends = ((1.0 - BAND) / 2.0, (1.0 + BAND) / 2.0)
    low, high = np.quantile(norms.mean(axis=1), ends).tolist()
    # The mean in closed form: it never rises where a plan gets better, as that of draws may.
    mean = float(mean_norms(errors, own.per_axis_mm).mean())
    return Spread(mean, float(norms.max(axis=1).mean()), (low, high))


def drawn_norms(errors: FloatArray, own: Discrepancy, draws: int) -> FloatArray:
    """Return the norms of the errors of drawn calibrations.

    e = B z + d: z (S,) once a calibration, d anew at each place, of a size that is drawn once a calibration.

    Parameters
    ----------
    errors : ndarray, shape (m, 3, S)
        B, as in `mean_norms`.
    own : Discrepancy
        Of d.
    draws : int

    Returns
    -------
    ndarray, shape (draws, m)
        [mm].
    """
    places, axes, causes = errors.shape
    drawn = _drawn(draws, causes, places if own.per_axis_mm > 0.0 else 0)
    sizes = _sizes_mm(own, drawn.of_sizes)[:, None]
    squares = np.zeros((draws, places))
    # Axis by axis: the sums then run along memory, and no array of (draws, m, 3) is made.
    for axis in range(axes):
        common = drawn.of_causes @ errors[:, axis].T
        if own.per_axis_mm > 0.0:
            common += sizes * drawn.of_places[axis]
        squares += np.square(common, out=common)
    return np.asarray(np.sqrt(squares, out=squares))


@dataclass(frozen=True, slots=True)
class _Drawn:
    """Standard normal numbers; nobody changes them."""

    of_causes: FloatArray  # (draws, S)
    of_sizes: FloatArray  # (draws,)
    of_places: FloatArray  # (3, draws, m), an axis after the other in memory


@lru_cache(maxsize=1)  # some megabytes; a curve asks for the same at each of its points
def _drawn(draws: int, causes: int, places: int) -> _Drawn:
    rng = np.random.default_rng(_SEED)
    of_causes, of_sizes = rng.standard_normal((draws, causes)), rng.standard_normal(draws)
    of_places = rng.standard_normal((draws, places, 3))
    return _Drawn(of_causes, of_sizes, np.ascontiguousarray(np.moveaxis(of_places, 2, 0)))


def _sizes_mm(own: Discrepancy, drawn: FloatArray) -> FloatArray:
    """Return a discrepancy for each calibration, lognormal about its mean, shape (draws,).

    d exp(k z - k^2 / 2), of mean d: a normal one could be negative where it is known to 30 %.
    """
    return own.per_axis_mm * np.exp(own.known_to * drawn - own.known_to**2 / 2.0)


FEWEST: Final = 11  # configurations that the thesis of A. Nubiola begins its choice with, section 2.5.2
STEP: Final = 10
MOST: Final = 100
# Ten more that gain less than a tenth of the error: the interval of one calibration reaches a quarter to
# either side, so that nobody could show the gain by one validation.
WORTH: Final = 0.1


@dataclass(frozen=True, slots=True)
class CurvePoint:
    """The accuracy that a number of configurations promises: norms of position errors over a volume [mm]."""

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

    Returns
    -------
    tuple of int
        Ascending, none above `available`: 11, 20, 30 ... 100 where nothing was measured, else by tens from
        there; n among them.
    """
    # Behind the 11 of the thesis round numbers, 20, 30, ...
    first = measured + STEP if measured else 2 * STEP
    wanted = {max(FEWEST, measured), *range(first, measured + MOST + 1, STEP), *([] if n is None else [n])}
    return tuple(sorted({min(size, available) for size in wanted}))


def curve(errors: Errors, numbers: Sequence[int]) -> tuple[CurvePoint, ...]:
    """Return the curve at ascending numbers of configurations.

    Parameters
    ----------
    errors : Errors
    numbers : sequence of int
        Ascending.

    Returns
    -------
    tuple of CurvePoint
        One each.
    """
    return tuple(_point(errors, n) for n in numbers)


def _point(errors: Errors, n: int) -> CurvePoint:
    after = errors.after(n)
    found = error_distribution(after, errors.discrepancy)
    # A promise is of where the arm is on average; what a single visit adds stands beside it
    # (docs/decisions/0043).
    visited = float(np.hypot(errors.discrepancy.per_axis_mm, errors.repeatability_mm))
    visit = float(mean_norms(after, visited).mean())
    return CurvePoint(n, found.mean_mm, found.worst_mm, found.interval_90_mm, visit)


def gains_mm(points: Sequence[CurvePoint]) -> tuple[float, ...]:
    """Return what each step of the curve gains in the mean error.

    Parameters
    ----------
    points : sequence of CurvePoint
        k of them, ascending.

    Returns
    -------
    tuple of float
        k - 1 [mm].
    """
    return tuple(before.mean_mm - after.mean_mm for before, after in pairwise(points))


def knee(points: Sequence[CurvePoint]) -> int:
    """Return the first number after which ten more would gain less than a tenth of the mean error.

    Steps of another length are counted as if they were of ten. Numbers up to 11 are never the knee.

    Parameters
    ----------
    points : sequence of CurvePoint
        Ascending, at least one.

    Returns
    -------
    int
        Of configurations; where every step gains more, the last.

    References
    ----------
    docs/decisions/0043.
    """
    for before, after in pairwise(points):
        gained = (before.mean_mm - after.mean_mm) * STEP / (after.n - before.n)
        if before.n > FEWEST and gained < WORTH * before.mean_mm:
            return before.n
    return points[-1].n
