"""Configurations to measure next: drawn within what was measured or the joints' limits."""

from dataclasses import dataclass

import numpy as np

from truepose.diagnosis.baseline_fit import Start
from truepose.diagnosis.screening.selection import Selection
from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Stops
from truepose.identification.model.evaluation import State, Targets, evaluate, rows_of
from truepose.kinematics.chain import Chain, forward, nominal_values
from truepose.kinematics.gravity import moment_regressor

_STEP_DEG = 0.01  # what an operator types, and far less than what a configuration is chosen for
_SLACK = 1e-6  # of a step: a limit of whole hundredths stays inside itself


@dataclass(frozen=True, slots=True)
class Places:
    """c configurations, one nest read in each; everything else as at the last reading.

    Attributes
    ----------
    joints_deg : ndarray, shape (c, J)
        Whole steps of 0.01 deg.
    state : State
        Of the extended model.
    """

    joints_deg: FloatArray
    state: State

    @property
    def torque_n_mm(self) -> FloatArray | None:
        """Torques about the joints, shape (c, J); None where they are unknown."""
        return rows_of(self.state).torque_n_mm


@dataclass(frozen=True, slots=True)
class Ranges:
    """Where each joint may be sent, shape (J,) each."""

    low_deg: FloatArray
    high_deg: FloatArray

    def drawn(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Draw configurations evenly, shape (count, J) [deg]."""
        spread = self.high_deg - self.low_deg
        return self.low_deg + spread * rng.random((count, len(spread)))

    def rounded(self, joints_deg: FloatArray) -> FloatArray:
        """Round configurations to whole steps inside.

        Parameters
        ----------
        joints_deg : ndarray, shape (c, J)

        Returns
        -------
        ndarray, shape (c, J)
            [deg]; a joint that has no step inside stays in the middle of its range.
        """
        first = np.ceil(self.low_deg / _STEP_DEG - _SLACK)
        last = np.floor(self.high_deg / _STEP_DEG + _SLACK)
        steps = np.clip(np.round(joints_deg / _STEP_DEG), first, np.maximum(first, last))
        still = 0.5 * (self.low_deg + self.high_deg)
        # 0.01 is no binary fraction: rounded again, so that what is typed is what was meant.
        return np.where(first <= last, np.round(steps * _STEP_DEG, 2), still)


def measured_ranges(start: Start) -> Ranges:
    """Return the ranges that were measured, within the limits of the controller."""
    joints_deg = np.rad2deg(start.scene.stops.joints_rad)
    low, high = joints_deg.min(axis=0), joints_deg.max(axis=0)
    limits = joint_limits(start)
    if limits is None:
        return Ranges(low, high)
    low = np.clip(low, limits.low_deg, limits.high_deg)
    return Ranges(low, np.clip(high, low, limits.high_deg))


def joint_limits(start: Start) -> Ranges | None:
    """Return the limits of the controller; None where they are unknown."""
    limits = start.campaign.robot.joint_limits
    if limits is None:
        return None
    return Ranges(
        np.rad2deg([limit.lower_rad for limit in limits]), np.rad2deg([limit.upper_rad for limit in limits])
    )


def draw_configurations(
    start: Start, selected: Selection, ranges: Ranges, count: int, rng: np.random.Generator
) -> Places:
    """Draw configurations evenly within ranges.

    Parameters
    ----------
    start : Start
    selected : Selection
    ranges : Ranges
    count : int
    rng : numpy.random.Generator

    Returns
    -------
    Places
        Whole steps of 0.01 deg, evaluated with the extended model.
    """
    joints_deg = ranges.rounded(ranges.drawn(count, rng))
    return Places(joints_deg, _evaluated(selected, joints_deg, _in_time(start.scene.stops)))


def _evaluated(selected: Selection, joints_deg: FloatArray, stops: Stops) -> State:
    """Return the extended model at configurations (c, J) [deg], nests in turn, the rest as read last."""
    fit = selected.fit
    joints_rad = np.deg2rad(joints_deg)
    count = len(joints_rad)
    nests = np.unique(fit.blocks[0].targets.nest)
    asked = Stops(
        config=np.arange(count),
        joints_rad=joints_rad,
        # From which side the arm will come is not planned: 0, unknown, adds nothing to either cause.
        direction=None if stops.direction is None else np.zeros_like(joints_rad, dtype=np.int64),
        time_s=_last(stops.time_s, count),
        temperature_c=_last(stops.temperature_c, count),
        attachment=None if stops.attachment is None else np.full(count, stops.attachment[-1]),
        torque_n_mm=_torques(selected, joints_rad, stops),
    )
    return evaluate(fit.structure, fit.values, Targets(asked, nests[np.arange(count) % len(nests)]))


def _in_time(stops: Stops) -> Stops:
    """Return the stops as they were made, those without a time first; as they stand where no times are."""
    if stops.time_s is None:
        return stops
    return stops.taken(np.argsort(np.nan_to_num(stops.time_s, nan=-np.inf), kind="stable"))


def _last(column: FloatArray | None, count: int) -> FloatArray | None:
    """Return the last known value of a column, shape (count,); NaN where none is known."""
    if column is None:
        return None
    known = column[np.isfinite(column)]
    return np.full(count, known[-1] if known.size else np.nan)


def _torques(selected: Selection, joints_rad: FloatArray, stops: Stops) -> FloatArray | None:
    """Return what torque sensors would read: moments of mass and zeros of sensors fitted to what they did."""
    structure = selected.fit.structure
    if not structure.torques_measured or stops.torque_n_mm is None:
        return None
    there, here = (
        forward(nominal_values(structure.robot, joints), structure.base_rotation, structure.base_origin_mm)
        for joints in (joints_rad, stops.joints_rad)
    )
    measured = stops.torque_n_mm.T.reshape(-1)
    known = np.isfinite(measured)
    # Moments about parallel axes are seen together only; of all that give these torques, the smallest are
    # taken.
    moments = np.linalg.lstsq(_loads(here, structure.gravity_m_s2)[known], measured[known], rcond=1e-6)[0]
    return np.asarray((_loads(there, structure.gravity_m_s2) @ moments).reshape(-1, len(joints_rad)).T)


def _loads(chain: Chain, gravity_m_s2: FloatArray) -> FloatArray:
    """Torques per moment of each frame and per zero of each joint's sensor, shape (J n, 3 J)."""
    joints, n, _ = chain.z.shape
    loads = np.zeros((joints, n, 3 * joints))
    for joint in range(joints):
        loads[joint, :, 2 * joints + joint] = 1.0
        for frame in range(joint, joints):
            for component in range(2):
                loads[joint, :, 2 * frame + component] = moment_regressor(
                    chain, joint, frame, component, gravity_m_s2
                )
    # Moments [kg mm] and zeros [N mm] meet on equal terms where a moment is worth its weight.
    loads[:, :, 2 * joints :] *= max(float(np.linalg.norm(gravity_m_s2)), 1.0)
    return loads.reshape(joints * n, -1)


def filling(places: FloatArray, measured: FloatArray, count: int) -> list[int]:
    """Choose places one by one, each farthest from what was measured and chosen before.

    Parameters
    ----------
    places : ndarray, shape (c, k)
        What the dependence is on, e.g. an angle, at each place.
    measured : ndarray, shape (n, k)
    count : int

    Returns
    -------
    list of int
        Indices of places.

    References
    ----------
    M. E. Johnson, L. M. Moore, D. Ylvisaker, J. Statistical Planning and Inference 26, 1990, 131-148
    (maximin distance designs).
    """
    apart = np.full(len(places), np.inf)
    for row in measured:
        apart = np.minimum(apart, np.linalg.norm(places - row, axis=1))
    chosen: list[int] = []
    for _ in range(min(count, len(places))):
        chosen.append(int(np.argmax(apart)))
        apart = np.minimum(apart, np.linalg.norm(places - places[chosen[-1]], axis=1))
    return chosen


def moved_alone(start: Start, joint: int, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw configurations with one joint anywhere in its range, the others as measured.

    Parameters
    ----------
    start : Start
    joint : int
        0-based.
    count : int
    rng : numpy.random.Generator

    Returns
    -------
    ndarray, shape (count, J)
        [deg].
    """
    stops, ranges = start.scene.stops, measured_ranges(start)
    joints_deg = np.rad2deg(stops.joints_rad[rng.integers(len(stops), size=count)])
    joints_deg[:, joint] = ranges.drawn(count, rng)[:, joint]
    return ranges.rounded(joints_deg)


def one_period(start: Start, joint: int, order: float, count: int) -> FloatArray:
    """Return configurations that step one joint through a period, about a measured one.

    Parameters
    ----------
    start : Start
    joint : int
        0-based.
    order : float
        Periods per turn.
    count : int

    Returns
    -------
    ndarray, shape (count, J)
        [deg]; the measured configuration is the one nearest to the middle of the joint's range.
    """
    ranges = measured_ranges(start)
    angles = np.rad2deg(start.scene.stops.joints_rad)
    middle = 0.5 * (ranges.low_deg + ranges.high_deg)[joint]
    joints_deg = np.repeat(angles[[int(np.argmin(np.abs(angles[:, joint] - middle)))]], count, axis=0)
    joints_deg[:, joint] += 360.0 / order * ((np.arange(count) + 0.5) / count - 0.5)
    return ranges.rounded(joints_deg)
