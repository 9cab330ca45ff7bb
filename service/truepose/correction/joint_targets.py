"""Corrected joint targets: for every goal the joint angles at which the real tool is there, or why not.

The controller keeps its nominal model; it is handed joint angles q for which its own model N is wrong by just
as much as the robot is: with F the identified model, F(q) is the goal, and N(q) the "fake" pose that it
believes to go to (thesis of A. Nubiola, 2014, section 1.5).
"""

from dataclasses import replace
from typing import Final

import numpy as np

from truepose.correction.branches import NominalArm, Ranges, attain_any_branch, attain_branch
from truepose.correction.inverse import SearchEnd, attain, nearer_of, with_rows_replaced
from truepose.correction.results import ANY_BRANCH, Corrections, judge_searches, stack_tables
from truepose.correction.target_poses import FAR_RAD, FLANGE, Goals
from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.domain.identification import Model
from truepose.domain.last_moves import with_moves
from truepose.identification.model.estimates import (
    Estimate,
    check_nests,
    check_stops,
    identified_estimate,
)
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.inverse import branch_of, check_branches

_AT_ONCE: Final = 10_000  # goals; their derivatives take some tens of megabytes


def correct(model: Model, goals: Goals, branch: IntArray | None = None) -> Corrections:
    """Find joint angles at which the identified robot reaches its goals.

    Parameters
    ----------
    model : Model
    goals : Goals
        n poses. Where their stops tell joint angles, the answer is the one near these; direction of
        approach, time, temperature and mounting are taken from them too.
    branch : ndarray of int, shape (n,), optional
        Asked for, as in `kinematics.inverse`; ANY_BRANCH for the one in which the robot was measured most. Of
        rows that tell joint angles it is not looked at.

    Returns
    -------
    Corrections
        Every row is judged: solved within 1 um and 1 urad, or why not.

    Raises
    ------
    ConfigurationError
        Another number of joints, an unknown nest, a branch that the arm does not have, or measured torques
        that the model needs are missing.
    """
    asked = np.full(len(goals), ANY_BRANCH) if branch is None else branch
    check_stops(model, goals.stops)
    check_nests(model, goals.nest[goals.nest != FLANGE])
    check_branches(model.robot, asked[~_told(goals) & (asked != ANY_BRANCH)])
    estimate = with_flange(identified_estimate(model))
    # Before the table is split: the last move to a target is from the one before it in time.
    stops, nest = with_moves(goals.stops), numbered_nests(model, goals.nest)
    numbered = replace(goals, stops=stops, nest=nest)
    rows = np.arange(len(goals))
    parts = [
        _correct(model, estimate, numbered.taken(some), asked[some])
        # In parts, as derivatives of all targets at once would be held in memory together.
        for some in np.split(rows, range(_AT_ONCE, len(rows), _AT_ONCE))
    ]
    return stack_tables(parts)


def in_world(model: Model, goals: Goals) -> Goals:
    """Return goals that are meant in the robot's own base, where the model knows it to stand.

    Parameters
    ----------
    model : Model
    goals : Goals
        n of them; position [mm] and rotation in the robot's base.
    """
    return _arm(model).in_world(goals)


def flange_in_base(model: Model, goals: Goals) -> FloatArray:
    """Return where goals in the world have the flange frame, in the robot's base.

    Parameters
    ----------
    model : Model
    goals : Goals
        n of them, of nests of the model or FLANGE.

    Returns
    -------
    ndarray, shape (n, 4, 4)
        [mm]
    """
    return _arm(model).flange(replace(goals, nest=numbered_nests(model, goals.nest)))


def goals_of_joints(model: Model, stops: Stops) -> Goals:
    """Return goals, in the world, where the controller itself has the flange frame at these stops.

    Parameters
    ----------
    model : Model
    stops : Stops
        n rows.
    """
    chain = nominal_chain(model.robot, stops.joints_rad)
    flange = np.full(len(stops), FLANGE)
    return in_world(model, Goals(stops, flange, chain.end_origin, chain.end_rotation))


def tool_nests_mm(model: Model) -> FloatArray:
    """Return where the model has its tool nests.

    Parameters
    ----------
    model : Model
        With K nests.

    Returns
    -------
    ndarray, shape (K, 3)
        [mm], flange frame.
    """
    return _arm(model).nests_mm[:-1]


def pose_shifts(model: Model, goals: Goals, joints_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return by how much a correction shifts the poses that the controller is handed.

    Parameters
    ----------
    model : Model
    goals : Goals
        n poses in the world.
    joints_rad : ndarray, shape (n, J)
        What is sent for them; NaN where nothing is.

    Returns
    -------
    place_mm : ndarray, shape (n, 3)
        Where the goals have the origin of the flange frame, in the robot's base.
    shift_mm : ndarray, shape (n, 3)
        From there to where the controller believes that origin to be with these joints; NaN as these.
    """
    place = flange_in_base(model, goals)[:, :3, 3]
    return place, nominal_chain(model.robot, joints_rad).end_origin - place


def _arm(model: Model) -> NominalArm:
    # A model may have been made without a nest; the origin of its flange frame is always there.
    return NominalArm(with_flange(identified_estimate(model)))


def with_flange(estimate: Estimate) -> Estimate:
    """Return an estimate with one more nest, the origin of the flange frame, behind its own.

    Parameters
    ----------
    estimate : Estimate
        With K nests; that of the result is number K + 1.
    """
    structure = estimate.structure
    nests = np.vstack([structure.nests_mm, np.zeros(3)])
    return replace(estimate, structure=replace(structure, nests_mm=nests))


def numbered_nests(model: Model, nest: IntArray) -> IntArray:
    """Return nests of goals as `with_flange` numbers them.

    Parameters
    ----------
    model : Model
    nest : ndarray of int, shape (n,)
        FLANGE, or from 1.

    Returns
    -------
    ndarray of int, shape (n,)
    """
    return np.where(nest == FLANGE, len(model.nests) + 1, nest)


def _correct(model: Model, estimate: Estimate, goals: Goals, asked: IntArray) -> Corrections:
    """Correct some goals: near joints that are told, in a branch that is asked for, else in any."""
    told = _told(goals)
    found = _from_told(estimate, goals, told)
    rows = np.flatnonzero(~told & (asked != ANY_BRANCH))
    # Where a branch was asked for, an answer in another one is none (docs/decisions/0071): the posture is
    # what keeps the arm clear of the cell.
    found = with_rows_replaced(found, rows, attain_branch(estimate, goals.taken(rows), asked[rows]))
    rows = np.flatnonzero(~told & (asked == ANY_BRANCH))
    found = with_rows_replaced(found, rows, attain_any_branch(estimate, goals.taken(rows), _measured(model)))
    return judge_searches(model, estimate, goals, found, told)


def _told(goals: Goals) -> BoolArray:
    """Say which goals tell joints to begin from, shape (n,)."""
    return np.asarray(np.isfinite(goals.stops.joints_rad).all(axis=1))


def _measured(model: Model) -> Ranges:
    """Return joint ranges: those that were measured, else of calibration, else the limits; None: unknown."""
    robot = model.robot
    return (model.zone.joint_ranges if model.zone else robot.calibration_ranges) or robot.joint_limits


def _from_told(estimate: Estimate, goals: Goals, told: BoolArray) -> SearchEnd:
    """Search from the joints that are told, in their branch, near them or near the nominal answer there.

    Parameters
    ----------
    estimate : Estimate
    goals : Goals
        n of them.
    told : ndarray of bool, shape (n,)

    Returns
    -------
    SearchEnd
        n rows; NaN where no joints were told. Answers that leave the branch, or turn a joint by more than 5
        deg from both, have gone astray.
    """
    found, arm = attain(estimate, goals, goals.stops.joints_rad), NominalArm(estimate)
    rows = np.flatnonzero(told)
    if not len(rows) or not arm.has_branches:
        return found
    goals, start = goals.taken(rows), goals.stops.joints_rad[rows]
    branch = branch_of(estimate.structure.robot, start)
    # Near a singularity the controller's own answer may lie far from the joints that were told: either is
    # near enough.
    own = _turned_to(arm.one_branch(arm.flange(goals), branch), start)

    def near(ended: SearchEnd) -> SearchEnd:
        away = [np.abs(ended.joints_rad - joints).max(axis=1) for joints in (start, own)]
        return ended.without(~(np.minimum(*away) <= FAR_RAD))

    first = near(arm.kept_to(branch, found.taken(rows)))
    left = np.flatnonzero(~first.arrived)
    again = attain_branch(estimate, goals.taken(left), branch[left])
    turned = with_rows_replaced(
        first, left, replace(again, joints_rad=_turned_to(again.joints_rad, start[left]))
    )
    return with_rows_replaced(found, rows, nearer_of(first, left, near(turned).taken(left)))


def _turned_to(joints_rad: FloatArray, near_rad: FloatArray) -> FloatArray:
    """Return angles with as many whole turns as bring them nearest to others."""
    return np.asarray(joints_rad - 2 * np.pi * np.round((joints_rad - near_rad) / (2 * np.pi)))
