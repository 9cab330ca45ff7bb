r"""Linear equations with covariances: symmetric, nowhere negative, and now and then singular to rounding.

Parameters that are bound to each other have a singular covariance C. What can be asked of it lies in the
subspace that it determines: with D its standard deviations and D^-1 C D^-1 = V diag(l) V^T,

    C^+ = D^-1 V diag(1/l, where l is more than rounding; else 0) V^T D^-1

so that units do not decide which directions count. Where Cholesky finds no pivot lost, C^+ is the inverse,
and equations are solved as ever.

References
----------
G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., 2013, sections 4.2 (Cholesky) and 5.5 (rank).
"""

from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray

_ROUNDING: Final = 1e-13  # of the largest variance in units of the standard deviations
_LOST_PIVOT: Final = 1e-7  # of the root of such a matrix: its square is at rounding


def solve_singular(covariance: FloatArray, right: FloatArray) -> FloatArray:
    """Return C^+ r: the solution of C x = r, in the determined subspace where C is singular.

    Parameters
    ----------
    covariance : ndarray, shape (k, k)
    right : ndarray, shape (k,)

    Returns
    -------
    ndarray, shape (k,)
    """
    unit, scale = _unit(covariance)
    if _is_definite(unit):
        return np.asarray(np.linalg.solve(covariance, right))
    return np.asarray(_pseudo_inverse(unit) @ (right / scale) / scale)


def inverse(covariance: FloatArray) -> FloatArray:
    """Return C^+, the inverse where C has one.

    Parameters
    ----------
    covariance : ndarray, shape (k, k)

    Returns
    -------
    ndarray, shape (k, k)
    """
    unit, scale = _unit(covariance)
    if _is_definite(unit):
        return np.asarray(np.linalg.inv(covariance))
    return np.asarray(_pseudo_inverse(unit) / np.outer(scale, scale))


def whitening_root(covariance: FloatArray) -> FloatArray:
    """Return W with W C W^T = 1.

    With C = L L^T it is L^-1; where Cholesky fails, diag(max(l, floor))^-1/2 V^T with C = V diag(l) V^T.
    Nothing is known better than rounding leaves of what is known worst: smaller variances count as that.

    Parameters
    ----------
    covariance : ndarray, shape (..., k, k)
        Of one unit, or in units in which rounding may be compared.

    Returns
    -------
    ndarray, shape (..., k, k)
    """
    try:
        factor = np.linalg.cholesky(covariance)
    except np.linalg.LinAlgError:
        # One singular matrix sends the whole stack this way: the roots differ by a rotation, which whitens as
        # well.
        values, vectors = np.linalg.eigh(covariance)
        least = np.maximum(_ROUNDING * values[..., -1:], np.finfo(float).tiny)
        return np.asarray(np.swapaxes(vectors, -1, -2) / np.sqrt(np.maximum(values, least))[..., None])
    return np.asarray(np.linalg.solve(factor, np.broadcast_to(np.eye(factor.shape[-1]), factor.shape)))


def _unit(covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the matrix in units of its standard deviations (k,), and these; 1 for what does not vary."""
    variance = np.diag(covariance)
    # Units first: compliances of 1e-7 beside millimetres would else be below any tolerance for rank.
    scale = np.sqrt(np.where(variance > 0.0, variance, 1.0))
    return covariance / np.outer(scale, scale), scale


def _is_definite(unit: FloatArray) -> bool:
    """Say whether Cholesky of a matrix with unit diagonal keeps all of its pivots."""
    try:
        return bool(np.diag(np.linalg.cholesky(unit)).min(initial=1.0) > _LOST_PIVOT)
    except np.linalg.LinAlgError:
        return False


def _pseudo_inverse(unit: FloatArray) -> FloatArray:
    """Return V diag(1/l or 0) V^T of a matrix (k, k) with unit diagonal."""
    values, vectors = np.linalg.eigh(0.5 * (unit + unit.T))
    determined = values > _ROUNDING * max(float(values[-1]), 0.0)
    own = vectors[:, determined]
    return np.asarray((own / values[determined]) @ own.T)
