"""What the angular errors of a sweep say about the joint: its gain, its waves, its backlash, or nothing.

One weighted fit: constant, gain, the two directions, waves as far as the arc holds them whole. The axis of
the circle is itself uncertain, and where it is off, that looks like a wave of one turn: its two
directions are in the fit with what is known of them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.identification.distributions import chi2_exceeded
from truepose.judgement.circle.errors import CircleErrors
from truepose.judgement.circle.sweeps import SAME_ANGLE_RAD
from truepose.judgement.figure import Figure

_HIGHEST_ORDER: Final = 2  # an encoder off centre makes one, an oval gear two; a diagnosis knows faster ones
_WHOLE: Final = 5.0 / 6.0  # of a period that the arc must hold
_FEWEST_LEFT: Final = 3  # degrees of freedom beside what is fitted
_SEEN: Final = float(np.sqrt(-2.0 * np.log(0.0027)))  # Rayleigh
BY_CHANCE: Final = 0.01  # so rarely noise alone shows errors as large


@dataclass(frozen=True, slots=True)
class Wave:
    """A wave of the angular error over the joint's angle: amplitude * cos(order * (angle - phase))."""

    order: int  # periods a turn
    amplitude_rad: Figure
    phase_rad: float

    @property
    def is_seen(self) -> bool:
        """Whether it is more than readings show by chance, as rarely as 3 u of a figure with a sign."""
        return self.amplitude_rad.value > _SEEN * self.amplitude_rad.standard_uncertainty


@dataclass(frozen=True, slots=True)
class JointCurve:
    """What a joint's errors follow; None where the readings cannot tell."""

    gain: Figure | None  # k1 - 1: the joint turns by so much more than it should
    waves: tuple[Wave, ...]
    left_rad: float  # RMS of what neither follows
    noise_chance: float  # that scatter alone shows errors as large as these

    @property
    def shows_something(self) -> bool:
        """Whether gain or waves are more than readings show."""
        gained = self.gain is not None and self.gain.is_seen
        return gained or any(wave.is_seen for wave in self.waves)


def backlash(errors: CircleErrors, direction: IntArray) -> Figure | None:
    """Return what the error is larger by coming from above than from below [rad].

    Parameters
    ----------
    errors : CircleErrors
        Of m stops.
    direction : ndarray, shape (m,)
        Sign of the joint's last motion, 0 unknown.

    Returns
    -------
    Figure or None
        The mean over all angles that were visited from both sides; None where there are none.
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
            above.remove(near[0])
            yield below, near[0]


def joint_curve(errors: CircleErrors, direction: IntArray) -> JointCurve:
    """Return what the angular errors of m stops follow; `direction` as above.

    Where both directions are known, stops of unknown ones do not say what they follow: they are off by half
    the backlash, to either side.
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
    n, degrees = columns.shape[1], len(columns) - columns.shape[1]
    scale = max(1.0, chi2 / max(degrees, 1))
    return _Fit(values[:n], (inverse @ inverse.T)[:n, :n] * scale, chi2, degrees)


def _noise_chance(errors: CircleErrors) -> float:
    """Return how likely scatter of readings and axis shows errors as large about one constant."""
    fit = _fitted(errors, np.ones((len(errors.angle_rad), 1)))
    return chi2_exceeded(fit.chi2, fit.degrees)


def _columns(errors: CircleErrors, direction: IntArray, orders: list[int]) -> FloatArray:
    angle = errors.angle_rad - errors.zero_rad
    columns: list[FloatArray] = [np.ones(len(angle)), angle]
    if _two_sided(direction):
        columns.append(np.asarray(-0.5 * direction))
    for order in orders:
        columns += [np.cos(order * errors.angle_rad), np.sin(order * errors.angle_rad)]
    return np.column_stack(columns)


def _two_sided(direction: IntArray) -> bool:
    return bool((direction > 0).any() and (direction < 0).any())


def _orders(errors: CircleErrors, direction: IntArray) -> list[int]:
    """Return the orders whose period the arc holds, as long as the different angles suffice for them."""
    span = np.ptp(errors.angle_rad)
    whole = [m for m in range(1, _HIGHEST_ORDER + 1) if m * span >= _WHOLE * 2.0 * np.pi]
    places = _places(errors.angle_rad)
    while whole and _columns(errors, direction, whole).shape[1] + _FEWEST_LEFT > places:
        whole = whole[:-1]
    return whole


def _places(angle_rad: FloatArray) -> int:
    """Return how many different places a turning point takes at these angles."""
    turned = np.sort(angle_rad % (2.0 * np.pi))
    gaps = np.diff(turned, append=turned[0] + 2.0 * np.pi)
    return max(1, int((gaps > SAME_ANGLE_RAD).sum()))


def _wave(order: int, fit: _Fit, column: int) -> Wave:
    cos, sin = (float(value) for value in fit.values[column : column + 2])
    amplitude = float(np.hypot(cos, sin))
    along = np.array([cos, sin]) / amplitude if amplitude else np.array([1.0, 0.0])
    variance = along @ fit.covariance[column : column + 2, column : column + 2] @ along
    return Wave(order, Figure(amplitude, float(np.sqrt(variance))), float(np.arctan2(sin, cos)) / order)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt((values**2).mean()))
