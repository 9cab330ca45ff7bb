"""Where a nest was, against where it would have been on the circle through its place at 0 deg.

A reading p at joint angle q lies at (rho, phi, z) about the fitted axis. Against the reading at 0 deg, of
angle q0 (the mean where there are several): radial rho - rho0, axial z - z0, angular (phi - phi0) - (q - q0),
tangential the angular error times rho0 (thesis of A. Nubiola, 2014, section 2.4.1).
"""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, Table
from truepose.judgement.circle.fit import Circle
from truepose.judgement.circle.sweeps import SAME_ANGLE_RAD


@dataclass(frozen=True, slots=True)
class CircleErrors(Table):
    """Errors at m stops of one joint."""

    zero_rad: float  # angle that the circle goes through: 0, or the nearest that was measured
    radius_mm: float  # of the circle through it
    angle_rad: FloatArray  # (m,)
    radial_mm: FloatArray  # (m,)
    axial_mm: FloatArray  # (m,)
    angular_rad: FloatArray  # (m,)
    angular_uncertainty_rad: FloatArray  # (m,) readings and axis; 0 where the error is 0 by definition
    reading_rad: FloatArray  # (m,) standard uncertainty of a reading, as an angle
    axis_rad: FloatArray  # (m, 2) effect of one standard deviation of the axis, along its two directions

    @property
    def tangential_mm(self) -> FloatArray:
        """Angular errors on the circle, shape (m,)."""
        return np.asarray(self.angular_rad * self.radius_mm)

    @property
    def tangential_uncertainty_mm(self) -> FloatArray:
        """Their standard uncertainties, shape (m,)."""
        return np.asarray(self.angular_uncertainty_rad * self.radius_mm)


def errors_about(
    circle: Circle, points_mm: FloatArray, u_mm: FloatArray, angle_rad: FloatArray
) -> CircleErrors:
    """Return the errors of readings (m, 3), uncertain by (m,) per axis, at joint angles (m,)."""
    circle = _along_the_joint(circle, points_mm, angle_rad)
    across, up, axial = circle.local(points_mm).T
    distance, offset = np.hypot(across, up), np.arctan2(up, across) - angle_rad
    at_zero = _at_zero(angle_rad)
    radius = float(distance[at_zero].mean())
    angular = _wrapped(offset - _mean_angle(offset[at_zero]))
    reading = u_mm / radius
    axis = _axis_effect(circle, across, up, at_zero)
    variance = _reading_variance(reading, at_zero) + (axis**2).sum(axis=1)
    return CircleErrors(
        zero_rad=float(angle_rad[at_zero].mean()),
        radius_mm=radius,
        angle_rad=angle_rad,
        radial_mm=distance - radius,
        axial_mm=axial - axial[at_zero].mean(),
        angular_rad=angular,
        angular_uncertainty_rad=np.sqrt(variance),
        reading_rad=reading,
        axis_rad=axis,
    )


def _along_the_joint(circle: Circle, points_mm: FloatArray, angle_rad: FloatArray) -> Circle:
    """Return the circle with the axis about which the joint turns to the positive side."""
    across, up, _ = circle.local(points_mm).T
    turned = np.arctan2(up, across)
    same, opposite = (abs(np.exp(1j * (sign * turned - angle_rad)).mean()) for sign in (1.0, -1.0))
    return circle if same >= opposite else circle.turned_over()


def _at_zero(angle_rad: FloatArray) -> BoolArray:
    nearest = angle_rad[np.argmin(np.abs(angle_rad))]
    return np.asarray(np.abs(angle_rad - nearest) <= SAME_ANGLE_RAD)


def _mean_angle(angles: FloatArray) -> float:
    return float(np.angle(np.exp(1j * angles).mean()))


def _wrapped(angles: FloatArray) -> FloatArray:
    return np.asarray((angles + np.pi) % (2.0 * np.pi) - np.pi)


def _axis_effect(circle: Circle, across: FloatArray, up: FloatArray, at_zero: BoolArray) -> FloatArray:
    """Return what the angular errors change by for a standard deviation of the axis either way, (m, 2)."""
    distance = across**2 + up**2
    tangent = np.column_stack([up, -across]) / distance[:, None]
    root = np.linalg.cholesky(circle.covariance_mm2[:2, :2])
    return np.asarray((tangent - tangent[at_zero].mean(axis=0)) @ root)


def _reading_variance(reading: FloatArray, at_zero: BoolArray) -> FloatArray:
    """Return the variance from scatter, shape (m,); a reading at zero is part of what it is held against."""
    n = int(at_zero.sum())
    zero = float((reading[at_zero] ** 2).sum()) / n**2
    return np.asarray(reading**2 * np.where(at_zero, 1.0 - 2.0 / n, 1.0) + zero)
