"""Weights: covariance of each reading plus what all readings of one stop share.

The scatter of the arm is drawn once per stop, so readings of one stop are correlated: with D the
covariance of the readings and S what one standard deviation of each shared thing does to each of them,
cov = D + S S^T. Whitening multiplies residuals and derivatives by the inverse of its
Cholesky factor.
"""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, distinct_values
from truepose.domain.definite import whitening_root

# A weight below this is none at all: however far off a reading is, it has no part in what is whitened.
_LEAST_WEIGHT = 1e-12
_ROUNDING = 1e-12


@dataclass(frozen=True, slots=True)
class Whitener:
    """Inverse Cholesky factors, grouped by the number of readings of a stop."""

    groups: tuple[tuple[IntArray, FloatArray], ...]  # rows (S, m) and factors (S, m*d, m*d)
    isotropic: FloatArray | None  # (n,) where every factor is a number, else None

    def apply(self, array: FloatArray) -> FloatArray:
        """Whiten an array of shape (..., n, d)."""
        if self.isotropic is not None:  # one long row: over d at a time it takes several times as long
            scale = np.repeat(self.isotropic, array.shape[-1])
            white: FloatArray = array.reshape(*array.shape[:-2], len(scale)) * scale
            return white.reshape(array.shape)
        if len(self.groups) == 1 and self.groups[0][0].shape[1] == 1:  # every reading, in order
            return _each_alone(self.groups[0][1], array)
        result = np.empty_like(array)
        for rows, factors in self.groups:
            block = array[..., rows, :]
            flat = block.reshape(*array.shape[:-2], *factors.shape[:2])
            white = np.einsum("sab,...sb->...sa", factors, flat)
            result[..., rows, :] = white.reshape(block.shape)
        return result


def _each_alone(factors: FloatArray, array: FloatArray) -> FloatArray:
    """Whiten (..., n, d) by a factor (d, d) of each reading, all rows of a reading at once."""
    flat = array.reshape(-1, *array.shape[-2:])
    white = np.empty(flat.shape)
    np.matmul(np.swapaxes(flat, 0, 1), np.swapaxes(factors, 1, 2), out=np.swapaxes(white, 0, 1))
    return white.reshape(array.shape)


def whitener(covariance: FloatArray, weights: FloatArray, stop: IntArray, shared: FloatArray) -> Whitener:
    """Build the whitening of n readings of d components.

    Parameters
    ----------
    covariance : ndarray, shape (n, d, d)
        Of each reading on its own [mm2 or rad2].
    weights : ndarray, shape (n,)
        1 for a full reading, 0 for one that counts for nothing.
    stop : ndarray, shape (n,)
        Readings with equal numbers belong to one stop.
    shared : ndarray, shape (n, d, k)
        What a standard deviation of each of k things that a stop's readings share does to each component.

    Returns
    -------
    Whitener
    """
    counts = (weights > _LEAST_WEIGHT)[:, None, None]
    share = np.where(counts, weights[:, None, None], 1.0)
    inflated = covariance / share
    _, inverse, sizes = np.unique(stop, return_inverse=True, return_counts=True)
    if not shared.any() or sizes.max(initial=1) == 1:
        return _of_single(inflated + shared @ np.swapaxes(shared, 1, 2) / share, counts)
    order = np.argsort(inverse, kind="stable")
    ends = np.cumsum(sizes)
    groups = []
    for size in distinct_values(sizes):
        starts = (ends - sizes)[sizes == size]
        rows = order[starts[:, None] + np.arange(size)]
        groups.append((rows, _factors(inflated, shared, counts, rows)))
    return Whitener(tuple(groups), None)


def of_independent(variance: FloatArray, weights: FloatArray) -> Whitener:
    """Whitening of n readings that share nothing, of so much variance (n,) in every component.

    What states no uncertainty weighs nothing before residuals have told how much it may.
    """
    weighs = (weights > _LEAST_WEIGHT) & (variance > 0.0)
    return Whitener((), np.sqrt(np.where(weighs, weights, 0.0) / np.where(weighs, variance, 1.0)))


def equal_variance(covariance: FloatArray) -> FloatArray | None:
    """Variance of n readings, shape (n,), where each has the same in all its components; else None."""
    diagonal = covariance[:, 0, 0]
    apart = np.abs(covariance - diagonal[:, None, None] * np.eye(covariance.shape[1]))
    return diagonal.copy() if np.all(apart <= _ROUNDING * diagonal[:, None, None]) else None


def _of_single(total: FloatArray, counts: BoolArray) -> Whitener:
    diagonal = equal_variance(total)
    if diagonal is not None:
        return of_independent(diagonal, counts[:, 0, 0].astype(float))
    rows = np.arange(len(total))[:, None]
    return Whitener(((rows, counts * whitening_root(total)),), None)


def _factors(inflated: FloatArray, shared: FloatArray, counts: BoolArray, rows: IntArray) -> FloatArray:
    stops, size = rows.shape
    d = inflated.shape[1]
    blocks = np.zeros((stops, size, d, size, d))
    for k in range(size):
        blocks[:, k, :, k, :] = inflated[rows[:, k]]
    # What does not count shares nothing with the others either.
    arms = (counts * shared)[rows].reshape(stops, size * d, -1)
    covariance = blocks.reshape(stops, size * d, size * d) + arms @ np.swapaxes(arms, 1, 2)
    kept = np.repeat(counts[rows].reshape(stops, size), d, axis=1)
    return kept[:, :, None] * whitening_root(covariance)
