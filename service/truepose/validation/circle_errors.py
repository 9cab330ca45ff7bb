"""The circle that a point of a turning body runs on, and where readings lie against it.

*Sweeps:* which rows of a table are of which joint, and from which side. The other joints stand where they
stand most often in the table. A row in which no joint is away from there belongs to the joint that moved
before it. Where that leaves more rows over than it does to go through them in order, the others may stand
elsewhere for each joint: a sweep is then a run of rows in which one joint alone moved.

*Circle:* plane, axis and radius. The plane is that of least weighted squares (singular vectors of the centred
points). In it a circle of centre c and radius r has the residuals e = |x - c| - r; Gauss-Newton begins at the
c and r of least sum (|x|^2 - 2 x . c - (r^2 - |c|^2))^2, which is linear. Readings far off count less
(Huber): a single outlier must not move the axis.

*Errors* against the circle through the place at 0 deg. A reading p at joint angle q lies at (rho, phi, z)
about the fitted axis. Against the reading at 0 deg, of angle q0 (the mean where there are several): radial
rho - rho0, axial z - z0, angular (phi - phi0) - (q - q0), tangential the angular error times rho0 (thesis of
A. Nubiola, 2014, section 2.4.1).

References
----------
I. Kasa, IEEE Trans. Instrumentation and Measurement 25(1), 1976, 8-14 (the start).
P. J. Huber, Annals of Mathematical Statistics 35, 1964, 73-101.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, Table
from truepose.domain.campaign import PointReadings
from truepose.domain.errors import ConfigurationError
from truepose.identification.fit.solver import covariance_of

_FEWEST: Final = 4  # rows of a run; fewer determine no circle
SAME_ANGLE_RAD: Final = float(np.radians(0.05))  # reported angles are rounded to 0.01 deg, and jitter by it


@dataclass(frozen=True, slots=True)
class Sweep:
    """Readings of one nest while one joint turned, m of the table's rows in the order of measuring.

    Attributes
    ----------
    joint, nest : int
        1-based.
    rows : ndarray of int, shape (m,)
    angle_rad : ndarray, shape (m,)
        Of that joint.
    direction : ndarray of int, shape (m,)
        Sign of its last motion, 0 unknown.
    """

    joint: int
    nest: int
    rows: IntArray
    angle_rad: FloatArray
    direction: IntArray


def find_sweeps(points: PointReadings) -> tuple[Sweep, ...]:
    """Return the sweeps of a table, by joint and nest.

    Parameters
    ----------
    points : PointReadings
        n >= 1 rows; where all times are known they give the order, else the rows do. Where the table does
        not say the direction of a joint's last motion, the row before does.

    Returns
    -------
    tuple of Sweep
        By joint, then by nest.

    Raises
    ------
    ConfigurationError
        There are no rows in which one joint alone is away from where it stands most often.
    """
    order = _in_order(points)
    moved = _moved(points.stops.joints_rad)
    # Where no row has two joints away from their usual angles, the usual angles hold for the whole table.
    runs = _runs(points.stops.joints_rad[order]) if (moved.sum(axis=1) > 1).any() else []
    if sum(len(rows) for _, rows in runs) > np.count_nonzero(moved.sum(axis=1) <= 1):
        found = tuple(sweep for joint, rows in runs for sweep in _of_run(points, joint, order[rows]))
    else:
        found = tuple(
            sweep
            for nest in np.unique(points.nest).tolist()
            for sweep in _of_nest(points, nest, moved, order[points.nest[order] == nest])
        )
    if not found:
        raise ConfigurationError(
            "The table has no readings in which one joint moved while all others stood still. In a circle "
            "test, move one joint at a time."
        )
    return tuple(sorted(found, key=lambda sweep: (sweep.joint, sweep.nest)))


def _runs(joints_rad: FloatArray) -> list[tuple[int, IntArray]]:
    """Return the joint (1-based) and the rows of every run in which that joint alone moved."""
    found, first, turned = [], 0, -1
    # A row of infinities at the end differs in every joint, so that the last run is closed like all others.
    for row, joints in enumerate(np.vstack([joints_rad, np.full(joints_rad.shape[1], np.inf)])):
        moved = np.flatnonzero(np.abs(joints - joints_rad[first]) > SAME_ANGLE_RAD)
        if len(moved) == 0 or (len(moved) == 1 and turned in {-1, moved[0]}):
            turned = int(moved[0]) if len(moved) else turned
            continue
        if turned >= 0 and row - first >= _FEWEST:
            found.append((turned + 1, np.arange(first, row)))
        # The row that ended the run begins the next: it is the one from which the next joint sets out.
        first, turned = min(row, len(joints_rad) - 1), -1
    return found


def _of_run(points: PointReadings, joint: int, rows: IntArray) -> Iterator[Sweep]:
    """Yield the sweeps of a run of rows (m,), one a nest."""
    for nest in np.unique(points.nest[rows]).tolist():
        yield _sweep(points, joint, nest, rows[points.nest[rows] == nest])


def _of_nest(points: PointReadings, nest: int, moved: BoolArray, rows: IntArray) -> Iterator[Sweep]:
    """Yield the sweeps of one nest, all other joints at their usual angles."""
    rows = rows[moved[rows].sum(axis=1) <= 1]
    joint = _adopted(np.where(moved[rows].any(axis=1), moved[rows].argmax(axis=1) + 1, 0))
    for number in np.unique(joint[joint > 0]).tolist():
        yield _sweep(points, number, nest, rows[joint == number])


def _sweep(points: PointReadings, joint: int, nest: int, rows: IntArray) -> Sweep:
    """Return a sweep with the directions that the table states, or else the order of its angles tells."""
    angle = points.stops.joints_rad[rows, joint - 1]
    told = points.stops.direction
    known = np.zeros(len(rows), dtype=np.int64) if told is None else told[rows, joint - 1]
    return Sweep(joint, nest, rows, angle, np.where(known != 0, known, _direction(angle)))


def _in_order(points: PointReadings) -> IntArray:
    """Return all rows by time where all times are known, else as they stand, shape (n,)."""
    time_s = points.stops.time_s
    if time_s is None or not np.isfinite(time_s).all():
        return np.arange(len(points))
    return np.argsort(time_s, kind="stable")


def _moved(joints_rad: FloatArray) -> BoolArray:
    """Whether each joint is away from where it stands most often, shape (n, J)."""
    rest = np.array([_most_often(column) for column in joints_rad.T])
    return np.asarray(np.abs(joints_rad - rest) > SAME_ANGLE_RAD)


def _most_often(angles: FloatArray) -> float:
    """Return the angle about which most others lie, within what counts as the same [rad]."""
    ascending = np.sort(angles)
    below = np.searchsorted(ascending, ascending - SAME_ANGLE_RAD)
    above = np.searchsorted(ascending, ascending + SAME_ANGLE_RAD, side="right")
    return float(ascending[np.argmax(above - below)])


def _adopted(joint: IntArray) -> IntArray:
    """Return the joint of every row, shape (m,): that of the row before where none is moved, else after."""
    known = np.flatnonzero(joint)
    if not len(known):
        return joint
    before = np.searchsorted(known, np.arange(len(joint)), side="right") - 1
    return np.asarray(joint[known[np.maximum(before, 0)]])


def _direction(angle: FloatArray) -> IntArray:
    """Return the sign of the last motion that the order of the angles tells, shape (m,); 0 at the first."""
    step = np.diff(angle, prepend=angle[:1])
    sign = np.where(np.abs(step) > SAME_ANGLE_RAD, np.sign(step), 0.0).astype(np.int64)
    last = np.maximum.accumulate(np.where(sign != 0, np.arange(len(sign)), 0))
    return np.asarray(sign[last])


_ROUNDS: Final = 30
_SETTLED: Final = 1e-6  # change of the weights
_CONVERGED: Final = 1e-12  # of the radius
_HUBER: Final = 2.0  # scatters; beyond them a reading counts less, one in seven of clean ones
_GROSS: Final = 6.0
_MEDIAN_OF_TWO: Final = 1.1774  # of the norm of two standard normal variates
_LEAST_MM: Final = 1e-9  # below it positions of metres are rounded


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle through n readings.

    Attributes
    ----------
    centre_mm : ndarray, shape (3,)
    basis : ndarray, shape (3, 3)
        Rows, right-handed: two directions in the plane, then the axis.
    radius_mm : float
    covariance_mm2 : ndarray, shape (3, 3)
        Of the centre along the two directions, and of the radius.
    gross : ndarray of bool, shape (n,)
        Readings far off all others, in the plane or out of it.
    """

    centre_mm: FloatArray
    basis: FloatArray
    radius_mm: float
    covariance_mm2: FloatArray
    gross: BoolArray

    @property
    def radius_uncertainty_mm(self) -> float:
        """Standard uncertainty of the radius."""
        return float(np.sqrt(self.covariance_mm2[2, 2]))

    def local(self, points_mm: FloatArray) -> FloatArray:
        """Return points along the rows of the basis, from the centre, shape (n, 3) [mm]."""
        return np.asarray((points_mm - self.centre_mm) @ self.basis.T)

    def turned_over(self) -> "Circle":
        """Return the same circle with its axis the other way.

        Returns
        -------
        Circle
            Its two directions in the plane are exchanged, and with them rows and columns of the covariance.
        """
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
        # Full weight up to two scatters and 2 / distance beyond, so that the pull of a reading is bounded.
        before, soft = soft, np.minimum(1.0, _HUBER / np.maximum(far, _HUBER))
        if circle is None or np.abs(soft - before).max() < _SETTLED:
            break
    return circle


def _weighted(
    points_mm: FloatArray, weight: FloatArray, u_mm: FloatArray
) -> tuple[Circle | None, FloatArray]:
    """Return the circle of these weights, and how many scatters each point lies off it, shape (n,).

    None where the normal equations of centre and radius are singular: points in one place or on a line.
    """
    middle, basis = _plane(points_mm, weight)
    local = (points_mm - middle) @ basis.T
    centre = _flat_circle(local[:, :2], weight)
    radial, jacobian = _radial(local[:, :2], centre)
    far = _scatters_off(np.hypot(radial, local[:, 2]), u_mm)
    normal = jacobian.T @ (weight[:, None] * jacobian)
    covariance = covariance_of(normal) if normal.diagonal().all() else None
    if covariance is None or not np.isfinite(centre).all():
        return None, far
    # Of the residuals in the plane alone, over n - 3: errors out of it say nothing of centre and radius.
    widened = max(1.0, float(weight @ radial**2) / max(len(weight) - 3, 1))
    place = middle + centre[:2] @ basis[:2]
    return Circle(place, basis, float(centre[2]), covariance * widened, far > _GROSS), far


def _plane(points_mm: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the middle (3,) of points and the basis (3, 3) of their plane, its normal last."""
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
    """Return how many scatters points lie off, shape (n,), from what they are off by and state [mm].

    The scatter is that of the readings as a whole where it is larger than stated, by the median: the norm of
    two normal components (radial and axial) has the median 1.1774 sigma.
    """
    typical = float(np.median(off_mm / u_mm)) / _MEDIAN_OF_TWO
    return np.asarray(off_mm / np.maximum(u_mm * max(1.0, typical), _LEAST_MM))


@dataclass(frozen=True, slots=True)
class CircleErrors(Table):
    """Errors at m stops of one joint.

    Attributes
    ----------
    zero_rad : float
        Angle that the circle goes through: 0, or the nearest that was measured.
    radius_mm : float
        Of the circle through it.
    angle_rad, radial_mm, axial_mm, angular_rad : ndarray, shape (m,)
    angular_uncertainty_rad : ndarray, shape (m,)
        Readings and axis; 0 where the error is 0 by definition.
    reading_rad : ndarray, shape (m,)
        Standard uncertainty of a reading, as an angle.
    axis_rad : ndarray, shape (m, 2)
        Effect of one standard deviation of the axis, along its two directions.
    """

    zero_rad: float
    radius_mm: float
    angle_rad: FloatArray
    radial_mm: FloatArray
    axial_mm: FloatArray
    angular_rad: FloatArray
    angular_uncertainty_rad: FloatArray
    reading_rad: FloatArray
    axis_rad: FloatArray

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
    """Return the errors of readings about a circle.

    Parameters
    ----------
    circle : Circle
    points_mm : ndarray, shape (m, 3)
    u_mm : ndarray, shape (m,)
        Standard uncertainty of each, per axis.
    angle_rad : ndarray, shape (m,)
        Of the joint.

    Returns
    -------
    CircleErrors

    References
    ----------
    A. Nubiola, thesis, 2014, section 2.4.1 and Table 2.3.
    """
    circle = _along_the_joint(circle, points_mm, angle_rad)
    across, up, axial = circle.local(points_mm).T
    distance, offset = np.hypot(across, up), np.arctan2(up, across) - angle_rad
    at_zero = _at_zero(angle_rad)
    radius = float(distance[at_zero].mean())
    # Modulo a turn: joint 6 of Table 2.3 goes to 400 deg, an arc tangent to 180.
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
    # Turned less commanded angles stay together in one sense and run twice round in the other, whatever the
    # order of the readings.
    same, opposite = (abs(np.exp(1j * (sign * turned - angle_rad)).mean()) for sign in (1.0, -1.0))
    return circle if same >= opposite else circle.turned_over()


def _at_zero(angle_rad: FloatArray) -> BoolArray:
    """Return which readings are at the angle nearest to 0, shape (m,)."""
    nearest = angle_rad[np.argmin(np.abs(angle_rad))]
    return np.asarray(np.abs(angle_rad - nearest) <= SAME_ANGLE_RAD)


def _mean_angle(angles: FloatArray) -> float:
    """Return the circular mean of angles [rad]."""
    return float(np.angle(np.exp(1j * angles).mean()))


def _wrapped(angles: FloatArray) -> FloatArray:
    """Return angles within -pi to pi [rad]."""
    return np.asarray((angles + np.pi) % (2.0 * np.pi) - np.pi)


def _axis_effect(circle: Circle, across: FloatArray, up: FloatArray, at_zero: BoolArray) -> FloatArray:
    """Return what the angular errors change by for a standard deviation of the axis either way, (m, 2)."""
    distance = across**2 + up**2
    # d(phi)/d(centre) = (sin phi, -cos phi) / rho, less the same at zero: the error there is 0 whatever the
    # axis is.
    tangent = np.column_stack([up, -across]) / distance[:, None]
    root = np.linalg.cholesky(circle.covariance_mm2[:2, :2])
    return np.asarray((tangent - tangent[at_zero].mean(axis=0)) @ root)


def _reading_variance(reading: FloatArray, at_zero: BoolArray) -> FloatArray:
    """Return the variance from scatter, shape (m,); a reading at zero is part of what it is held against."""
    n = int(at_zero.sum())
    # Var(e_i - mean of e_0) = u_i^2 + sum u_0^2 / n^2, less 2 u_i^2 / n where i is one of the n.
    zero = float((reading[at_zero] ** 2).sum()) / n**2
    return np.asarray(reading**2 * np.where(at_zero, 1.0 - 2.0 / n, 1.0) + zero)
