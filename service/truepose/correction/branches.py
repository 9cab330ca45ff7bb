"""The branch to reach a goal in where nobody asked for one: that nearest to where the robot was measured."""

from typing import Final, TypeAlias

import numpy as np

from truepose.correction.goals import Goals
from truepose.correction.inverse import Attained, replaced
from truepose.correction.limits import beyond, turned_within
from truepose.correction.starts import NominalArm, attain_from_branch
from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.robot import JointRange
from truepose.identification.model.estimates import Estimate
from truepose.kinematics.inverse_search import BRANCHES

Ranges: TypeAlias = tuple[JointRange, ...] | None  # of the joints; None: nobody said
_OUTSIDE: Final = 1e2  # outweighs any distance from the middle [rad]
_MISSED: Final = 1e4
_BEYOND_LIMIT: Final = 1e6


def attain_any_branch(estimate: Estimate, goals: Goals, measured: Ranges) -> Attained:
    """Search the branches one after the other, first those that come nearest to where it was measured."""
    cost = _costs(estimate, goals, measured)
    order = np.argsort(cost, axis=1)
    exists = np.isfinite(np.take_along_axis(cost, order, axis=1))
    found = attain_from_branch(estimate, goals, order[:, 0])
    for place in range(1, BRANCHES):
        left = np.flatnonzero(exists[:, place] & ~_usable(estimate, found))
        if not len(left):
            break  # what exists comes first: behind this place there is nothing to try either
        again = attain_from_branch(estimate, goals.taken(left), order[left, place])
        better = np.flatnonzero(_usable(estimate, again))
        found = replaced(found, left[better], again.taken(better))
    return found


def _costs(estimate: Estimate, goals: Goals, measured: Ranges) -> FloatArray:
    """Return how far the nominal answers are from where it was measured, shape (n, 8) [rad].

    Within the measured ranges the distance from their middle counts, beyond them mostly what is
    beyond. Behind these come branches that the nominal arm just misses, where it reaches another one, then
    answers beyond a limit of the controller; where it reaches none, all are infinite.
    """
    robot, arm = estimate.structure.robot, NominalArm(estimate)
    flange = arm.flange(goals)
    exists = np.asarray(np.isfinite(arm.branches(flange, reach_out=False)[..., 0]))
    turned, within = turned_within(robot.joint_limits, arm.branches(flange).reshape(-1, robot.n_joints))
    away = np.linalg.norm(turned - _middle(measured, robot.n_joints), axis=1)
    away += _OUTSIDE * np.nan_to_num(beyond(measured, turned)).sum(axis=1) + np.where(
        within, 0.0, _BEYOND_LIMIT
    )
    cost = np.nan_to_num(away, nan=np.inf).reshape(-1, BRANCHES) + np.where(exists, 0.0, _MISSED)
    reached = np.asarray(exists.any(axis=1))
    return np.where(reached[:, None], cost, np.inf)


def _middle(ranges: Ranges, joints: int) -> FloatArray:
    if ranges is None:
        return np.zeros(joints)
    return np.array([(limit.lower_rad + limit.upper_rad) / 2 for limit in ranges])


def _usable(estimate: Estimate, found: Attained) -> BoolArray:
    _, within = turned_within(estimate.structure.robot.joint_limits, found.joints_rad)
    return np.asarray(found.arrived & within)
