"""Where a search for joint angles begins: the closed-form answer of the nominal arm, on the identified base.

Where the search from there fails, the pose is shifted by what was left of the error, and the arm asked
again: unlike a step of Newton's, that turns joint 4 by whatever a singular wrist takes (thesis of A.
Nubiola, 2014, section 1.5, pose shift). Newton's method may end beyond a singularity, in another branch than
the one asked for: the arm is then asked for its twin there. What stays in another branch is no answer.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Final, TypeAlias

import numpy as np

from truepose.correction.goals import Goals
from truepose.correction.inverse import Attained, attain, merged
from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.campaign import Stops
from truepose.identification.model.estimates import Estimate
from truepose.identification.model.evaluation import Targets, evaluate, nest_centres
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import poses_of
from truepose.kinematics.inverse import all_branches, branch_of, has_closed_form, one_branch

_HOPELESS_MM: Final = 50.0  # several times what any arm is off: the goal is out of reach
_SHIFTS: Final = 2  # each leaves a few per cent of the error
_OWN: Final = (0,)  # exclusive or with the branch
_BESIDE: Final = (0, 1, 2, 3, 4)  # itself, other wrist, other elbow, both, other side
_Kept: TypeAlias = Callable[[IntArray, Attained], Attained]  # what of an answer to some rows counts


class NominalArm:
    """The arm of the controller, standing where the identified one stands."""

    def __init__(self, estimate: Estimate) -> None:
        self.estimate = estimate
        robot = estimate.structure.robot
        at_zero = Targets(
            Stops(np.zeros(1, dtype=np.int64), np.zeros((1, robot.n_joints))), np.ones(1, dtype=np.int64)
        )
        state = evaluate(estimate.structure, estimate.values, at_zero)
        self._rotation, self._origin = state.chain.base_rotation[0], state.chain.base_origin[0]
        self.nests_mm = nest_centres(estimate.structure, state.moved)  # (K, 3) in the last frame

    @property
    def has_branches(self) -> bool:
        """Whether numbers of branches mean something."""
        return has_closed_form(self.estimate.structure.robot)

    def flange(self, goals: Goals) -> FloatArray:
        """Return where goals put the last frame, in the robot's base, shape (n, 4, 4)."""
        origin = goals.position_mm - np.einsum("nij,nj->ni", goals.rotation, self.nests_mm[goals.nest - 1])
        return self._in_base(goals.rotation, origin)

    def attained(self, goals: Goals, joints_rad: FloatArray) -> FloatArray:
        """Return where the identified arm has its last frame, in the robot's base, shape (n, 4, 4)."""
        targets = Targets(goals.at(joints_rad), np.ones(len(goals), dtype=np.int64))
        chain = evaluate(self.estimate.structure, self.estimate.values, targets).chain
        return self._in_base(chain.end_rotation, chain.end_origin)

    def one_branch(self, flange: FloatArray, branch: IntArray) -> FloatArray:
        """Return the joint angles of one branch each, shape (n, J)."""
        robot = self.estimate.structure.robot
        if self.has_branches:
            return one_branch(robot, flange, branch)
        return np.asarray(self.branches(flange)[np.arange(len(flange)), branch])

    def branches(self, flange: FloatArray, *, reach_out: bool = True) -> FloatArray:
        """Return the joint angles of every branch, shape (n, 8, J)."""
        return all_branches(self.estimate.structure.robot, flange, reach_out=reach_out)

    def kept_to(self, branch: IntArray, found: Attained) -> Attained:
        """Return what was found, in another branch than these, shape (n,), as gone astray."""
        if not self.has_branches:
            return found
        robot = self.estimate.structure.robot
        return found.without(branch_of(robot, np.nan_to_num(found.joints_rad)) != branch)

    def commanded(self, joints_rad: FloatArray) -> FloatArray:
        """Return where the controller believes its last frame to be, in the robot's base, shape (n, 4, 4)."""
        chain = nominal_chain(self.estimate.structure.robot, joints_rad)
        return poses_of(chain.end_rotation, chain.end_origin)

    def in_world(self, goals: Goals) -> Goals:
        """Return goals that are meant in the robot's base."""
        position = goals.position_mm @ self._rotation.T + self._origin
        return replace(goals, position_mm=position, rotation=self._rotation @ goals.rotation)

    def _in_base(self, rotation: FloatArray, origin_mm: FloatArray) -> FloatArray:
        return poses_of(self._rotation.T @ rotation, (origin_mm - self._origin) @ self._rotation)


def attain_branch(estimate: Estimate, goals: Goals, branch: IntArray) -> Attained:
    """Search goals in one branch each of the nominal arm, shape (n,), numbered as in `kinematics.inverse`."""
    arm = NominalArm(estimate)
    return _attain_from(arm, goals, branch, _OWN, lambda rows, found: arm.kept_to(branch[rows], found))


def attain_from_branch(estimate: Estimate, goals: Goals, branch: IntArray) -> Attained:
    """Search goals from one branch each, shape (n,), and from those that meet it, wherever that ends."""
    arm = NominalArm(estimate)
    return _attain_from(arm, goals, branch, _BESIDE if arm.has_branches else _OWN, lambda _, found: found)


def _attain_from(
    arm: NominalArm, goals: Goals, branch: IntArray, besides: tuple[int, ...], kept: _Kept
) -> Attained:
    wanted = arm.flange(goals)
    found = kept(np.arange(len(goals)), attain(arm.estimate, goals, arm.one_branch(wanted, branch)))
    for _ in range(_SHIFTS):
        left = np.flatnonzero(~found.arrived & (found.error_mm < _HOPELESS_MM))
        if not len(left):
            break
        rows = goals.taken(left)
        again = _shifted(arm, rows, wanted[left], found.joints_rad[left])
        tried = _attain_one_of(arm, rows, again, branch[left] ^ np.array(besides)[:, None])
        found = merged(found, left, kept(left, tried))
    return found


def _attain_one_of(arm: NominalArm, goals: Goals, flange: FloatArray, branches: IntArray) -> Attained:
    """Search n goals in several branches each, (k, n); return the first that arrives, or comes nearest."""
    places = np.tile(np.arange(len(goals)), len(branches))
    found = attain(arm.estimate, goals.taken(places), arm.one_branch(flange[places], branches.ravel()))
    distance = np.where(found.arrived, 0.0, found.distance).reshape(branches.shape)
    return found.taken(np.argmin(distance, axis=0) * len(goals) + np.arange(len(goals)))


def _shifted(arm: NominalArm, goals: Goals, wanted: FloatArray, joints_rad: FloatArray) -> FloatArray:
    """Return what to ask of the nominal arm where it was at some joints, so that the error is made up for."""
    left = wanted @ np.linalg.inv(arm.attained(goals, joints_rad))
    return np.asarray(left @ arm.commanded(joints_rad))
