"""Rigid motions as parameters, and when they happen: jumps, and the times of readings.

*Times.* While a model is made, nothing runs or happens for rows that do not tell when they are. Once it is
made, such a row is about the robot as the last reading left it: what has happened is past.

*Jumps:* something stood still, jumped once, and stood still again. A parameter `<prefix>_<time>_<component>`
acts from that time [s] on. Every gap between two stops may hold the jump; a jump within a gap cannot be
placed any better than the gap.

What moves on and on is a drift (`drifts`).
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.campaign import Stops
from truepose.domain.diagnosis import Detail
from truepose.domain.identification import Unit
from truepose.effects.causes import FittedCause, Scene, has_spread, norm_with_uncertainty
from truepose.effects.ports import ParameterSpec, Port, Rows, Term
from truepose.messages.message import Message, Text, message

SECONDS_PER_HOUR = 3600.0


def moments_s(rows: Rows) -> FloatArray:
    """Return the time of each row.

    Parameters
    ----------
    rows : Rows
        n of them.

    Returns
    -------
    ndarray, shape (n,)
        [s]; where it is unknown NaN, of a made model infinity: such a row is about the robot as it was left.
    """
    # NaN compares false with every moment, so that while a model is made nothing has happened there; infinity
    # compares true, so that in a made model everything has.
    unknown = np.nan if rows.last_s is None else np.inf
    time_s = rows.stops.time_s
    if time_s is None:
        return np.full(len(rows.stops), unknown)
    return np.where(np.isfinite(time_s), time_s, unknown)


def hours_since(rows: Rows, start_s: float) -> FloatArray:
    """Return the time of each row after a moment [s], shape (n,) [h]; as `moments_s` where it is unknown."""
    return np.asarray((moments_s(rows) - start_s) / SECONDS_PER_HOUR)


def hours_followed(rows: Rows) -> FloatArray:
    """Return the time after the origin as far as readings followed it, NaN where unknown.

    Beyond the first and the last reading of a made model it stands still (docs/decisions/0028).

    Parameters
    ----------
    rows : Rows
        n of them.

    Returns
    -------
    ndarray, shape (n,)
        [h]
    """
    hours = hours_since(rows, rows.origin_s)
    if rows.last_s is None:
        return hours
    return np.clip(hours, 0.0, (rows.last_s - rows.origin_s) / SECONDS_PER_HOUR)


def duration_s(scene: Scene) -> float:
    """Return how long after the origin of times the last reading was taken [s]; 0 without times."""
    time_s = scene.stops.time_s
    known = np.zeros(0) if time_s is None else time_s[np.isfinite(time_s)]
    return float(known.max() - scene.origin_s) if known.size else 0.0


def without_times(scene: Scene) -> Text | None:
    """Return why nothing that runs in time can be seen, None where it can."""
    if has_spread(scene.stops.time_s):
        return None
    return message("unseen.no_times")


def spoken(seconds: float) -> Message:
    """Return a span of time as one says it, e.g. `21 min`: seconds below 2 min, hours from 2 h on."""
    if seconds < 120.0:
        return message("span.seconds", seconds=seconds)
    if seconds < 2.0 * SECONDS_PER_HOUR:
        return message("span.minutes", minutes=seconds / 60.0)
    return message("span.hours", hours=seconds / SECONDS_PER_HOUR)


COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")


class Widths(NamedTuple):
    """What is believed of a motion before any reading: standard deviations per axis, and their units.

    Attributes
    ----------
    shift, turn : float
    shift_unit, turn_unit : Unit
        mm and rad, or both per h.
    """

    shift: float
    turn: float
    shift_unit: Unit = "mm"
    turn_unit: Unit = "rad"


class Motion(NamedTuple):
    """A small motion as it was fitted: shift and turn about the three axes [mm and rad, or both per h].

    Attributes
    ----------
    vector : ndarray, shape (6,)
    covariance : ndarray, shape (6, 6)
    """

    vector: FloatArray  # (6,)
    covariance: FloatArray  # (6, 6)

    @property
    def shift(self) -> tuple[float, float]:
        """Length of the shift and its standard uncertainty."""
        return norm_with_uncertainty(self.vector[:3], self.covariance[:3, :3])

    @property
    def turn_deg(self) -> tuple[float, float]:
        """Angle of the turn and its standard uncertainty, in degrees."""
        angle, uncertainty = norm_with_uncertainty(self.vector[3:], self.covariance[3:, 3:])
        return float(np.rad2deg(angle)), float(np.rad2deg(uncertainty))

    def details(self, per: str = "") -> tuple[Detail, ...]:
        """Return the components of the shift and the size of the turn; `per` is e.g. `/h`."""
        spread = np.sqrt(np.diag(self.covariance))
        shifts = [
            Detail(axis, float(self.vector[k]), f"mm{per}", float(spread[k]))
            for k, axis in enumerate(COMPONENTS[:3])
        ]
        return (*shifts, Detail("rotation", self.turn_deg[0], f"deg{per}", self.turn_deg[1]))

    def seen_at(self, point_mm: FloatArray) -> "Motion":
        """Return the motion whose shift is that of a point p, s + w x p; this one's is that of the origin.

        Parameters
        ----------
        point_mm : ndarray, shape (3,)
        """
        x, y, z = (float(value) for value in point_mm)
        carry = np.eye(6)
        carry[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]  # turn x point
        return Motion(carry @ self.vector, carry @ self.covariance @ carry.T)


def motion_specs(prefix: str, widths: Widths) -> tuple[ParameterSpec, ...]:
    """Return the six parameters `<prefix>_x` .. `<prefix>_rz`, shifts first.

    Parameters
    ----------
    prefix : str
    widths : Widths
    """
    shifts = (
        ParameterSpec(f"{prefix}_{name}", widths.shift_unit, 0.0, widths.shift) for name in COMPONENTS[:3]
    )
    turns = (ParameterSpec(f"{prefix}_{name}", widths.turn_unit, 0.0, widths.turn) for name in COMPONENTS[3:])
    return (*shifts, *turns)


def split_motion(name: str) -> tuple[str, int]:
    """Return prefix and component (0..5) of e.g. `seat_2_rx`."""
    prefix, _, component = name.rpartition("_")
    return prefix, COMPONENTS.index(component)


def fitted_motion(fitted: FittedCause, share: Callable[[str], float]) -> Motion:
    """Add up fitted motions, each parameter counted by the share that its prefix has in the sum.

    Parameters
    ----------
    fitted : FittedCause
        Of parameters `<prefix>_<component>`.
    share : callable
        Prefix to number: 1 and 0 choose, a way per rate makes rates of several shapes comparable.
    """
    gather = np.zeros((6, len(fitted.names)))
    for k, name in enumerate(fitted.names):
        prefix, component = split_motion(name)
        gather[component, k] = share(prefix)
    return Motion(gather @ fitted.values, gather @ fitted.covariance @ gather.T)


_LEAST_POSITIONS = 4  # on either side: six parameters need more than two
_LEAST_LENGTHS = 12
_MOST = 120  # gaps that are tried; of more, every second or third


class Gap(NamedTuple):
    """A time between two stops.

    Attributes
    ----------
    middle_s, width_s : float
        The width is above 0.
    """

    middle_s: float
    width_s: float

    @property
    def label(self) -> str:
        """The time as names carry it: with as many decimals as keep it within the gap."""
        # Rounding moves the time by an eighth of the gap at most: the jump stays in its gap.
        decimals = max(0, int(np.ceil(-np.log10(self.width_s / 4.0))))
        return f"{self.middle_s:.{decimals}f}"


def gaps_of_all(scene: Scene) -> tuple[Gap, ...]:
    """Return the gaps with enough of all readings on either side for a rigid motion.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    tuple of Gap
        In the order of time.
    """
    least = _LEAST_LENGTHS if scene.legs else _LEAST_POSITIONS
    return gaps(scene.stops, np.ones(len(scene.stops), dtype=bool), least)


def gaps(stops: Stops, rows: BoolArray, least_readings: int) -> tuple[Gap, ...]:
    """Return the gaps between stops that have enough readings on either side, in the order of time.

    Parameters
    ----------
    stops : Stops
        n of them.
    rows : ndarray of bool, shape (n,)
        Readings that count.
    least_readings : int
        On either side.

    Returns
    -------
    tuple of Gap
        None without times. Readings of one stop have no gap between them.
    """
    if stops.time_s is None:
        return ()
    # Readings without a time lie on neither side of a moment.
    chosen = np.flatnonzero(rows & np.isfinite(stops.time_s))
    order = chosen[np.argsort(stops.time_s[chosen], kind="stable")]
    time_s, config = stops.time_s[order], stops.config[order]
    ends = np.arange(1, len(order))
    apart = (config[1:] != config[:-1]) & (np.diff(time_s) > 0.0)
    enough = (ends >= least_readings) & (len(order) - ends >= least_readings)
    return tuple(
        Gap(float(time_s[k - 1] + time_s[k]) / 2.0, float(time_s[k] - time_s[k - 1]))
        for k in ends[apart & enough].tolist()
    )


def tried(
    found: tuple[Gap, ...], between_s: tuple[float, float] | None, most: int = _MOST
) -> tuple[Gap, ...]:
    """Return the gaps at which a jump is tried: all between two moments, else at most so many, evenly.

    Parameters
    ----------
    found : tuple of Gap
        In the order of time.
    between_s : tuple of float, or None
        The two moments, themselves not among them.
    most : int
    """
    if between_s is None:
        # Every second or third: the very gap is searched again around the best one, all gaps then.
        return found[:: max(1, -(-len(found) // most))]
    return tuple(gap for gap in found if between_s[0] < gap.middle_s < between_s[1])


def around(found: tuple[Gap, ...], time_s: float) -> Gap:
    """Return the gap that holds a time, the nearest where none does.

    Parameters
    ----------
    found : tuple of Gap
        One or more.
    time_s : float
    """
    return min(found, key=lambda gap: abs(gap.middle_s - time_s))


class FittedJumps(NamedTuple):
    """Jumps of one thing as they were fitted, in the order of time, as somebody would tell it.

    Attributes
    ----------
    times_s : tuple of float
    motions : tuple of Motion
    """

    times_s: tuple[float, ...]
    motions: tuple[Motion, ...]

    @property
    def largest(self) -> tuple[float, Motion]:
        """The one that shifts farthest, with its time [s]."""
        largest = int(np.argmax([motion.shift[0] for motion in self.motions]))
        return self.times_s[largest], self.motions[largest]

    def details(self, found: tuple[Gap, ...]) -> tuple[Detail, ...]:
        """Return the time and the motion of each, told by the gaps in which they may lie."""
        return tuple(
            detail
            for time_s, motion in zip(self.times_s, self.motions, strict=True)
            for detail in (_moment_of(time_s, found), *motion.details())
        )


def fitted_jumps(fitted: FittedCause, point_mm: FloatArray | None = None) -> FittedJumps:
    """Return the jumps that parameters `<prefix>_<time>_<component>` are of.

    Parameters
    ----------
    fitted : FittedCause
    point_mm : ndarray, shape (3,), optional
        Whose shifts are told; that of the origin otherwise.
    """
    prefixes = sorted({split_motion(name)[0] for name in fitted.names}, key=jump_time_s)
    motions = (_of_prefix(fitted, prefix) for prefix in prefixes)
    seen = (motion if point_mm is None else motion.seen_at(point_mm) for motion in motions)
    return FittedJumps(tuple(map(jump_time_s, prefixes)), tuple(seen))


def _of_prefix(fitted: FittedCause, chosen: str) -> Motion:
    return fitted_motion(fitted, lambda prefix: float(prefix == chosen))


def _moment_of(time_s: float, found: tuple[Gap, ...]) -> Detail:
    """Return the time of a jump: anywhere within its gap, evenly spread, hence width / sqrt(12)."""
    width_s = around(found, time_s).width_s if found else 0.0
    return Detail("time", time_s, "s", width_s / float(np.sqrt(12.0)))


def jump_terms(names: tuple[str, ...], rows: Rows, port: Callable[[str, int], Port]) -> list[Term]:
    """Move ports of each prefix and component from the prefix's time on: weight 0 before it, 1 from it on.

    Parameters
    ----------
    names : tuple of str
        `<prefix>_<time>_<component>`.
    rows : Rows
    port : callable
        Prefix and component to port.
    """
    split = [split_motion(name) for name in names]
    later = {prefix: since(rows, jump_time_s(prefix)) for prefix, _ in split}
    return [Term(k, port(prefix, component), later[prefix]) for k, (prefix, component) in enumerate(split)]


def jump_time_s(prefix: str) -> float:
    """Return the time of e.g. `jump_1234.5`."""
    return float(prefix.rsplit("_", 1)[1])


def since(rows: Rows, time_s: float) -> FloatArray:
    """Return 1 from a moment on, 0 before it and where a time is missing to make a model.

    Parameters
    ----------
    rows : Rows
        n of them.
    time_s : float

    Returns
    -------
    ndarray, shape (n,)
    """
    return np.asarray(moments_s(rows) >= time_s, dtype=float)
