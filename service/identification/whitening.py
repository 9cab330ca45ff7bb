"""Weights: covariance of each reading plus what all readings of one stop share.

The scatter of the arm is drawn once per stop, so readings of one stop are correlated: with D the
covariance of the readings and S what one standard deviation of each shared thing does to each of them,
cov = D + S S^T. Whitening multiplies residuals and derivatives by the inverse of its
Cholesky factor.
"""

from dataclasses import dataclass

import numpy as np

from service.domain.arrays import FloatArray, IntArray

_NO_WEIGHT = 1e12  # variance factor of a reading that gets no weight


@dataclass(frozen=True, slots=True)
class Whitener:
    """Inverse Cholesky factors, grouped by the number of readings of a stop."""

    groups: tuple[tuple[IntArray, FloatArray], ...]  # rows (S, m) and factors (S, m*d, m*d)
    isotropic: FloatArray | None  # (n,) where every factor is a number, else None

    def apply(self, array: FloatArray) -> FloatArray:
        """Whiten an array of shape (..., n, d)."""
        if self.isotropic is not None:
            return array * self.isotropic[:, None]
        result = np.empty_like(array)
        for rows, factors in self.groups:
            block = array[..., rows, :]
            flat = block.reshape(*array.shape[:-2], *factors.shape[:2])
            white = np.einsum("sab,...sb->...sa", factors, flat)
            result[..., rows, :] = white.reshape(block.shape)
        return result


def whitener(covariance: FloatArray, weights: FloatArray, stop: IntArray, shared: FloatArray) -> Whitener:
    """Build the whitening of n readings of d components.

    Parameters
    ----------
    covariance : ndarray, shape (n, d, d)
        Of each reading on its own [mm2 or rad2].
    weights : ndarray, shape (n,)
        1 for a full reading, 0 for one that gets no weight.
    stop : ndarray, shape (n,)
        Readings with equal numbers belong to one stop.
    shared : ndarray, shape (n, d, k)
        What a standard deviation of each of k things that a stop's readings share does to each component.

    Returns
    -------
    Whitener
    """
    inflated = covariance / np.maximum(weights, 1.0 / _NO_WEIGHT)[:, None, None]
    _, inverse, sizes = np.unique(stop, return_inverse=True, return_counts=True)
    if not shared.any() or sizes.max(initial=1) == 1:
        total = inflated + shared @ np.swapaxes(shared, 1, 2) / _floor(weights)
        return _of_single(total)
    order = np.argsort(inverse, kind="stable")
    ends = np.cumsum(sizes)
    groups = []
    for size in np.unique(sizes):
        starts = (ends - sizes)[sizes == size]
        rows = order[starts[:, None] + np.arange(size)]
        groups.append((rows, _factors(inflated, shared, rows)))
    return Whitener(tuple(groups), None)


def _floor(weights: FloatArray) -> FloatArray:
    return np.maximum(weights, 1.0 / _NO_WEIGHT)[:, None, None]


def _of_single(total: FloatArray) -> Whitener:
    diagonal = total[:, 0, 0]
    if np.allclose(total, diagonal[:, None, None] * np.eye(total.shape[1]), rtol=1e-12, atol=0.0):
        return Whitener((), 1.0 / np.sqrt(diagonal))
    rows = np.arange(len(total))[:, None]
    return Whitener(((rows, _inverse_cholesky(total)),), None)


def _factors(inflated: FloatArray, shared: FloatArray, rows: IntArray) -> FloatArray:
    stops, size = rows.shape
    d = inflated.shape[1]
    blocks = np.zeros((stops, size, d, size, d))
    for k in range(size):
        blocks[:, k, :, k, :] = inflated[rows[:, k]]
    arms = shared[rows].reshape(stops, size * d, -1)
    return _inverse_cholesky(blocks.reshape(stops, size * d, size * d) + arms @ np.swapaxes(arms, 1, 2))


def _inverse_cholesky(covariance: FloatArray) -> FloatArray:
    factor = np.linalg.cholesky(covariance)
    return np.linalg.solve(factor, np.broadcast_to(np.eye(factor.shape[-1]), factor.shape))
