"""In which poses of a plan an exchange of two legs is hardly seen when it is made.

All legs of a planned pose are nominally of one length. What tells them apart is the errors of the arm, and
these show only as far as the poses before have told of them: that follows from the plan alone.
"""

from itertools import combinations
from math import erfc, sqrt
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.measurement.ballbar import BallbarPlan, PlannedPose
from truepose.domain.measurement.linear_lengths import TOLD_APART, ArmKind, StopLengths
from truepose.planning.ballbar.lengths.beforehand import Beforehand

_MOSTLY: Final = 0.5  # share of exchanges that must show in a pose that is not named


def unseen_swaps(beforehand: Beforehand, plan: BallbarPlan, kit: BallbarKit) -> tuple[int, ...]:
    """Return the poses before the pre-calibration in which most exchanges do not show at once."""
    kinds = beforehand.kinds()
    seen = sum(kind.share * _shares_seen(beforehand, plan, kit, kind) for kind in kinds)
    poses = _before_precalibration(plan)
    return tuple(
        pose.config for pose, share in zip(poses, np.atleast_1d(seen), strict=True) if share < _MOSTLY
    )


def _before_precalibration(plan: BallbarPlan) -> list[PlannedPose]:
    poses = [pose for placement in plan.placements for pose in placement.poses]
    return poses[: plan.precalibrate_after]


def _shares_seen(beforehand: Beforehand, plan: BallbarPlan, kit: BallbarKit, kind: ArmKind) -> FloatArray:
    """Return the share of exchanges that show, of each pose in order."""
    noise = kit.reading_u_mm**2 + kit.zero_u_mm**2
    known, found = kind.covariance, []
    placement = 0
    for pose in _before_precalibration(plan):
        if pose.placement != placement:
            placement = pose.placement
            sides = beforehand.sides(placement)
            known = _after(known, sides.slope, noise * np.eye(len(sides.pairs)))
        stop = beforehand.poses(placement, np.array([pose.joints_rad]))[0]
        rows = [stop.pairs.index(leg) for leg in pose.legs]
        slope, scatter = stop.slope[rows], _scatter(stop, rows, kind, noise)
        found.append(_share_seen(slope @ known @ slope.T + scatter, slope @ kind.covariance @ slope.T))
        known = _after(known, slope, scatter)
    return np.array(found)


def _scatter(stop: StopLengths, rows: list[int], kind: ArmKind, noise_mm2: float) -> FloatArray:
    motion = stop.motion[rows]
    return np.asarray(kind.motion_mm**2 * motion @ motion.T + noise_mm2 * np.eye(len(rows)))


def _share_seen(foreseen: FloatArray, spread: FloatArray) -> float:
    """Return how often two lengths differ by enough, from how sure they are and how far they spread."""
    shares = []
    for a, b in combinations(range(len(foreseen)), 2):
        unsure, differ = (sqrt(c[a, a] + c[b, b] - 2.0 * c[a, b]) for c in (foreseen, spread))
        shares.append(erfc(TOLD_APART * unsure / differ / sqrt(2.0)) if differ > 0.0 else 0.0)
    return float(np.mean(shares)) if shares else 1.0


def _after(known: FloatArray, slope: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the covariance of what is unknown after readings."""
    shared = known @ slope.T
    return np.asarray(known - shared @ np.linalg.solve(slope @ shared + noise, shared.T))
