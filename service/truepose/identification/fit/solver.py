r"""Weighted nonlinear least squares with priors: damped Gauss-Newton on the normal equations.

With whitened residuals r (observation minus prediction) and their prediction's derivatives J,
prior means m and widths w, the cost is

    |r(p)|^2 + sum ((p - m) / w)^2

and the step solves (J J^T + diag(1/w^2)) s = J r + (m - p) / w^2. The matrix is brought to unit
diagonal before its Cholesky factor is taken, so that millimetres and compliances meet on equal terms.
At the end its inverse is the covariance of the parameters (posterior).

References
----------
K. Madsen, H. B. Nielsen, O. Tingleff, Methods for Non-Linear Least Squares Problems, 2nd ed., 2004.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from scipy.linalg import LinAlgError, cho_solve, cholesky, qr

from truepose.domain.arrays import FloatArray

_STEP_TOLERANCE = 1e-3  # of a standard uncertainty: what remains to go is invisible
_LARGEST_DAMPING = 1e8
_SMALLEST_PIVOT = 1e-6  # its square is what rounding leaves four good digits of
# A step may raise the cost by this much, far less than one observation: the torques are balanced to a finite
# tolerance, so that two neighbouring costs are not of quite the same function.
_INVISIBLE = 1e-3
_NOTHING_TO_GAIN = 1e-2  # of cost: where a step promises less and fails, that tolerance is all that is left


class Linearised(Protocol):
    """The problem at one point."""

    @property
    def residual(self) -> FloatArray:
        """Whitened residuals, shape (m,)."""
        ...

    @property
    def jacobian(self) -> FloatArray:
        """Whitened derivatives of the prediction, shape (P, m)."""
        ...


L = TypeVar("L", bound=Linearised)


@dataclass(frozen=True, slots=True)
class Solution(Generic[L]):
    """Where the iteration ended."""

    values: FloatArray  # (P,)
    covariance: FloatArray  # (P, P) posterior
    converged: bool
    iterations: int
    final: L


def solve(
    linearise: Callable[[FloatArray, L | None], L],
    start: FloatArray,
    prior_means: FloatArray,
    prior_widths: FloatArray,
    *,
    first: L | None = None,
    max_iterations: int = 60,
) -> Solution[L]:
    """Minimise the cost from `start`.

    Parameters
    ----------
    linearise : callable
        Values (P,) and the previous linearisation (None at first) -> Linearised.
    start, prior_means, prior_widths : ndarray, shape (P,)
    first : Linearised, optional
        The problem at the start, where it is known.
    max_iterations : int

    Returns
    -------
    Solution
    """
    precision = 1.0 / prior_widths**2
    values, damping = start.copy(), 0.0
    current = linearise(values, None) if first is None else first
    cost = _cost(current, values - prior_means, precision)
    converged, iteration = len(values) == 0, 0  # a model without parameters is where it should be
    while not converged and iteration < max_iterations:
        iteration += 1
        gradient = current.jacobian @ current.residual - precision * (values - prior_means)
        step = _damped_step(current.jacobian, precision, gradient, damping)
        # What remains to go is the undamped step: a damped one is short wherever it stands.
        undamped = _damped_step(current.jacobian, precision, gradient, 0.0) if damping else step
        remaining = float(gradient @ undamped)
        if remaining < _STEP_TOLERANCE**2:
            converged = True
            break
        trial = linearise(values + step, current)
        trial_cost = _cost(trial, values + step - prior_means, precision)
        if trial_cost <= cost + _INVISIBLE:
            values, current, cost = values + step, trial, trial_cost
            damping = damping / 10.0 if damping > 1e-6 else 0.0
        elif remaining < _NOTHING_TO_GAIN:
            converged = True
        else:
            damping = max(damping * 10.0, 1e-4)
            if damping > _LARGEST_DAMPING:
                break
    covariance = posterior_covariance(current.jacobian, precision)
    return Solution(values, covariance, converged, iteration, current)


def _cost(point: Linearised, deviation: FloatArray, precision: FloatArray) -> float:
    return float(point.residual @ point.residual + deviation @ (precision * deviation))


def _damped_step(
    jacobian: FloatArray, precision: FloatArray, gradient: FloatArray, damping: float
) -> FloatArray:
    root, scale = _root(jacobian, precision, damping)
    return np.asarray(scale * cho_solve((root, False), scale * gradient))


def posterior_covariance(jacobian: FloatArray, precision: FloatArray) -> FloatArray:
    """Inverse of J J^T + diag(precision), shape (P, P), from whitened derivatives of shape (P, m)."""
    if len(precision) == 0:
        return np.zeros((0, 0))
    root, scale = _root(jacobian, precision, 0.0)
    inverse = cho_solve((root, False), np.eye(len(precision)))
    return np.asarray(0.5 * (inverse + inverse.T) * np.outer(scale, scale))


def _root(jacobian: FloatArray, precision: FloatArray, damping: float) -> tuple[FloatArray, FloatArray]:
    """Return R, upper triangular, and scales s with R^T R = s (J J^T + diag(precision)) s + damping.

    Readings so precise that a prior is lost beside them in J J^T keep it in the QR factors of J itself,
    which are slower and lose half as many digits.
    """
    normal = jacobian @ jacobian.T
    normal[np.diag_indices_from(normal)] += precision
    scale = 1.0 / np.sqrt(np.diag(normal))
    unit = normal * np.outer(scale, scale)
    unit[np.diag_indices_from(unit)] += damping
    try:
        root = cholesky(unit)
        if np.diag(root).min() > _SMALLEST_PIVOT:
            return root, scale
    except LinAlgError:
        pass
    own = np.diag(np.sqrt(precision * scale**2 + damping))
    (factor,) = qr(np.vstack([jacobian.T * scale, own]), mode="r")
    return np.asarray(factor[: len(scale)]), scale
