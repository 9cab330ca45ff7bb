"""The poses that a ballbar session still has before it, aimed by what a pre-calibration found.

Poses of the present placement come in a new order: nearest first, on clear ways from where the arm stands.
The last planned one stays the last: the arm is out of the way there while the fixture is put elsewhere.
Later placements keep their order and ways; aiming turns their joints by tenths of a degree at most.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from service.analysis.ballbar_assembly import Counting
from service.analysis.forecasts import Foreseen
from service.domain.arrays import FloatArray
from service.domain.artefacts import BallbarKit
from service.domain.ballbar import BallbarPlan, PlannedPlacement, PlannedPose
from service.domain.cell import Cell
from service.domain.robot import JointRange
from service.planning.ballbar.aiming import aimed, aimed_pose
from service.planning.ballbar.bodies import BallbarCell
from service.planning.ballbar.fixture import BaseFixture
from service.planning.ballbar.motions import Stop, Surroundings
from service.planning.ballbar.plan import ballbar_cell
from service.planning.ballbar.ways import way
from service.planning.errors import AimError, NoWayError


def next_poses(
    cell: Cell, plan: BallbarPlan, counting: Counting, exchanged: Sequence[int], foreseen: Foreseen
) -> tuple[PlannedPose, ...]:
    """Return what is to be measured from now on, in order.

    Parameters
    ----------
    cell : Cell
    plan : BallbarPlan
    counting : Counting
    exchanged : sequence of int
        Poses whose legs were confused: to be measured again.
    foreseen : Foreseen
    """
    last = max(counting.legs, key=lambda kept: kept.length.initialisation)
    arm = ballbar_cell(cell)
    ranges = cell.limits.joints or cell.robot.joint_limits
    found: list[PlannedPose] = []
    for placement in plan.placements:
        if placement.number < last.placement:
            continue
        left = [pose for pose in placement.poses if _is_left(pose, counting, exchanged)]
        targets = [_aimed(pose, cell, foreseen, ranges) for pose in left]
        if placement.number == last.placement:
            targets = _ordered(arm, placement, targets, np.array(last.arrival.commanded_rad))
        found += targets
    return tuple(found)


def _is_left(pose: PlannedPose, counting: Counting, exchanged: Sequence[int]) -> bool:
    """Whether a pose is to be measured, all of it: its fixture must not move between its legs."""
    kept = {leg.leg for leg in counting.legs if leg.config == pose.config}
    return pose.config in exchanged or not set(pose.legs) <= kept


def _aimed(
    pose: PlannedPose, cell: Cell, foreseen: Foreseen, ranges: tuple[JointRange, ...] | None
) -> PlannedPose:
    """Return the pose with coded lengths, else with nominal ones, else as it was planned."""
    nominal_mm = (cell.ballbar or BallbarKit()).base_bars.nominal_mm
    lengths = foreseen.lengths_of(pose)
    try:
        return aimed_pose(pose, lengths, nominal_mm, ranges)
    except AimError:
        pass
    try:
        joints = aimed(lengths, pose.joints_rad, np.full(len(pose.legs), nominal_mm), ranges)
    except AimError:
        return pose
    return replace(pose, joints_rad=tuple(float(angle) for angle in joints), aimed_mm=None)


def _ordered(
    arm: BallbarCell, placement: PlannedPlacement, poses: list[PlannedPose], here: FloatArray
) -> list[PlannedPose]:
    """Return the poses, nearest first, each with its way; those to which no way was found come last."""
    around = Surroundings(arm, BaseFixture(placement.number, placement.frame, np.array(placement.cups_mm)))
    rng = np.random.default_rng(placement.number)
    parking = placement.poses[-1].config
    order: list[PlannedPose] = []
    left = list(poses)
    while left:
        reached = _next(around, here, left, parking, rng)
        if reached is None:
            return order + left
        order.append(reached)
        left = [pose for pose in left if pose.config != reached.config]
        here = np.array(reached.joints_rad)
    return order


def _next(
    around: Surroundings,
    here: FloatArray,
    left: Sequence[PlannedPose],
    parking: int,
    rng: np.random.Generator,
) -> PlannedPose | None:
    def distance(pose: PlannedPose) -> tuple[bool, float]:
        return pose.config == parking, float(np.max(np.abs(np.array(pose.joints_rad) - here)))

    for pose in sorted(left, key=distance):
        try:
            via = way(around, Stop(here), Stop(np.array(pose.joints_rad)), rng)
        except NoWayError:
            continue
        return replace(pose, via_rad=via)
    return None
