"""Aimed poses have their coded lengths, on their branch; where that cannot be, it is said why."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell, fixture_before_the_arm
from tests.helpers.ballbar.nominal_poses import nominal_lengths, reachable
from tests.helpers.kinematics.nominal_poses import apart_rad, nominal_poses
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange
from truepose.kinematics.inverse import all_branches
from truepose.planning.ballbar.length_targets import aim_joints, aimed_pose
from truepose.planning.errors import AimError

CELL, FIXTURE = ballbar_cell(), fixture_before_the_arm()
POSES = reachable(CELL, FIXTURE)
MET = 1e-4  # where aiming stops, a fifth of the ballbar's scatter


def lengths_of(pose, cups=FIXTURE.cups_mm, cell=CELL):
    return nominal_lengths(cell, cups, pose.legs)


def test_every_reachable_pose_can_be_aimed_at_coded_lengths():
    for pose in POSES:
        found = aimed_pose(pose, lengths_of(pose), 300.0, CELL.ranges)

        lengths = lengths_of(pose)(np.array([found.joints_rad]))[0]
        assert np.abs(lengths - found.aimed_mm).max() < MET
        assert len({round(length, 3) for length in found.aimed_mm}) == 6


def test_the_aim_stays_on_the_branch_of_the_pose():
    for pose in POSES[:20]:
        found = aimed_pose(pose, lengths_of(pose), 300.0)

        assert branch(found.joints_rad) == branch(pose.joints_rad)


def branch(joints):
    (pose,) = nominal_poses(CELL.robot, np.array([joints]))
    return int(np.nanargmin(apart_rad(all_branches(CELL.robot, pose), np.array(joints))))


def test_another_model_and_other_cups_are_aimed_at_as_well():
    rng = np.random.default_rng(0)
    rows = tuple(
        replace(row, a_mm=row.a_mm + rng.normal(0, 0.2), alpha_rad=row.alpha_rad + rng.normal(0, 1e-3))
        for row in CELL.robot.joints
    )
    identified = replace(CELL, robot=replace(CELL.robot, joints=rows))
    cups = FIXTURE.cups_mm + rng.normal(0, 0.5, (3, 3))
    pose = POSES[5]
    lengths = lengths_of(pose, cups, identified)

    found = aimed_pose(pose, lengths, 300.0, CELL.ranges)

    assert np.abs(lengths(np.array([found.joints_rad]))[0] - found.aimed_mm).max() < MET


def test_which_leg_has_which_level_changes_from_pose_to_pose():
    first, second = (replace(POSES[0], config=config) for config in (1, 2))

    codes = [aimed_pose(pose, lengths_of(pose), 300.0).aimed_mm for pose in (first, second)]

    assert np.all(np.abs(np.subtract(*codes)) > 0.2)


def test_lengths_that_no_joints_give_are_refused():
    pose = POSES[0]

    with pytest.raises(AimError, match=r"Joint \d would have to move by more than 8 deg"):
        aim_joints(lengths_of(pose), pose.joints_rad, np.array([340.0, 260.0] * 3))


def test_joints_that_would_leave_their_range_are_refused():
    pose = POSES[0]
    tight = tuple(JointRange(angle, angle) for angle in pose.joints_rad)

    with pytest.raises(AimError, match="outside its range"):
        aimed_pose(pose, lengths_of(pose), 300.0, tight)


def test_a_leg_asked_for_twice_with_two_lengths_is_refused():
    pose = replace(POSES[0], legs=(*POSES[0].legs[:5], POSES[0].legs[0]))

    with pytest.raises(AimError, match="singular"):
        aimed_pose(pose, lengths_of(pose), 300.0)


def test_more_legs_than_joints_are_refused_where_they_contradict():
    pose = POSES[0]
    legs = (*pose.legs, next((b, t) for b in (1, 2, 3) for t in (1, 2, 3) if (b, t) not in pose.legs))
    lengths = nominal_lengths(CELL, FIXTURE.cups_mm, legs)
    wanted = lengths(np.array([pose.joints_rad]))[0]

    assert aim_joints(lengths, pose.joints_rad, wanted) == pytest.approx(np.array(pose.joints_rad))
    with pytest.raises(AimError, match=r"an error of .* mm remains"):
        aim_joints(lengths, pose.joints_rad, wanted + 0.5 * (np.arange(7) == 6))


def test_a_model_without_an_answer_is_refused():
    pose = POSES[0]

    with pytest.raises(AimError, match="gives no ballbar lengths"):
        aim_joints(lambda joints: np.full((len(joints), 6), np.nan), pose.joints_rad, np.full(6, 300.0))


def test_lengths_of_another_number_are_refused():
    pose = POSES[0]

    with pytest.raises(ConfigurationError, match="5 target lengths were given for 6 ballbar lengths"):
        aim_joints(lengths_of(pose), pose.joints_rad, np.full(5, 300.0))
