"""The poses that a ballbar session still has before it, aimed by what a pre-calibration found.

Poses of the present placement come in a new order, on clear ways from where the arm stands; one to which no
clear way leads is left out. The last planned one stays the last: the arm is out of the way there while the
fixture is put elsewhere. Later placements keep their order and ways; aiming turns their joints by tenths of a
degree at most.
"""

from collections.abc import Collection

import numpy as np

from truepose.analysis.ballbar.assembly import Counting, Standing
from truepose.analysis.ballbar.early_forecasts import EarlyForeseen
from truepose.analysis.ballbar.forecasts import Foreseen
from truepose.domain.measurement.ballbar import BallbarPlan, PlannedPlacement, PlannedPose
from truepose.planning.ballbar.clear_ways.bodies import BallbarCell
from truepose.planning.ballbar.fixture import BaseFixture
from truepose.planning.ballbar.lengths.again import aimed_again, coded_or_kept


def next_poses(
    arm: BallbarCell,
    plan: BallbarPlan,
    counting: Counting,
    standing: Standing,
    exchanged: Collection[int],
    foreseen: Foreseen | EarlyForeseen,
) -> tuple[PlannedPose, ...]:
    """Return what is to be measured from now on, in order.

    Parameters
    ----------
    arm : BallbarCell
    plan : BallbarPlan
    counting : Counting
    standing : Standing
        Where the arm is, and at which placement.
    exchanged : collection of int
        Poses whose legs were confused: to be measured again.
    foreseen : Foreseen
    """
    found: list[PlannedPose] = []
    for placement in plan.placements:
        left = [pose for pose in placement.poses if _is_left(pose, counting, exchanged)]
        if placement.number == standing.placement:
            found += _here(arm, placement, left, standing, foreseen)
        elif placement.number > standing.placement:
            found += [coded_or_kept(arm, pose, foreseen.lengths_of(pose))[0] for pose in left]
    return tuple(found)


def _is_left(pose: PlannedPose, counting: Counting, exchanged: Collection[int]) -> bool:
    """Whether a pose is to be measured, all of it: its fixture must not move between its legs."""
    kept = {leg.leg for leg in counting.legs if leg.config == pose.config}
    return pose.config in exchanged or not set(pose.legs) <= kept


def _here(
    arm: BallbarCell,
    placement: PlannedPlacement,
    left: list[PlannedPose],
    standing: Standing,
    foreseen: Foreseen | EarlyForeseen,
) -> tuple[PlannedPose, ...]:
    if not left:
        return ()
    fixture = BaseFixture(placement.number, placement.frame, np.array(placement.cups_mm))
    parking = placement.poses[-1].config
    return aimed_again(arm, fixture, left, foreseen.lengths_of, standing.joints_rad, last=parking).poses
