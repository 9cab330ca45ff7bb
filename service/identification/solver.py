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
from scipy.linalg import cho_factor, cho_solve

from service.domain.arrays import FloatArray

_STEP_TOLERANCE = 1e-3  # of a standard uncertainty: what remains to go is invisible
_LARGEST_DAMPING = 1e8
# A step may raise the cost by this much, far less than one observation: the torques are balanced to a finite
# tolerance, so that two neighbouring costs are not of quite the same function.
_INVISIBLE = 1e-3


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
    max_iterations: int = 60,
) -> Solution[L]:
    """Minimise the cost from `start`.

    Parameters
    ----------
    linearise : callable
        Values (P,) and the previous linearisation (None at first) -> Linearised.
    start, prior_means, prior_widths : ndarray, shape (P,)
    max_iterations : int

    Returns
    -------
    Solution
    """
    precision = 1.0 / prior_widths**2
    values, damping = start.copy(), 0.0
    current = linearise(values, None)
    cost = _cost(current, values - prior_means, precision)
    converged, iteration = False, 0
    while iteration < max_iterations:
        iteration += 1
        normal = current.jacobian @ current.jacobian.T
        normal[np.diag_indices_from(normal)] += precision
        gradient = current.jacobian @ current.residual - precision * (values - prior_means)
        step = _damped_step(normal, gradient, damping)
        # What remains to go is the undamped step: a damped one is short wherever it stands.
        remaining = float(gradient @ (_damped_step(normal, gradient, 0.0) if damping else step))
        trial = linearise(values + step, current)
        trial_cost = _cost(trial, values + step - prior_means, precision)
        small = remaining < _STEP_TOLERANCE**2
        if trial_cost <= cost + _INVISIBLE or small:
            values, current, cost = values + step, trial, trial_cost
            damping = damping / 10.0 if damping > 1e-6 else 0.0
            if small:
                converged = True
                break
        else:
            damping = max(damping * 10.0, 1e-4)
            if damping > _LARGEST_DAMPING:
                break
    return Solution(values, _covariance(current, precision), converged, iteration, current)


def _cost(point: Linearised, deviation: FloatArray, precision: FloatArray) -> float:
    return float(point.residual @ point.residual + deviation @ (precision * deviation))


def _damped_step(normal: FloatArray, gradient: FloatArray, damping: float) -> FloatArray:
    scale = 1.0 / np.sqrt(np.diag(normal))
    unit = normal * np.outer(scale, scale)
    unit[np.diag_indices_from(unit)] += damping
    return np.asarray(scale * cho_solve(cho_factor(unit), scale * gradient))


def _covariance(point: Linearised, precision: FloatArray) -> FloatArray:
    return posterior_covariance(point.jacobian, precision)


def posterior_covariance(jacobian: FloatArray, precision: FloatArray) -> FloatArray:
    """Inverse of J J^T + diag(precision), shape (P, P), from whitened derivatives of shape (P, m)."""
    normal = jacobian @ jacobian.T
    normal[np.diag_indices_from(normal)] += precision
    scale = 1.0 / np.sqrt(np.diag(normal))
    inverse = cho_solve(cho_factor(normal * np.outer(scale, scale)), np.eye(len(normal)))
    return np.asarray(0.5 * (inverse + inverse.T) * np.outer(scale, scale))
