"""The circle that a point of a turning body runs on: its plane, its axis, its radius.

Readings far off plane or circle count less (Huber): a single gross one must not move the axis.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.identification.fit.solver import covariance_of

_ROUNDS: Final = 30
_SETTLED: Final = 1e-6  # change of the weights
_CONVERGED: Final = 1e-12  # of the radius
_HUBER: Final = 2.0  # scatters; beyond them a reading counts less, one in seven of clean ones
_GROSS: Final = 6.0
_MEDIAN_OF_TWO: Final = 1.1774  # of the norm of two standard normal variates
_LEAST_MM: Final = 1e-9  # below it positions of metres are rounded


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle through n readings."""

    centre_mm: FloatArray  # (3,)
    basis: FloatArray  # (3, 3) rows, right-handed: two directions in the plane, then the axis
    radius_mm: float
    covariance_mm2: FloatArray  # (3, 3) of the centre along the two directions, and of the radius
    gross: BoolArray  # (n,) readings far off all others, in the plane or out of it

    @property
    def radius_uncertainty_mm(self) -> float:
        """Standard uncertainty of the radius."""
        return float(np.sqrt(self.covariance_mm2[2, 2]))

    def local(self, points_mm: FloatArray) -> FloatArray:
        """Return points (n, 3) along the rows of the basis, from the centre."""
        return np.asarray((points_mm - self.centre_mm) @ self.basis.T)

    def turned_over(self) -> "Circle":
        """Return the same circle with its axis the other way."""
        swap = np.eye(3)[[1, 0, 2]]
        basis = np.array([self.basis[1], self.basis[0], -self.basis[2]])
        covariance = swap @ self.covariance_mm2 @ swap
        return Circle(self.centre_mm, basis, self.radius_mm, covariance, self.gross)


def fit_circle(points_mm: FloatArray, standard_uncertainty_mm: FloatArray) -> Circle | None:
    """Fit plane and circle by least squares of axial and radial distances.

    Parameters
    ----------
    points_mm : ndarray, shape (n, 3)
        n >= 4, at four places or more.
    standard_uncertainty_mm : ndarray, shape (n,)
        Per axis, above 0.

    Returns
    -------
    Circle or None
        None where the points determine none: they are in one place or on a line. Where they scatter more
        than they state, the covariance is widened by it.
    """
    weight = standard_uncertainty_mm**-2.0
    soft = np.ones(len(weight))
    for _ in range(_ROUNDS):
        circle, far = _weighted(points_mm, weight * soft, standard_uncertainty_mm)
        before, soft = soft, np.minimum(1.0, _HUBER / np.maximum(far, _HUBER))
        if circle is None or np.abs(soft - before).max() < _SETTLED:
            break
    return circle


def _weighted(
    points_mm: FloatArray, weight: FloatArray, u_mm: FloatArray
) -> tuple[Circle | None, FloatArray]:
    """Return the circle of these weights, and how many scatters each point lies off it, shape (n,)."""
    middle, basis = _plane(points_mm, weight)
    local = (points_mm - middle) @ basis.T
    centre = _flat_circle(local[:, :2], weight)
    radial, jacobian = _radial(local[:, :2], centre)
    far = _scatters_off(np.hypot(radial, local[:, 2]), u_mm)
    normal = jacobian.T @ (weight[:, None] * jacobian)
    covariance = covariance_of(normal) if normal.diagonal().all() else None
    if covariance is None or not np.isfinite(centre).all():
        return None, far
    widened = max(1.0, float(weight @ radial**2) / max(len(weight) - 3, 1))
    place = middle + centre[:2] @ basis[:2]
    return Circle(place, basis, float(centre[2]), covariance * widened, far > _GROSS), far


def _plane(points_mm: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
    middle = np.average(points_mm, axis=0, weights=weight)
    axes = np.linalg.svd((points_mm - middle) * np.sqrt(weight)[:, None], full_matrices=False)[2]
    return middle, np.array([axes[0], axes[1], np.cross(axes[0], axes[1])])


def _flat_circle(flat: FloatArray, weight: FloatArray) -> FloatArray:
    """Return centre and radius, shape (3,), by Gauss-Newton from the circle of least squared powers."""
    root = np.sqrt(weight)
    columns = np.column_stack([2.0 * flat, np.ones(len(flat))])
    power = np.linalg.lstsq(columns * root[:, None], (flat**2).sum(axis=1) * root, rcond=None)[0]
    found = np.array([power[0], power[1], np.sqrt(max(power[2] + power[:2] @ power[:2], 0.0))])
    for _ in range(_ROUNDS):
        radial, jacobian = _radial(flat, found)
        step = np.linalg.lstsq(jacobian * root[:, None], -radial * root, rcond=None)[0]
        found = found + step
        if np.abs(step).max() <= _CONVERGED * abs(found[2]):
            break
    return np.asarray(found)


def _radial(flat: FloatArray, circle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return radial distances (n,) from a circle, and their derivatives (n, 3) in centre and radius."""
    away = flat - circle[:2]
    distance = np.maximum(np.hypot(*away.T), _LEAST_MM)
    return distance - circle[2], np.column_stack([-away / distance[:, None], -np.ones(len(flat))])


def _scatters_off(off_mm: FloatArray, u_mm: FloatArray) -> FloatArray:
    typical = float(np.median(off_mm / u_mm)) / _MEDIAN_OF_TWO
    return np.asarray(off_mm / np.maximum(u_mm * max(1.0, typical), _LEAST_MM))
