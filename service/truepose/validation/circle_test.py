"""The single-axis circle test: per joint and nest its errors, and what they say about the joint.

Angular errors e at joint angles q tell gain, waves and backlash of the joint by one weighted fit,

    e = a + k (q - q0) - (b / 2) sign(last motion) + sum_m (c_m cos m q + s_m sin m q) + x . axis,

m as far as the arc holds its waves whole. The axis of the circle is itself uncertain, and where it is off,
that looks like a wave of one turn: its two directions are in the fit with what is known of them, x ~ N(0, I).
Backlash itself is found from pairs of readings at one angle, which needs none of the other terms.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import PointReadings
from truepose.identification.distributions import chi2_exceeded
from truepose.messages.message import Message, message
from truepose.validation.circle_errors import (
    SAME_ANGLE_RAD,
    Circle,
    CircleErrors,
    Sweep,
    errors_about,
    find_sweeps,
    fit_circle,
)
from truepose.validation.uncertainty import ROUNDING_MM, Figure

_HIGHEST_ORDER: Final = 2  # an encoder off centre makes one, an oval gear two; a diagnosis knows faster ones
_WHOLE: Final = 5.0 / 6.0  # of a period that the arc must hold
_FEWEST_LEFT: Final = 3  # degrees of freedom beside what is fitted
_SEEN: Final = float(np.sqrt(-2.0 * np.log(0.0027)))  # Rayleigh
BY_CHANCE: Final = 0.01  # so rarely noise alone shows errors as large


@dataclass(frozen=True, slots=True)
class Wave:
    """A wave of the angular error over the joint's angle: amplitude * cos(order * (angle - phase)).

    Attributes
    ----------
    order : int
        Periods a turn.
    amplitude_rad : Figure
    phase_rad : float
        Joint angle of a crest.
    """

    order: int
    amplitude_rad: Figure
    phase_rad: float

    @property
    def is_seen(self) -> bool:
        """Whether it is more than readings show by chance, as rarely as 3 u of a figure with a sign.

        The amplitude of noise alone follows Rayleigh, P(A > x u) = exp(-x^2 / 2), here 0.27 %.
        """
        return self.amplitude_rad.value > _SEEN * self.amplitude_rad.standard_uncertainty


@dataclass(frozen=True, slots=True)
class JointCurve:
    """What a joint's errors follow; None where the readings cannot tell.

    Attributes
    ----------
    gain : Figure or None
        k1 - 1: the joint turns by so much more than it should [1].
    waves : tuple of Wave
    left_rad : float
        RMS of what neither follows.
    noise_chance : float
        That scatter alone shows errors as large as these.
    """

    gain: Figure | None
    waves: tuple[Wave, ...]
    left_rad: float
    noise_chance: float

    @property
    def shows_something(self) -> bool:
        """Whether gain or waves are more than readings show."""
        gained = self.gain is not None and self.gain.is_seen
        return gained or any(wave.is_seen for wave in self.waves)


def backlash(errors: CircleErrors, direction: IntArray) -> Figure | None:
    """Return what the error is larger by coming from above than from below.

    Parameters
    ----------
    errors : CircleErrors
        Of m stops.
    direction : ndarray of int, shape (m,)
        Sign of the joint's last motion, 0 unknown.

    Returns
    -------
    Figure or None
        [rad]. The mean over all angles that were visited from both sides; None where there are none. The axis
        has no part in its uncertainty: at one angle it shifts both readings alike.
    """
    pairs = list(_both_ways(errors.angle_rad, direction))
    if not pairs:
        return None
    below, above = np.array(pairs).T
    difference = errors.angular_rad[above] - errors.angular_rad[below]
    variance = errors.reading_rad[above] ** 2 + errors.reading_rad[below] ** 2
    return Figure(float(difference.mean()), float(np.sqrt(variance.sum()) / len(pairs)))


def _both_ways(angle: FloatArray, direction: IntArray) -> Iterator[tuple[int, int]]:
    """Yield the reading from below and that from above of every angle that has both; each is used once."""
    above = np.flatnonzero(direction < 0).tolist()
    for below in np.flatnonzero(direction > 0).tolist():
        near = [row for row in above if abs(angle[row] - angle[below]) <= SAME_ANGLE_RAD]
        if near:
            # Each reading once: shared ones would make the uncertainty of the mean too small.
            above.remove(near[0])
            yield below, near[0]


def joint_curve(errors: CircleErrors, direction: IntArray) -> JointCurve:
    """Return what the angular errors of m stops follow.

    Parameters
    ----------
    errors : CircleErrors
    direction : ndarray of int, shape (m,)
        Sign of the joint's last motion, 0 unknown. Where both directions are known, stops of unknown ones do
        not say what they follow: they are off by half the backlash, to either side.

    Returns
    -------
    JointCurve
        Without gain and waves where fewer than three degrees of freedom would be left.
    """
    chance = _noise_chance(errors)
    if _two_sided(direction):
        told = np.flatnonzero(direction)
        errors, direction = errors.taken(told), direction[told]
    orders = _orders(errors, direction)
    columns = _columns(errors, direction, orders)
    if len(errors.angle_rad) < columns.shape[1] + _FEWEST_LEFT:
        return JointCurve(None, (), _rms(errors.angular_rad), chance)
    fit = _fitted(errors, columns)
    gain = Figure(float(fit.values[1]), float(np.sqrt(fit.covariance[1, 1])))
    first = columns.shape[1] - 2 * len(orders)
    waves = tuple(_wave(order, fit, first + 2 * k) for k, order in enumerate(orders))
    return JointCurve(gain, waves, _rms(errors.angular_rad - columns @ fit.values), chance)


@dataclass(frozen=True, slots=True)
class _Fit:
    """Fitted columns with their covariance; chi-square of residuals and prior, and its degrees of freedom."""

    values: FloatArray  # (K,)
    covariance: FloatArray  # (K, K)
    chi2: float
    degrees: int


def _fitted(errors: CircleErrors, columns: FloatArray) -> _Fit:
    """Fit columns (m, K) to the errors, the axis beside them with the prior that the circle gives."""
    weight = 1.0 / errors.reading_rad
    whole = np.hstack([columns, errors.axis_rad]) * weight[:, None]
    prior = np.hstack([np.zeros((2, columns.shape[1])), np.eye(2)])
    rows, seen = np.vstack([whole, prior]), np.append(errors.angular_rad * weight, [0.0, 0.0])
    inverse = np.linalg.pinv(rows)
    values = inverse @ seen
    chi2 = float(((seen - rows @ values) ** 2).sum())
    # The axis is fitted too, and its prior is an observation of it: two parameters more, two observations
    # more.
    n, degrees = columns.shape[1], len(columns) - columns.shape[1]
    scale = max(1.0, chi2 / max(degrees, 1))
    return _Fit(values[:n], (inverse @ inverse.T)[:n, :n] * scale, chi2, degrees)


def _noise_chance(errors: CircleErrors) -> float:
    """Return how likely scatter of readings and axis shows errors as large about one constant."""
    fit = _fitted(errors, np.ones((len(errors.angle_rad), 1)))
    return chi2_exceeded(fit.chi2, fit.degrees)


def _columns(errors: CircleErrors, direction: IntArray, orders: list[int]) -> FloatArray:
    """Return constant, gain, backlash where both sides are known, and waves, shape (m, K)."""
    angle = errors.angle_rad - errors.zero_rad
    columns: list[FloatArray] = [np.ones(len(angle)), angle]
    if _two_sided(direction):
        columns.append(np.asarray(-0.5 * direction))
    for order in orders:
        columns += [np.cos(order * errors.angle_rad), np.sin(order * errors.angle_rad)]
    return np.column_stack(columns)


def _two_sided(direction: IntArray) -> bool:
    """Whether readings came from both sides."""
    return bool((direction > 0).any() and (direction < 0).any())


def _orders(errors: CircleErrors, direction: IntArray) -> list[int]:
    """Return the orders whose period the arc holds, as long as the different angles suffice for them."""
    span = np.ptp(errors.angle_rad)
    whole = [m for m in range(1, _HIGHEST_ORDER + 1) if m * span >= _WHOLE * 2.0 * np.pi]
    places = _places(errors.angle_rad)
    # A wave needs different angles, not readings: a full turn more brings the joint to the same places.
    while whole and _columns(errors, direction, whole).shape[1] + _FEWEST_LEFT > places:
        whole = whole[:-1]
    return whole


def _places(angle_rad: FloatArray) -> int:
    """Return how many different places a turning point takes at these angles."""
    turned = np.sort(angle_rad % (2.0 * np.pi))
    gaps = np.diff(turned, append=turned[0] + 2.0 * np.pi)
    return max(1, int((gaps > SAME_ANGLE_RAD).sum()))


def _wave(order: int, fit: _Fit, column: int) -> Wave:
    """Return a wave by its cosine and sine; u is that along its own phase."""
    cos, sin = (float(value) for value in fit.values[column : column + 2])
    amplitude = float(np.hypot(cos, sin))
    along = np.array([cos, sin]) / amplitude if amplitude else np.array([1.0, 0.0])
    variance = along @ fit.covariance[column : column + 2, column : column + 2] @ along
    return Wave(order, Figure(amplitude, float(np.sqrt(variance))), float(np.arctan2(sin, cos)) / order)


def _rms(values: FloatArray) -> float:
    """Return the root mean square."""
    return float(np.sqrt((values**2).mean()))


_FEWEST_ANGLES: Final = 4  # three places lie on a circle whatever they are
_COARSE_RAD: Final = float(np.radians(0.1))  # joints of small arms err by less
_UNCERTAIN: Final = 0.02  # of the radius; beyond it a good part of the angular errors is the circle's own


@dataclass(frozen=True, slots=True)
class JointCircle:
    """What a sweep of one joint shows at one nest.

    Attributes
    ----------
    joint, nest : int
        1-based.
    interval_rad : tuple of float
        Least and greatest angle.
    increment_rad : float
        Median distance of neighbouring angles.
    circle : Circle
    errors : CircleErrors
        At m stops.
    direction : ndarray of int, shape (m,)
        Of the stops of `errors`.
    config : ndarray of int, shape (m,)
    set_aside : tuple of int
        Configurations whose readings lie far off plane or circle.
    backlash_rad : Figure or None
        None: no angle was visited from both sides.
    curve : JointCurve
    """

    joint: int
    nest: int
    interval_rad: tuple[float, float]
    increment_rad: float
    circle: Circle
    errors: CircleErrors
    direction: IntArray
    config: IntArray
    set_aside: tuple[int, ...]
    backlash_rad: Figure | None
    curve: JointCurve

    @property
    def is_noise(self) -> bool:
        """Whether scatter alone shows errors as large, and no figure of the joint stands out of it.

        All errors together hide a gain of a few uncertainties, which one figure shows: gains of four
        uncertainties of a short arc once stood below a sentence that no error is seen.
        """
        gap = self.backlash_rad
        shown = self.curve.shows_something or (gap is not None and gap.is_seen)
        return self.curve.noise_chance >= BY_CHANCE and not shown

    @property
    def tangential_range_mm(self) -> Figure:
        """Largest less smallest tangential error."""
        turned, radius = self.angular_range_rad, self.errors.radius_mm
        return Figure(turned.value * radius, turned.standard_uncertainty * radius)

    @property
    def angular_range_rad(self) -> Figure:
        """Largest less smallest angular error."""
        return _range(self.errors)

    @property
    def radial_range_mm(self) -> float:
        """Largest less smallest radial error."""
        return float(np.ptp(self.errors.radial_mm))

    @property
    def axial_range_mm(self) -> float:
        """Largest less smallest axial error."""
        return float(np.ptp(self.errors.axial_mm))


@dataclass(frozen=True, slots=True)
class MissingCircle:
    """A sweep that gives no circle, and why."""

    joint: int
    nest: int
    reason: Message


@dataclass(frozen=True, slots=True)
class CircleTest:
    """All sweeps of a table, by joint and nest."""

    circles: tuple[JointCircle, ...]
    withheld: tuple[MissingCircle, ...]

    @property
    def joints_without(self) -> tuple[int, ...]:
        """Joints that no nest gives a circle of."""
        return tuple(sorted({one.joint for one in self.withheld} - {one.joint for one in self.circles}))


def circle_test(points: PointReadings) -> CircleTest:
    """Return what each joint errs by, turned alone.

    Parameters
    ----------
    points : PointReadings
        n >= 1 rows, in any frame. A standard uncertainty of 0 is taken for a millionth of a millimetre.

    Returns
    -------
    CircleTest
        By joint and nest; a sweep that gives no circle has a reason instead.

    Raises
    ------
    ConfigurationError
        No joint is turned alone.
    """
    stated = np.maximum(points.standard_uncertainty_mm, ROUNDING_MM)
    points = replace(points, standard_uncertainty_mm=stated)
    judged = [_judged(points, sweep) for sweep in find_sweeps(points)]
    return CircleTest(
        tuple(one for one in judged if isinstance(one, JointCircle)),
        tuple(one for one in judged if isinstance(one, MissingCircle)),
    )


def _judged(points: PointReadings, sweep: Sweep) -> JointCircle | MissingCircle:
    """Return the circle of a sweep, or why it gives none."""
    angles = _different(sweep.angle_rad)
    if len(angles) < _FEWEST_ANGLES:
        return MissingCircle(sweep.joint, sweep.nest, message("circles.few", angles=len(angles)))
    read, u_mm = points.position_mm[sweep.rows], points.standard_uncertainty_mm[sweep.rows]
    circle = _usable(fit_circle(read, u_mm), float(np.median(u_mm)), float(np.ptp(angles)))
    if isinstance(circle, Message):
        return MissingCircle(sweep.joint, sweep.nest, circle)
    # Gross readings may leave fewer places than a circle needs, whatever the fit says.
    left = len(_different(sweep.angle_rad[~circle.gross]))
    if left < _FEWEST_ANGLES:
        return MissingCircle(sweep.joint, sweep.nest, message("circles.few", angles=left))
    return _of_circle(points, sweep, circle)


def _of_circle(points: PointReadings, sweep: Sweep, circle: Circle) -> JointCircle:
    """Return what a sweep shows about its circle, gross readings left out."""
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


def _usable(circle: Circle | None, u_mm: float, arc_rad: float) -> Circle | Message:
    """Return the circle, or why it tells nothing of the joint."""
    if circle is None:
        return message("circles.none")
    # A nest on the joint's own axis hardly moves: its angular errors would be those of the instrument.
    if u_mm > _COARSE_RAD * circle.radius_mm:
        u_deg = float(np.degrees(u_mm / circle.radius_mm))
        return message("circles.near", radius_mm=circle.radius_mm, u_deg=u_deg)
    if circle.radius_uncertainty_mm > _UNCERTAIN * circle.radius_mm:
        arc_deg, u_radius_mm = float(np.degrees(arc_rad)), circle.radius_uncertainty_mm
        return message("circles.short", arc_deg=arc_deg, radius_mm=circle.radius_mm, u_mm=u_radius_mm)
    return circle


def _range(errors: CircleErrors) -> Figure:
    """Return the range of the angular errors [rad]; the axis is off for both of its ends alike.

    What is read at zero, against which both are held, cancels.
    """
    ends = [int(errors.angular_rad.argmax()), int(errors.angular_rad.argmin())]
    axis = float(np.linalg.norm(np.subtract(*errors.axis_rad[ends])))
    return Figure(
        float(np.ptp(errors.angular_rad)), float(np.hypot(np.hypot(*errors.reading_rad[ends]), axis))
    )
