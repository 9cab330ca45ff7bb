r"""What the uncertainty of a calibrated model means for its errors over a work volume.

The errors of one calibration are one draw: e(x) = B(x) z + d(x), with z standard normal and common to all
places x (parameters, certificates, registration), and d of independent places (what no parameter expresses).
So the mean of |e| over the volume is itself a random figure. Its expectation has no closed form, but with
z = r u, r the length and u the direction of a normal vector of three components,

    E|e(x)| = 2 sqrt(2 / pi) * mean over directions u of sqrt(u' S u),        S = B B' + d^2 I

which never rises where S falls. Its quantiles, and the largest error to be found, come from draws.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray

DRAWS: Final = 600  # calibrations: the ends of the interval are right to about two parts in a hundred
BAND: Final = 0.90
_DIRECTIONS: Final = 200  # over half a sphere: means right to a part in a thousand
_SEED: Final = 2026  # the same plan promises the same


@dataclass(frozen=True, slots=True)
class Discrepancy:
    """What no parameter expresses: drawn at every place anew, of a size that is itself not known for sure."""

    per_axis_mm: float = 0.0  # standard deviation
    known_to: float = 0.0  # relative standard deviation of that figure from arm to arm


NONE: Final = Discrepancy()  # of an arm that the parameters describe wholly


@dataclass(frozen=True, slots=True)
class Spread:
    """Errors to expect over a volume: norms [mm]."""

    mean_mm: float  # expectation of the mean over the volume
    worst_mm: float  # expectation of the largest in the volume
    interval_90_mm: tuple[float, float]  # nine calibrations of ten have their mean within


def mean_norms(errors: FloatArray, own_mm: float) -> FloatArray:
    """Return the expected norm of the error at each place.

    Parameters
    ----------
    errors : ndarray, shape (m, 3, S)
        What a standard deviation of each of S independent causes does at m places [mm].
    own_mm : float
        Standard deviation per axis of what is drawn at each place anew.

    Returns
    -------
    ndarray, shape (m,)
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


def spread(errors: FloatArray, own: Discrepancy, draws: int = DRAWS) -> Spread:
    """Return what errors to expect; `errors` as in `mean_norms`, `draws` is how many calibrations are drawn.

    The same numbers are drawn at every call, so that two plans are compared on the same calibrations.
    """
    norms = drawn_norms(errors, own, draws)
    ends = ((1.0 - BAND) / 2.0, (1.0 + BAND) / 2.0)
    low, high = np.quantile(norms.mean(axis=1), ends).tolist()
    mean = float(mean_norms(errors, own.per_axis_mm).mean())
    return Spread(mean, float(norms.max(axis=1).mean()), (low, high))


def drawn_norms(errors: FloatArray, own: Discrepancy, draws: int) -> FloatArray:
    """Return the norms of the errors of drawn calibrations, shape (draws, m)."""
    places, axes, causes = errors.shape
    drawn = _drawn(draws, causes, places if own.per_axis_mm > 0.0 else 0)
    sizes = _sizes_mm(own, drawn.of_sizes)[:, None]
    squares = np.zeros((draws, places))
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
    """Return a discrepancy for each calibration, lognormal about its mean, shape (draws,)."""
    return own.per_axis_mm * np.exp(own.known_to * drawn - own.known_to**2 / 2.0)
