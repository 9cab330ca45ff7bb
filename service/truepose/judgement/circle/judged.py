"""The single-axis circle test of a table of points: per joint and nest its errors, or why there are none."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.campaign import PointReadings
from truepose.domain.sentences import Sentence, said
from truepose.judgement.circle.errors import CircleErrors, errors_about
from truepose.judgement.circle.fit import Circle, fit_circle
from truepose.judgement.circle.joint_curve import BY_CHANCE, JointCurve, backlash, joint_curve
from truepose.judgement.circle.sweeps import SAME_ANGLE_RAD, Sweep, find_sweeps
from truepose.judgement.figure import Figure

_FEWEST_ANGLES: Final = 4  # three places lie on a circle whatever they are
_COARSE_RAD: Final = float(np.radians(0.1))  # joints of small arms err by less
_UNCERTAIN: Final = 0.02  # of the radius; beyond it a good part of the angular errors is the circle's own


@dataclass(frozen=True, slots=True)
class JointCircle:
    """What a sweep of one joint shows at one nest."""

    joint: int
    nest: int
    interval_rad: tuple[float, float]
    increment_rad: float  # median distance of neighbouring angles
    circle: Circle
    errors: CircleErrors
    direction: IntArray  # (m,) of the stops of `errors`
    config: IntArray  # (m,)
    set_aside: tuple[int, ...]  # configurations whose readings lie far off plane or circle
    backlash_rad: Figure | None  # None: no angle was visited from both sides
    curve: JointCurve

    @property
    def is_noise(self) -> bool:
        """Whether scatter alone shows errors as large, and no figure of the joint stands out of it.

        All errors together hide a gain of a few uncertainties, which one figure shows.
        """
        gap = self.backlash_rad
        shown = self.curve.shows_something or (gap is not None and gap.is_seen)
        return self.curve.noise_chance >= BY_CHANCE and not shown

    @property
    def tangential_range_mm(self) -> Figure:
        """Largest less smallest tangential error."""
        return _range(self.errors.tangential_mm, self.errors.tangential_uncertainty_mm)

    @property
    def angular_range_rad(self) -> Figure:
        """Largest less smallest angular error."""
        return _range(self.errors.angular_rad, self.errors.angular_uncertainty_rad)

    @property
    def radial_range_mm(self) -> float:
        """Largest less smallest radial error."""
        return float(np.ptp(self.errors.radial_mm))

    @property
    def axial_range_mm(self) -> float:
        """Largest less smallest axial error."""
        return float(np.ptp(self.errors.axial_mm))


@dataclass(frozen=True, slots=True)
class WithheldCircle:
    """A sweep that gives no circle, and why."""

    joint: int
    nest: int
    reason: Sentence


@dataclass(frozen=True, slots=True)
class CircleTest:
    """All sweeps of a table, by joint and nest."""

    circles: tuple[JointCircle, ...]
    withheld: tuple[WithheldCircle, ...]

    @property
    def joints_without(self) -> tuple[int, ...]:
        """Joints that no nest gives a circle of."""
        return tuple(sorted({one.joint for one in self.withheld} - {one.joint for one in self.circles}))


def circle_test(points: PointReadings) -> CircleTest:
    """Return what each joint errs by, turned alone.

    Parameters
    ----------
    points : PointReadings
        n >= 1 rows, in any frame.

    Raises
    ------
    ConfigurationError
        No joint is turned alone.
    """
    judged = [_judged(points, sweep) for sweep in find_sweeps(points)]
    return CircleTest(
        tuple(one for one in judged if isinstance(one, JointCircle)),
        tuple(one for one in judged if isinstance(one, WithheldCircle)),
    )


def _judged(points: PointReadings, sweep: Sweep) -> JointCircle | WithheldCircle:
    angles = _different(sweep.angle_rad)
    if len(angles) < _FEWEST_ANGLES:
        return WithheldCircle(sweep.joint, sweep.nest, said("circles.few", angles=len(angles)))
    read, u_mm = points.position_mm[sweep.rows], points.standard_uncertainty_mm[sweep.rows]
    circle = _usable(fit_circle(read, u_mm), float(np.median(u_mm)), float(np.ptp(angles)))
    if isinstance(circle, Sentence):
        return WithheldCircle(sweep.joint, sweep.nest, circle)
    return _of_circle(points, sweep, circle)


def _of_circle(points: PointReadings, sweep: Sweep, circle: Circle) -> JointCircle:
    kept = ~circle.gross
    rows, direction = sweep.rows[kept], sweep.direction[kept]
    read, u_mm = points.position_mm[rows], points.standard_uncertainty_mm[rows]
    errors = errors_about(circle, read, u_mm, sweep.angle_rad[kept])
    angles = _different(errors.angle_rad)
    return JointCircle(
        joint=sweep.joint,
        nest=sweep.nest,
        interval_rad=(float(angles[0]), float(angles[-1])),
        increment_rad=float(np.median(np.diff(angles))),
        circle=circle,
        errors=errors,
        direction=direction,
        config=points.stops.config[rows],
        set_aside=tuple(points.stops.config[sweep.rows[circle.gross]].tolist()),
        backlash_rad=backlash(errors, direction),
        curve=joint_curve(errors, direction),
    )


def _different(angle_rad: FloatArray) -> FloatArray:
    """Return the different angles, ascending."""
    ascending = np.sort(angle_rad)
    return np.asarray(ascending[np.diff(ascending, prepend=-np.inf) > SAME_ANGLE_RAD])


def _usable(circle: Circle | None, u_mm: float, arc_rad: float) -> Circle | Sentence:
    """Return the circle, or why it tells nothing of the joint."""
    if circle is None:
        return said("circles.none")
    if u_mm > _COARSE_RAD * circle.radius_mm:
        u_deg = float(np.degrees(u_mm / circle.radius_mm))
        return said("circles.near", radius_mm=circle.radius_mm, u_deg=u_deg)
    if circle.radius_uncertainty_mm > _UNCERTAIN * circle.radius_mm:
        arc_deg, u_radius_mm = float(np.degrees(arc_rad)), circle.radius_uncertainty_mm
        return said("circles.short", arc_deg=arc_deg, radius_mm=circle.radius_mm, u_mm=u_radius_mm)
    return circle


def _range(values: FloatArray, uncertainty: FloatArray) -> Figure:
    ends = [int(values.argmax()), int(values.argmin())]
    return Figure(float(np.ptp(values)), float(np.hypot(*uncertainty[ends])))
