"""Errors of the distances between all pairs of points: what no frame can hide.

With `d = seen - predicted` and `m = seen + predicted` of each point, both sets counted from their middle,

    |s_i - s_j|^2 - |p_i - p_j|^2 = (d_i - d_j) . (m_i - m_j)

is a product of two matrices with eight columns, as |s_i - s_j|^2 is one of two with five. The error of a
distance is the one over the sum of the two lengths: a small number is never the difference of two large ones.
The sum is only divided by, and is kept in single precision.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.identification import NominalAndIdentified, Statistics
from truepose.domain.validation import DistanceErrors, Histogram, SignedErrors
from truepose.identification.verdict.judge import Assessment

SingleArray: TypeAlias = npt.NDArray[np.float32]

# Blocks of 32 x 1,024 pairs: five of their arrays stay in the second cache of an ordinary core.
_ROWS: Final = 32
_COLUMNS: Final = 1024
_BINS: Final = 60  # of the finished histogram, at most
_FINE: Final = (
    500  # fine bins on either side of zero, at least: they are joined when the largest error is known
)
_FINEST_MM: Final = 1e-6
_NO_LENGTH_MM: Final = 1e-30  # added to the sum of two lengths: two places that coincide twice have no error


@dataclass(frozen=True, slots=True)
class PairErrors:
    """Errors of n >= 1 distances, seen minus predicted.

    Attributes
    ----------
    n : int
    mean_mm, mean_absolute_mm, rms_mm : float
    largest_mm : float
        By size.
    positive_share : float
        From 0 to 1.
    histogram : Histogram
    """

    n: int
    mean_mm: float
    mean_absolute_mm: float
    rms_mm: float
    largest_mm: float
    positive_share: float
    histogram: Histogram

    @property
    def sd_absolute_mm(self) -> float:
        """Standard deviation of the absolute errors."""
        variance = max(self.rms_mm**2 - self.mean_absolute_mm**2, 0.0)
        return float(np.sqrt(variance * self.n / max(self.n - 1, 1)))


def pair_errors(seen_mm: FloatArray, predicted_mm: Sequence[FloatArray]) -> tuple[PairErrors, ...]:
    """Return the errors of the distances between all pairs of points, for each of several predictions.

    Parameters
    ----------
    seen_mm : ndarray, shape (n, 3)
        n >= 2 places.
    predicted_mm : sequence of ndarray, shape (n, 3)

    Returns
    -------
    tuple of PairErrors
        One per prediction. Accurate to 2e-7 of an error for points a millimetre or more apart within a few
        metres; where points coincide in one of the two sets, to 0.1 um. A prediction that is equal to what
        was seen has errors of exactly 0.
    """
    # Relative to the middle: with an origin kilometres away, the digits of micrometres would be lost.
    seen = seen_mm - seen_mm.mean(axis=0)
    shifts = [predicted - predicted.mean(axis=0) for predicted in predicted_mm]
    lengths = _length_factors(seen)
    differences = [_difference_factors(seen, shifted) for shifted in shifts]
    totals = [_Totals(2.0 * _spread(seen - shifted)) for shifted in shifts]
    memory = np.empty((3, _ROWS * max(_ROWS, _COLUMNS)))
    single = np.empty((2, _ROWS * max(_ROWS, _COLUMNS)), dtype=np.float32)
    # In blocks that stay in the cache, so that memory does not grow with the pairs: 10,000 points have 50
    # million.
    for rows, columns in _blocks(len(seen)):
        shape = rows.stop - rows.start, columns.stop - columns.start
        squared, error, spare = (part[: shape[0] * shape[1]].reshape(shape) for part in memory)
        length, other = (part[: shape[0] * shape[1]].reshape(shape) for part in single)
        # One product for the lengths that were seen serves all predictions; each of these costs one more.
        _product(lengths, rows, columns, squared)
        _root(squared, length)
        for factors, total in zip(differences, totals, strict=True):
            _product(factors, rows, columns, error)
            _root(np.subtract(squared, error, out=spare), other)
            other += length
            other += _NO_LENGTH_MM
            error /= other
            total.add(_upper(error) if rows == columns else error.reshape(-1), spare.reshape(-1))
    return tuple(total.errors() for total in totals)


def _blocks(n: int) -> Iterator[tuple[slice, slice]]:
    """Yield rows and columns of the upper triangle; the squares on its diagonal have equal ones."""
    for first in range(0, n, _ROWS):
        rows = slice(first, min(first + _ROWS, n))
        yield rows, rows
        for start in range(rows.stop, n, _COLUMNS):
            yield rows, slice(start, min(start + _COLUMNS, n))


def _length_factors(seen: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (n, 5) and (5, n) whose product is |s_i - s_j|^2 = -2 s_i . s_j + |s_i|^2 + |s_j|^2."""
    squared, one = np.sum(seen**2, axis=1), np.ones(len(seen))
    return np.column_stack([-2.0 * seen, squared, one]), np.vstack([seen.T, one, squared])


def _difference_factors(seen: FloatArray, predicted: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (n, 8) and (8, n) whose product is |s_i - s_j|^2 - |p_i - p_j|^2.

    (d_i - d_j) . (m_i - m_j) = d_i . m_i + d_j . m_j - d_i . m_j - m_i . d_j.
    """
    d, m = seen - predicted, seen + predicted
    own, one = np.sum(d * m, axis=1), np.ones(len(d))
    return np.column_stack([d, m, own, one]), np.vstack([-m.T, -d.T, one, own])


def _product(factors: tuple[FloatArray, FloatArray], rows: slice, columns: slice, out: FloatArray) -> None:
    """Write a block of the product of two factors."""
    np.matmul(factors[0][rows], factors[1][:, columns], out=out)


def _root(squared: FloatArray, out: SingleArray) -> None:
    """Write the root of squares in single precision: it is only divided by."""
    np.copyto(out, squared, casting="same_kind")
    np.abs(out, out=out)  # rounding may have brought the square of no length below 0
    np.sqrt(out, out=out)


def _upper(square: FloatArray) -> FloatArray:
    """Return the entries above the diagonal: each pair once, no point with itself."""
    return np.asarray(square[np.triu_indices(len(square), 1)])


def _spread(errors: FloatArray) -> float:
    """Return how far errors (n, 3) lie from their mean; no distance can be off by more than twice that."""
    return float(np.linalg.norm(errors - errors.mean(axis=0), axis=1).max())


class _Totals:
    """Sums over blocks of errors, and a histogram fine enough to be joined to a readable one."""

    def __init__(self, reach_mm: float) -> None:
        # A whole power of ten, so that joined bins have readable ends; fine enough for 500 bins on either
        # side.
        self._width = 10.0 ** np.floor(np.log10(max(reach_mm / _FINE, _FINEST_MM)))
        self._zero = int(np.ceil(reach_mm / self._width)) + 1  # the bin that begins at 0
        self._counts = np.zeros(2 * self._zero + 1, dtype=np.int64)
        self._n, self._positive = 0, 0
        self._sum, self._absolute, self._squares, self._largest = 0.0, 0.0, 0.0, 0.0

    def add(self, errors: FloatArray, spare: FloatArray) -> None:
        """Take another block of errors.

        Parameters
        ----------
        errors : ndarray, shape (k,)
            [mm]; k = 0 is no error.
        spare : ndarray, shape (>= k,)
            Memory that is overwritten.
        """
        if errors.size == 0:
            return
        room = spare[: errors.size]
        self._n += errors.size
        self._positive += int(np.count_nonzero(errors > 0.0))
        self._sum += float(errors.sum())
        self._squares += float(errors @ errors)
        np.multiply(errors, 1.0 / self._width, out=room)
        room += self._zero  # above 0, where to cut off is to round down
        # Of places that nearly coincide rounding may bring an error out of reach: it counts in the last bin.
        np.clip(room, 0.0, self._counts.size - 1, out=room)
        self._counts += np.bincount(room.astype(np.int64), minlength=self._counts.size)
        np.abs(errors, out=room)
        self._absolute += float(room.sum())
        self._largest = max(self._largest, float(room.max()))

    def errors(self) -> PairErrors:
        """Return the figures of all blocks together."""
        n = self._n
        return PairErrors(
            n,
            self._sum / n,
            self._absolute / n,
            float(np.sqrt(self._squares / n)),
            self._largest,
            self._positive / n,
            _joined(self._width, self._counts, self._zero),
        )


def _joined(width_mm: float, counts: IntArray, zero: int) -> Histogram:
    """Join fine bins by 1, 2, 5, 10, ... until few are left; one of them begins at 0."""
    filled = np.flatnonzero(counts)
    for factor in _factors():
        bins = (filled - zero) // factor
        first, last = int(bins[0]), int(bins[-1])
        if last - first < _BINS:
            break
    joined = np.bincount(bins - first, weights=counts[filled], minlength=last - first + 1)
    return Histogram(float(width_mm * factor), first, tuple(int(count) for count in joined))


def _factors() -> Iterator[int]:
    """Yield 1, 2, 5, 10, 20, 50, ..."""
    power = 1
    while True:
        yield from (power, 2 * power, 5 * power)
        power *= 10


@dataclass(frozen=True, slots=True)
class Distances:
    """Sizes of the errors of all distances, and what only their signs tell."""

    sizes: NominalAndIdentified
    errors: DistanceErrors


def distances(judged: Assessment) -> Distances | None:
    """Return the statistics over all pairs of places.

    Parameters
    ----------
    judged : Assessment

    Returns
    -------
    Distances or None
        None of readings that are no places, or of a single one.
    """
    places = judged.block.place_mm
    if places is None or len(places) < 2:
        return None
    noise = _noise_mm(judged)
    nominal, identified = pair_errors(places, (judged.nominal.state.position_mm, judged.position_mm))
    return Distances(
        NominalAndIdentified(_statistics(nominal, noise), _statistics(identified, noise)),
        DistanceErrors(_signed(nominal), _signed(identified)),
    )


def _noise_mm(judged: Assessment) -> float:
    """Return the mean size that noise gives to the error of a distance [mm].

    A distance sees one component of the noise of each of its ends: variance 2 s^2, and the mean size of a
    normal variate is sqrt(2 / pi) of its standard deviation.
    """
    block = judged.block
    covariance = block.covariance() + block.scatter_mm**2 * np.eye(block.components)
    variance = float(np.trace(covariance, axis1=1, axis2=2).mean()) / block.components
    return float(np.sqrt(2.0 / np.pi) * np.sqrt(2.0 * variance))


def _statistics(found: PairErrors, noise_mm: float) -> Statistics:
    """Return the sizes of the errors as statistics."""
    return Statistics(
        found.n, found.mean_absolute_mm, found.rms_mm, found.sd_absolute_mm, found.largest_mm, noise_mm
    )


def _signed(found: PairErrors) -> SignedErrors:
    """Return what the signs of the errors tell."""
    return SignedErrors(found.mean_mm, found.positive_share, found.histogram)
