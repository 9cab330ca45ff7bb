"""The robot's way through a ballbar campaign: set-ups and poses, aimed as after a pre-calibration.

The recorder knows the truth: it looks for the joints at which legs have the wanted lengths, or the ball is at
the wanted place, without noise. Whoever asks adds what a pre-calibrated model would miss them by.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.physics.effects import Conditions
from truepose_simulators.physics.effects.ports import NestNumbers
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.recording.ballbars.plan import BallbarPlan
from truepose_simulators.recording.plan import directions

_STOP_S = 60.0  # a person, a motion, an initialisation and six readings; or a cup to be clamped
TRIANGLE_S = 60.0  # to initialise and to measure the sides of a triangle
_TIME_SPREAD = 0.2
_DECIMALS_DEG = 5  # of joint angles in campaign files
_MOUNTING = 1.0  # the tool stays on


@dataclass(frozen=True, slots=True)
class Tour:
    """S stops in the order in which they are made."""

    placement: NestNumbers  # (S,)
    number: NestNumbers  # (S,) base point of a set-up, config of a pose
    is_setup: npt.NDArray[np.bool_]  # (S,)
    joints_deg: FloatArray  # (S, J) with the decimals of the file
    direction: FloatArray  # (S, J)
    start_s: FloatArray  # (S,)
    end_s: FloatArray  # (S,)

    def __len__(self) -> int:
        return len(self.end_s)

    def at_joints(self, joints_deg: FloatArray, approach: str) -> "Tour":
        """Return the tour with other joints, shape (S, J)."""
        joints = joints_deg.round(_DECIMALS_DEG)
        return replace(self, joints_deg=joints, direction=directions(joints, approach))

    def conditions(self, cell: Cell, stop: NestNumbers, time_s: FloatArray) -> Conditions:
        """Circumstances at stops (n,) and times (n,)."""
        return cell.conditions(
            np.radians(self.joints_deg[stop]), self.direction[stop], time_s, np.full(len(stop), _MOUNTING)
        )


@dataclass(frozen=True, slots=True)
class PlannedLegs:
    """n legs in the order in which they are connected."""

    stop: NestNumbers  # (n,) index in the tour
    base_point: NestNumbers  # (n,)
    tool_point: NestNumbers  # (n,)
    aimed_mm: FloatArray  # (n,)
    time_s: FloatArray  # (n,)


def plan_tour(plan: BallbarPlan, approach: str, rng: np.random.Generator) -> Tour:
    """Order the stops of a plan and give them times."""
    rows: list[tuple[int, int, bool]] = []
    joints: list[Sequence[float]] = []
    pauses: list[float] = []
    for placement in plan.placements:
        stops = [
            *((setup.base_point, True, setup.joints_deg) for setup in placement.setups),
            *((pose.config, False, pose.joints_deg) for pose in placement.poses),
        ]
        rows += [(placement.number, number, is_setup) for number, is_setup, _ in stops]
        joints += [angles for _, _, angles in stops]
        # The triangle is measured between the last set-up and the first pose.
        pauses += [TRIANGLE_S if k == len(placement.setups) else 0.0 for k in range(len(stops))]
    durations = _STOP_S * (1.0 + _TIME_SPREAD * rng.uniform(-1.0, 1.0, len(rows)))
    end_s = (TRIANGLE_S + np.cumsum(durations + np.array(pauses))).round(1)
    stated = np.array(joints, dtype=np.float64)
    joints_deg = stated.round(_DECIMALS_DEG)
    return Tour(
        placement=np.array([row[0] for row in rows]),
        number=np.array([row[1] for row in rows]),
        is_setup=np.array([row[2] for row in rows]),
        joints_deg=joints_deg,
        direction=directions(joints_deg, approach),
        start_s=end_s - durations,
        end_s=end_s,
    )


def plan_legs(plan: BallbarPlan, tour: Tour, nominal_mm: float) -> PlannedLegs:
    """List all legs with the times at which they are read, evenly over their stop."""
    poses = {pose.config: pose for placement in plan.placements for pose in placement.poses}
    rows: list[tuple[int, int, int, float, float]] = []
    for stop in np.flatnonzero(~tour.is_setup):
        pose = poses[int(tour.number[stop])]
        aimed = pose.aimed_mm or (nominal_mm,) * len(pose.legs)
        times = np.linspace(tour.start_s[stop], tour.end_s[stop], len(pose.legs) + 1)[1:]
        for (base, tool), length_mm, time_s in zip(pose.legs, aimed, times, strict=True):
            rows.append((int(stop), base, tool, length_mm, time_s))
    table = np.array(rows, dtype=np.float64).reshape(-1, 5)
    stop_, base_, tool_ = (table[:, k].astype(int) for k in range(3))
    return PlannedLegs(stop_, base_, tool_, table[:, 3], table[:, 4].round(1))


BoolArray: TypeAlias = npt.NDArray[np.bool_]
Misses: TypeAlias = Callable[[FloatArray], FloatArray]  # joints of P stops [deg], (P, J) -> (n,) [mm]

_STEP_DEG = 0.01  # of the numerical derivative: lengths bend by less than 1e-4 mm over it
_STEPS = 6
_LARGEST_STEP_DEG = 5.0  # Gauss-Newton near a singular pose would leave its branch
_LEAST_SINGULAR_SHARE = 1e-4
_CLOSE_MM = 0.02
_CLOSE_IN_THE_MEAN_MM = 0.2  # more than six legs cannot all have their lengths


def aim_legs(
    cell: Cell, tour: Tour, legs: PlannedLegs, cups_mm: FloatArray, wanted_mm: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Find joints at which legs have the lengths `wanted_mm` (n,), from cups `cups_mm` (n, 3) [world].

    Returns
    -------
    ndarray, shape (S, J)
        Joints of all stops of the tour [deg]; directions of approach count as they were planned.
    ndarray of bool, shape (n,)
        Legs whose pose came near; the others belong to poses that the arm cannot correct.
    """
    stops, row = np.unique(legs.stop, return_inverse=True)

    def misses(joints_deg: FloatArray) -> FloatArray:
        nests = _nests_mm(cell, tour, stops, joints_deg)[row, legs.tool_point - 1]
        missed: FloatArray = np.linalg.norm(nests - cups_mm, axis=1) - wanted_mm
        return missed

    joints = tour.joints_deg.copy()
    joints[stops] = _corrected(cell, misses, row, tour.joints_deg[stops])
    worst = np.zeros(len(stops))
    np.maximum.at(worst, row, np.abs(misses(joints[stops])))
    n_joints = joints.shape[1]
    allowed = np.where(np.bincount(row) > n_joints, _CLOSE_IN_THE_MEAN_MM, _CLOSE_MM)
    return joints, (worst < allowed)[row]


def aim_balls(cell: Cell, tour: Tour, stops: NestNumbers, wanted_mm: FloatArray) -> FloatArray:
    """Find joints at which tool nest 1 is at `wanted_mm` (k, 3) [world] at `stops` (k,); shape (S, J)."""

    def misses(joints_deg: FloatArray) -> FloatArray:
        missed: FloatArray = (_nests_mm(cell, tour, stops, joints_deg)[:, 0] - wanted_mm).ravel()
        return missed

    joints = tour.joints_deg.copy()
    row = np.repeat(np.arange(len(stops)), 3)
    joints[stops] = _corrected(cell, misses, row, tour.joints_deg[stops])
    return joints


def _corrected(cell: Cell, misses: Misses, row: NestNumbers, joints_deg: FloatArray) -> FloatArray:
    """Make the misses as small as they get, each of them of the stop in `row`; shape (P, J)."""
    lower, upper = np.degrees(cell.plant.arm.limits_rad.T)
    joints = joints_deg.copy()
    for _ in range(_STEPS):
        missed, slopes = misses(joints), _slopes(misses, joints)
        for stop in range(len(joints)):
            mine = row == stop
            # Gauss-Newton, one stop at a time. Fewer legs than joints: the least motion; more: least squares.
            step = np.linalg.lstsq(slopes[mine], missed[mine], rcond=_LEAST_SINGULAR_SHARE)[0]
            joints[stop] -= np.clip(step, -_LARGEST_STEP_DEG, _LARGEST_STEP_DEG)
        joints = np.clip(joints, lower, upper)
    return joints


def _slopes(misses: Misses, joints_deg: FloatArray) -> FloatArray:
    """Return how misses change with each joint of their stop [mm/deg], shape (n, J)."""
    steps = _STEP_DEG * np.eye(joints_deg.shape[1])
    return np.stack(
        [(misses(joints_deg + step) - misses(joints_deg - step)) / (2.0 * _STEP_DEG) for step in steps],
        axis=1,
    )


def _nests_mm(cell: Cell, tour: Tour, stops: NestNumbers, joints_deg: FloatArray) -> FloatArray:
    """Return the true nests with the stops at other joints, shape (P, nests, 3)."""
    joints = tour.joints_deg.copy()
    joints[stops] = joints_deg
    return cell.true_positions(replace(tour, joints_deg=joints).conditions(cell, stops, tour.end_s[stops]))
