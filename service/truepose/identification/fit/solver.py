r"""Weighted nonlinear least squares with priors: damped Gauss-Newton on the normal equations.

With whitened residuals r (observation minus prediction, shape (m,)) and their prediction's derivatives J,
shape (P, m), prior means m and widths w, the cost is

    |r(p)|^2 + sum ((p - m) / w)^2

and the step solves

    H s = g        H = J J^T + diag(1/w^2)        g = J r + (m - p) / w^2

The matrix is brought to unit diagonal before its Cholesky factor is taken, so that millimetres and
compliances meet on equal terms; damping is added to that diagonal, so that it has no unit either. What the
undamped step would gain, g^T H^-1 g, is the square of its length in standard uncertainties: that is what
the end of the iteration is judged by. At the end H^-1 is the covariance of the parameters (posterior).

Cost and r have no unit, as r is whitened; p and s are in internal units (mm, rad, rad/(N mm), ...).

References
----------
K. Madsen, H. B. Nielsen, O. Tingleff, Methods for Non-Linear Least Squares Problems, 2nd ed., 2004.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, NamedTuple, Protocol, Self, TypeVar

import numpy as np

from truepose.domain.arrays import FloatArray

_STEP_TOLERANCE = 1e-3  # of a standard uncertainty: what remains to go is invisible
_SHORT = 1e-3  # squared step, of standard uncertainties: on such a way derivatives do not change visibly
_LARGEST_DAMPING = 1e8
_SMALLEST_PIVOT = 1e-6  # its square is what rounding leaves four good digits of
# A step may raise the cost by this much, far less than one observation: the torques are balanced to a finite
# tolerance, so that two neighbouring costs are not of quite the same function.
_INVISIBLE = 1e-3
_NOTHING_TO_GAIN = 1e-2  # of cost: where a step promises less and fails, that tolerance is all that is left


class Linearisation(Protocol):
    """The problem at one point."""

    @property
    def residual(self) -> FloatArray:
        """Whitened residuals, shape (m,)."""
        ...

    @property
    def jacobian(self) -> FloatArray:
        """Whitened derivatives of the prediction, shape (P, m)."""
        ...

    def with_derivatives_of(self, near: Self) -> Self:
        """Return this point with the derivatives of another one, too near for them to differ."""
        ...


L = TypeVar("L", bound=Linearisation)


@dataclass(frozen=True, slots=True)
class Solution(Generic[L]):
    """Where the iteration ended.

    Attributes
    ----------
    values : ndarray, shape (P,)
        Parameters, internal units.
    covariance : ndarray, shape (P, P)
        Posterior: inverse of the normal matrix H at the last derivatives, priors included.
    converged : bool
        Whether what remained to go was invisible, and not only the iterations used up.
    iterations : int
        Rounds of at most one step each, refused steps included.
    final : Linearisation
        The problem at `values`.
    """

    values: FloatArray
    covariance: FloatArray
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
        Values (P,) and the previous linearisation (None at first) -> Linearisation.
    start : ndarray, shape (P,)
        Internal units.
    prior_means, prior_widths : ndarray, shape (P,)
        Mean and standard deviation of each parameter's prior, internal units; widths above 0.
    first : Linearisation, optional
        The problem at the start, where it is known.
    max_iterations : int
        Steps that are tried, refused ones included.

    Returns
    -------
    Solution
        Not converged where the iterations were used up, or no step however short lowered the cost.

    Notes
    -----
    A step that raises the cost is refused and damped ten times more; one that is accepted is damped ten times
    less next time. After a step too short for derivatives to change, those of the point before stand.
    """
    precision = 1.0 / prior_widths**2
    # Starts come from a placement and are near: damping is for the few steps that overshoot all the same.
    values, damping = start.copy(), 0.0
    current = linearise(values, None) if first is None else first
    cost = _cost(current, values - prior_means, precision)
    normal = _Normal(current, precision)
    converged, iteration = len(values) == 0, 0  # a model without parameters is where it should be
    while not converged and iteration < max_iterations:
        iteration += 1
        # Where the derivatives of the point before stayed, residuals are the present ones all the same.
        gradient = slope(current, precision, values - prior_means)
        step = normal.solved(gradient, damping)
        # What remains to go is the undamped step: a damped one is short wherever it stands.
        undamped = normal.solved(gradient, 0.0) if damping else step
        remaining = float(gradient @ undamped)
        if remaining < _STEP_TOLERANCE**2:
            converged = True
            break
        trial = linearise(values + step, current)
        trial_cost = _cost(trial, values + step - prior_means, precision)
        if trial_cost <= cost + _INVISIBLE:
            values, cost = values + step, trial_cost
            # New derivatives would move the parameters by less than 0.03 of a standard uncertainty, on all
            # data tried.
            if remaining < _SHORT:
                current = trial.with_derivatives_of(current)
            else:
                current, normal = trial, _Normal(trial, precision)
            damping = damping / 10.0 if damping > 1e-6 else 0.0
        # More damping would only shorten a step that the tolerance of the torques, not the model, refuses.
        elif remaining < _NOTHING_TO_GAIN:
            converged = True
        else:
            damping = max(damping * 10.0, 1e-4)
            if damping > _LARGEST_DAMPING:
                break
    return Solution(values, normal.inverse(), converged, iteration, current)


def slope(point: Linearisation, precision: FloatArray, deviation: FloatArray) -> FloatArray:
    """Half the slope of the cost downhill: what the step is solved from.

    Parameters
    ----------
    point : Linearisation
    precision : ndarray, shape (P,)
        1 / w^2 of the priors, per squared unit of each parameter.
    deviation : ndarray, shape (P,)
        Parameters minus prior means.

    Returns
    -------
    ndarray, shape (P,)
        g = J r - precision * deviation, per unit of each parameter; zero at the minimum.
    """
    downhill: FloatArray = point.jacobian @ point.residual - precision * deviation
    return downhill


def _cost(point: Linearisation, deviation: FloatArray, precision: FloatArray) -> float:
    return float(point.residual @ point.residual + deviation @ (precision * deviation))


def posterior_covariance(jacobian: FloatArray, precision: FloatArray) -> FloatArray:
    """Inverse of J J^T + diag(precision).

    Parameters
    ----------
    jacobian : ndarray, shape (P, m)
        Whitened derivatives, per unit of each parameter.
    precision : ndarray, shape (P,)
        1 / w^2 of the priors; all above 0, so that the inverse exists whatever the readings see.

    Returns
    -------
    ndarray, shape (P, P)
        Covariance in the units of the parameters; by Cholesky, else by QR where rounding leaves too little.
    """
    factor = _factored(jacobian @ jacobian.T + np.diag(precision), 0.0)
    return (factor or _factored_by_qr(jacobian, precision, 0.0)).inverse()


def absorbed(jacobian: FloatArray, covariance: FloatArray) -> float:
    """Return how many residuals' worth the parameters absorb: the trace of the leverage.

    Parameters
    ----------
    jacobian : ndarray, shape (P, m)
        Of whitened residuals.
    covariance : ndarray, shape (P, P)
        Posterior: a parameter that its prior holds absorbs nothing.

    Returns
    -------
    float
        tr(J^T C J), P at most.
    """
    return float(np.einsum("pm,pq,qm->", jacobian, covariance, jacobian, optimize=True))


def covariance_of(normal: FloatArray) -> FloatArray | None:
    """Inverse of normal matrices.

    Parameters
    ----------
    normal : ndarray, shape (..., P, P)
        J J^T + diag(precision), one or many.

    Returns
    -------
    ndarray, shape (..., P, P), or None
        None where rounding has left too little of any one of them: then the derivatives must be asked.
    """
    factor = _factored(normal, 0.0)
    return None if factor is None else factor.inverse()


class _Normal:
    """The normal equations at one point; its matrix is summed up once, whatever is asked of it."""

    def __init__(self, point: Linearisation, precision: FloatArray) -> None:
        self._jacobian, self._precision = point.jacobian, precision
        self._matrix = point.jacobian @ point.jacobian.T + np.diag(precision)

    def solved(self, gradient: FloatArray, damping: float) -> FloatArray:
        """Return the step, shape (P,)."""
        return (self._damped(damping) if damping else self._undamped).solved(gradient)

    def inverse(self) -> FloatArray:
        """Return the covariance of the parameters, shape (P, P)."""
        return self._undamped.inverse()

    @cached_property
    def _undamped(self) -> "_Factor":
        return self._damped(0.0)

    def _damped(self, damping: float) -> "_Factor":
        factor = _factored(self._matrix, damping)
        return factor or _factored_by_qr(self._jacobian, self._precision, damping)


class _Factor(NamedTuple):
    """R, upper triangular, and scales s with R^T R = s (J J^T + diag(precision)) s + damping."""

    root: FloatArray  # (..., P, P)
    scale: FloatArray  # (..., P)

    def solved(self, gradient: FloatArray) -> FloatArray:
        """Return the step from the downhill slope (P,): the solution of the damped equations, shape (P,)."""
        # Triangular solvers are scipy's, whose import takes longer than an identification.
        half = np.linalg.solve(self.root.T, self.scale * gradient)
        return np.asarray(self.scale * np.linalg.solve(self.root, half))

    def inverse(self) -> FloatArray:
        """Return the inverse of the undamped matrix, shape (..., P, P)."""
        half = self.scale[..., None] * np.linalg.inv(self.root)
        return np.asarray(half @ np.swapaxes(half, -1, -2))


def _factored(normal: FloatArray, damping: float) -> _Factor | None:
    """Return the factor of normal matrices; None where rounding has left too little of one."""
    scale = 1.0 / np.sqrt(np.diagonal(normal, axis1=-2, axis2=-1))
    unit = normal * (scale[..., :, None] * scale[..., None, :]) + damping * np.eye(normal.shape[-1])
    try:
        root = np.swapaxes(np.linalg.cholesky(unit), -1, -2)
    except np.linalg.LinAlgError:
        return None
    # Cholesky succeeds on matrices that rounding has emptied; a small pivot shows it. Without parameters
    # there is none, and nothing is lost.
    pivots = np.diagonal(root, axis1=-2, axis2=-1)
    return _Factor(root, scale) if pivots.min(initial=1.0) > _SMALLEST_PIVOT else None


def _factored_by_qr(jacobian: FloatArray, precision: FloatArray, damping: float) -> _Factor:
    """Return the factor from the derivatives themselves.

    Readings so precise that a prior is lost beside them in J J^T keep it in the QR factors of J itself,
    which are slower and lose half as many digits.
    """
    scale = 1.0 / np.sqrt((jacobian**2).sum(axis=1) + precision)
    own = np.diag(np.sqrt(precision * scale**2 + damping))
    _, root = np.linalg.qr(np.vstack([jacobian.T * scale, own]))
    return _Factor(np.asarray(root), scale)
