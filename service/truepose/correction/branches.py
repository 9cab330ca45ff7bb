"""Where a search for joint angles begins, and the branch of the arm that it is to end in.

It begins at the closed-form answer of the nominal arm, on the identified base. Where the search from there
fails, the pose is shifted by what was left of the error, and the arm asked again: unlike a step of Newton's,
that turns joint 4 by whatever a singular wrist takes (thesis of A. Nubiola, 2014, section 1.5, pose shift).
Newton's method may end beyond a singularity, in another branch than the one asked for: the arm is then asked
for its twin there. What stays in another branch is no answer.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Final, TypeAlias

import numpy as np

from truepose.correction.inverse import SearchEnd, attain, nearer_of, with_rows_replaced
from truepose.correction.target_poses import Goals, beyond, turned_within
from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.domain.robot import JointRange
from truepose.identification.model.estimates import Estimate
from truepose.identification.model.evaluation import Targets, evaluate, nest_centres
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import poses_of
from truepose.kinematics.inverse import BRANCHES, all_branches, branch_of, has_closed_form, one_branch

_HOPELESS_MM: Final = 50.0  # several times what any arm is off: the goal is out of reach
_SHIFTS: Final = 2  # each leaves a few per cent of the error
_OWN: Final = (0,)  # exclusive or with the branch
_BESIDE: Final = (0, 1, 2, 3, 4)  # itself, other wrist, other elbow, both, other side
_Kept: TypeAlias = Callable[[IntArray, SearchEnd], SearchEnd]  # what of an answer to some rows counts


class NominalArm:
    """The arm of the controller, standing where the identified one stands.

    Parameters
    ----------
    estimate : Estimate
        With one nest at least.
    """

    def __init__(self, estimate: Estimate) -> None:
        self.estimate = estimate
        robot = estimate.structure.robot
        # Where the base stands follows from no joint angle; at zero there is always an arm.
        at_zero = Targets(
            Stops(np.zeros(1, dtype=np.int64), np.zeros((1, robot.n_joints))), np.ones(1, dtype=np.int64)
        )
        state = evaluate(estimate.structure, estimate.values, at_zero)
        # A closed form answers in the robot's base, and only the identified base says where in the world that
        # stands.
        self._rotation, self._origin = state.chain.base_rotation[0], state.chain.base_origin[0]
        self.nests_mm = nest_centres(estimate.structure, state.moved)  # (K, 3) in the flange frame

    @property
    def has_branches(self) -> bool:
        """Whether numbers of branches mean something."""
        return has_closed_form(self.estimate.structure.robot)

    def flange(self, goals: Goals) -> FloatArray:
        """Return where goals put the flange frame, in the robot's base.

        Parameters
        ----------
        goals : Goals
            n of them, in the world, of nests of the estimate (numbered from 1).

        Returns
        -------
        ndarray, shape (n, 4, 4)
            [mm]
        """
        origin = goals.position_mm - np.einsum("nij,nj->ni", goals.rotation, self.nests_mm[goals.nest - 1])
        return self._in_base(goals.rotation, origin)

    def attained(self, goals: Goals, joints_rad: FloatArray) -> FloatArray:
        """Return where the identified arm has its flange frame, in the robot's base.

        Parameters
        ----------
        goals : Goals
            n of them: direction, time and temperature are theirs.
        joints_rad : ndarray, shape (n, J)

        Returns
        -------
        ndarray, shape (n, 4, 4)
            [mm]
        """
        targets = Targets(goals.at(joints_rad), np.ones(len(goals), dtype=np.int64))
        chain = evaluate(self.estimate.structure, self.estimate.values, targets).chain
        return self._in_base(chain.end_rotation, chain.end_origin)

    def one_branch(self, flange: FloatArray, branch: IntArray) -> FloatArray:
        """Return the joint angles of one branch each, the arm stretched towards what it does not reach.

        Parameters
        ----------
        flange : ndarray, shape (n, 4, 4)
            In the robot's base [mm].
        branch : ndarray of int, shape (n,)
            Of an arm without numbered branches, the place among the answers of the search.

        Returns
        -------
        ndarray, shape (n, J)
            [rad]
        """
        robot = self.estimate.structure.robot
        if self.has_branches:
            return one_branch(robot, flange, branch)
        return np.asarray(self.branches(flange)[np.arange(len(flange)), branch])

    def branches(self, flange: FloatArray, *, reach_out: bool = True) -> FloatArray:
        """Return the joint angles of every branch.

        Parameters
        ----------
        flange : ndarray, shape (n, 4, 4)
            In the robot's base [mm].
        reach_out : bool, optional
            Whether the arm is stretched towards what it does not reach; else NaN there.

        Returns
        -------
        ndarray, shape (n, 8, J)
            [rad]
        """
        return all_branches(self.estimate.structure.robot, flange, reach_out=reach_out)

    def kept_to(self, branch: IntArray, found: SearchEnd) -> SearchEnd:
        """Return what was found, in another branch than these as gone astray.

        Parameters
        ----------
        branch : ndarray of int, shape (n,)
        found : SearchEnd
            n rows.
        """
        if not self.has_branches:
            return found
        robot = self.estimate.structure.robot
        # NaN joints are no answer either way; zeros in their place only spare the comparison.
        return found.without(branch_of(robot, np.nan_to_num(found.joints_rad)) != branch)

    def commanded(self, joints_rad: FloatArray) -> FloatArray:
        """Return where the controller believes its flange frame to be, in the robot's base.

        Parameters
        ----------
        joints_rad : ndarray, shape (n, J)

        Returns
        -------
        ndarray, shape (n, 4, 4)
            [mm]
        """
        chain = nominal_chain(self.estimate.structure.robot, joints_rad)
        return poses_of(chain.end_rotation, chain.end_origin)

    def in_world(self, goals: Goals) -> Goals:
        """Return goals that are meant in the robot's base, told in the world: R p + o.

        Parameters
        ----------
        goals : Goals
            n of them. R and o are of the identified base.
        """
        position = goals.position_mm @ self._rotation.T + self._origin
        return replace(goals, position_mm=position, rotation=self._rotation @ goals.rotation)

    def _in_base(self, rotation: FloatArray, origin_mm: FloatArray) -> FloatArray:
        return poses_of(self._rotation.T @ rotation, (origin_mm - self._origin) @ self._rotation)


def attain_branch(estimate: Estimate, goals: Goals, branch: IntArray) -> SearchEnd:
    """Search goals in one branch each of the nominal arm; what ends in another one is gone astray.

    Parameters
    ----------
    estimate : Estimate
    goals : Goals
        n of them.
    branch : ndarray of int, shape (n,)
        Numbered as in `kinematics.inverse`, of an arm that has such numbers.

    Returns
    -------
    SearchEnd
        n rows.
    """
    arm = NominalArm(estimate)
    return _attain_from(arm, goals, branch, _OWN, lambda rows, found: arm.kept_to(branch[rows], found))


def attain_from_branch(estimate: Estimate, goals: Goals, branch: IntArray) -> SearchEnd:
    """Search goals from one branch each, and from those that meet it, wherever that ends.

    Parameters and result as of `attain_branch`; of an arm without numbered branches a branch is the place
    among the answers of the search.
    """
    arm = NominalArm(estimate)
    return _attain_from(arm, goals, branch, _BESIDE if arm.has_branches else _OWN, lambda _, found: found)


def _attain_from(
    arm: NominalArm, goals: Goals, branch: IntArray, besides: tuple[int, ...], kept: _Kept
) -> SearchEnd:
    """Search from the closed-form answers, and from those of shifted poses where that did not arrive.

    Parameters
    ----------
    arm : NominalArm
    goals : Goals
        n of them.
    branch : ndarray of int, shape (n,)
    besides : tuple of int
        Exclusive or with the branch: where shifted poses are searched from.
    kept : callable
        What of an answer to some rows (indices, SearchEnd) counts.
    """
    wanted = arm.flange(goals)
    found = kept(np.arange(len(goals)), attain(arm.estimate, goals, arm.one_branch(wanted, branch)))
    for _ in range(_SHIFTS):
        # A goal out of reach stays so whatever the pose is shifted by: it costs no further search.
        left = np.flatnonzero(~found.arrived & (found.error_mm < _HOPELESS_MM))
        if not len(left):
            break
        rows = goals.taken(left)
        again = _shifted(arm, rows, wanted[left], found.joints_rad[left])
        # Beside a singularity the answer may lie in the branch that meets this one there: elbow, wrist or
        # side turned over.
        tried = _attain_one_of(arm, rows, again, branch[left] ^ np.array(besides)[:, None])
        found = nearer_of(found, left, kept(left, tried))
    return found


def _attain_one_of(arm: NominalArm, goals: Goals, flange: FloatArray, branches: IntArray) -> SearchEnd:
    """Search n goals in several branches each; return the first that arrives, or comes nearest.

    Parameters
    ----------
    arm : NominalArm
    goals : Goals
        n of them.
    flange : ndarray, shape (n, 4, 4)
        To begin from, in the robot's base [mm].
    branches : ndarray of int, shape (k, n)
    """
    places = np.tile(np.arange(len(goals)), len(branches))
    found = attain(arm.estimate, goals.taken(places), arm.one_branch(flange[places], branches.ravel()))
    distance = np.where(found.arrived, 0.0, found.distance).reshape(branches.shape)
    return found.taken(np.argmin(distance, axis=0) * len(goals) + np.arange(len(goals)))


def _shifted(arm: NominalArm, goals: Goals, wanted: FloatArray, joints_rad: FloatArray) -> FloatArray:
    """Return what to ask of the nominal arm where it was at some joints, so that the error is made up for.

    With W the wanted, A the attained and N the commanded pose: W A^-1 N, the pose shift of the thesis
    (section 1.5), shape (n, 4, 4).
    """
    left = wanted @ np.linalg.inv(arm.attained(goals, joints_rad))
    # Of where the controller itself believes to be: a second shift starts where the first has led.
    return np.asarray(left @ arm.commanded(joints_rad))


Ranges: TypeAlias = tuple[JointRange, ...] | None  # of the joints; None: nobody said
_OUTSIDE: Final = 1e2  # outweighs any distance from the middle [rad]
_MISSED: Final = 1e4
_BEYOND_LIMIT: Final = 1e6


def attain_any_branch(estimate: Estimate, goals: Goals, measured: Ranges) -> SearchEnd:
    """Search the branches one after the other, first those that come nearest to where it was measured.

    Parameters
    ----------
    estimate : Estimate
    goals : Goals
        n of them.
    measured : tuple of JointRange, or None
        Of the joints, in which the model was measured; None: nobody said, and the middle of all is 0.

    Returns
    -------
    SearchEnd
        The first answer that arrives within the controller's limits; where none does, that of the first
        branch.
    """
    cost = _costs(estimate, goals, measured)
    order = np.argsort(cost, axis=1)
    exists = np.isfinite(np.take_along_axis(cost, order, axis=1))
    # All rows in their best branch first: for nearly all of them that is the end of it.
    found = attain_from_branch(estimate, goals, order[:, 0])
    for place in range(1, BRANCHES):
        left = np.flatnonzero(exists[:, place] & ~_usable(estimate, found))
        if not len(left):
            break  # what exists comes first: behind this place there is nothing to try either
        again = attain_from_branch(estimate, goals.taken(left), order[left, place])
        better = np.flatnonzero(_usable(estimate, again))
        found = with_rows_replaced(found, left[better], again.taken(better))
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
    # The identified arm may reach by a hair what the nominal one just misses, hence such branches are tried
    # at all, but behind those that exist.
    cost = np.nan_to_num(away, nan=np.inf).reshape(-1, BRANCHES) + np.where(exists, 0.0, _MISSED)
    reached = np.asarray(exists.any(axis=1))
    return np.where(reached[:, None], cost, np.inf)


def _middle(ranges: Ranges, joints: int) -> FloatArray:
    """Return the middle of ranges, zeros where nobody said, shape (J,) [rad]."""
    if ranges is None:
        return np.zeros(joints)
    return np.array([(limit.lower_rad + limit.upper_rad) / 2 for limit in ranges])


def _usable(estimate: Estimate, found: SearchEnd) -> BoolArray:
    """Say which rows arrived within the controller's limits, as far as these are known, shape (n,)."""
    _, within = turned_within(estimate.structure.robot.joint_limits, found.joints_rad)
    return np.asarray(found.arrived & within)
