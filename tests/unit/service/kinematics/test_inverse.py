"""The inverse of the nominal robot against its own forward kinematics."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import SEVEN_AXES
from tests.helpers.kinematics.nominal_poses import apart_rad, nominal_poses
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange, JointRow
from truepose.exchange.robots.named import load_robot
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.inverse import (
    BRANCH_NAMES,
    all_branches,
    branch_of,
    brought_within,
    check_branches,
    has_closed_form,
    one_branch,
)
from truepose.kinematics.inverse_parts import within_reach

# Doubles carry 16 digits of some 1000 mm through a dozen products; near singularities joints lose half.
POSE = 1e-9
JOINTS = 1e-6

ARMS = ("abb-irb-120", "fanuc-lr-mate-200ic")


def random_joints(robot, n, seed=0):
    return np.random.default_rng(seed).uniform(-np.pi, np.pi, (n, robot.n_joints))


def nearest(branches, joints):
    """How far the closest branch is from the joints, whole turns aside."""
    return np.nanmin(apart_rad(branches, joints[:, None]), axis=1)


def changed(robot, joint, **row):
    rows = list(robot.joints)
    rows[joint - 1] = replace(rows[joint - 1], **row)
    return replace(robot, joints=tuple(rows))


def variants():
    base = load_robot("fanuc-lr-mate-200ic")
    offset = changed(changed(base, 2, d_mm=40.0), 3, d_mm=-25.0)
    turned = changed(base, 3, alpha_rad=np.pi)
    signs = replace(
        base,
        joints=tuple(replace(row, sign=s) for row, s in zip(base.joints, (1, -1, -1, 1, -1, 1), strict=True)),
    )
    tilted = changed(changed(base, 1, alpha_rad=0.3, a_mm=20.0), 4, alpha_rad=np.pi / 2)
    return {"shoulder aside": offset, "axes against each other": turned, "signs": signs, "on a slope": tilted}


@pytest.mark.parametrize("name", ARMS)
def test_each_branch_reaches_the_pose_and_one_is_the_configuration_it_came_from(name):
    robot, joints = load_robot(name), random_joints(load_robot(name), 500)
    wanted = nominal_poses(robot, joints)

    found = all_branches(robot, wanted)

    there = np.isfinite(found).all(axis=2)
    pose, branch = np.nonzero(there)
    assert np.abs(nominal_poses(robot, found[there]) - wanted[pose]).max() < POSE
    assert nearest(found, joints).max() < JOINTS
    assert len(set(branch)) == 8


@pytest.mark.parametrize("variant", variants())
def test_offsets_signs_and_slopes_do_not_spoil_the_closed_form(variant):
    robot = variants()[variant]
    joints = random_joints(robot, 200, seed=1)

    found = all_branches(robot, nominal_poses(robot, joints))

    assert has_closed_form(robot)
    assert nearest(found, joints).max() < JOINTS


@pytest.mark.parametrize("name", ARMS)
def test_branches_bear_the_names_of_what_the_arm_looks_like(name):
    robot = load_robot(name)
    joints = random_joints(robot, 300, seed=2)

    found = all_branches(robot, nominal_poses(robot, joints))

    for k, words in enumerate(BRANCH_NAMES):
        rows = found[:, k][np.isfinite(found[:, k]).all(axis=1)]
        chain = nominal_chain(robot, rows)
        towards = np.stack([np.cos(rows[:, 0]), np.sin(rows[:, 0]), np.zeros(len(rows))], axis=1)
        reach = np.einsum("ni,ni->n", chain.origin[3], towards)
        assert (np.all(reach > 0)) == ("front" in words)
        assert np.all(rows[:, 4] >= 0) == ("no flip" in words)
    assert "front/up" in BRANCH_NAMES[_branch_at(robot, np.array([0.0, 0.0, 0.0, 0.1, 0.5, 0.0]))]


def test_the_elbow_of_an_arm_that_reaches_over_its_head_hangs_down():
    robot = load_robot("fanuc-lr-mate-200ic")

    branch = _branch_at(robot, np.radians([10.0, -50.0, -70.0, 5.0, 40.0, 0.0]))

    assert BRANCH_NAMES[branch] == "back/down/no flip"


def _branch_at(robot, joints):
    found = all_branches(robot, nominal_poses(robot, joints[None]))[0]
    return int(np.nanargmin(np.abs(found - joints).max(axis=1)))


def test_a_pose_out_of_reach_has_no_branch():
    robot = load_robot("abb-irb-120")
    far = np.eye(4)
    far[:3, 3] = 2000.0, 0.0, 300.0

    assert np.isnan(all_branches(robot, far)).all()


def test_a_straight_arm_is_still_reached_and_a_little_further_is_not():
    robot = load_robot("abb-irb-120")
    elbow = -np.arctan2(302.0, 70.0)  # upper arm and forearm in one line
    stretched = nominal_poses(robot, np.array([[0.2, 0.6, elbow, 0.0, 0.4, 0.0]]))[0]
    outward = stretched[:3, 3] - np.array([0.0, 0.0, 290.0])

    beyond = stretched.copy()
    beyond[:3, 3] += 1e-3 * outward / np.linalg.norm(outward)

    assert np.isfinite(all_branches(robot, stretched)[:4]).all()
    assert np.isnan(all_branches(robot, beyond)[:4]).all()


def test_at_a_wrist_singularity_joint_4_is_zero_and_joint_6_makes_up_for_it():
    robot = load_robot("fanuc-lr-mate-200ic")
    joints = np.array([[0.3, 0.5, 0.2, 0.7, 0.0, -0.4]])
    wanted = nominal_poses(robot, joints)

    found = all_branches(robot, wanted)[0, :2]

    assert np.abs(found[:, 3]).max() == 0.0
    assert found[0, 5] == pytest.approx(0.3, abs=JOINTS)
    assert np.abs(nominal_poses(robot, found) - wanted).max() < POSE


@pytest.mark.parametrize("shape", [(), (1,), (2, 3), (0,)])
def test_any_shape_of_poses_is_answered_in_kind(shape):
    robot = load_robot("abb-irb-120")

    found = all_branches(robot, np.broadcast_to(np.eye(4), (*shape, 4, 4)))

    assert found.shape == (*shape, 8, 6)


@pytest.mark.parametrize("pose", [np.eye(3), np.full((4, 4), np.nan)])
def test_what_is_no_pose_is_refused(pose):
    with pytest.raises(ConfigurationError, match="4 x 4"):
        all_branches(load_robot("abb-irb-120"), pose)


def test_an_arm_of_another_build_is_searched():
    robot = changed(load_robot("universal-robots-ur10"), 5, a_mm=5.0)
    joints = random_joints(robot, 12, seed=4)
    wanted = nominal_poses(robot, joints)

    found = all_branches(robot, wanted)

    there = np.isfinite(found).all(axis=2)
    pose, _ = np.nonzero(there)
    assert not has_closed_form(robot)
    assert (
        np.abs(nominal_poses(robot, found[there]) - wanted[pose]).max() < 1e-6
    )  # where the search stops, mm
    assert nearest(found, joints).max() < 1e-4
    assert np.median(there.sum(axis=1)) >= 6  # such arms have up to eight


def test_an_arm_with_seven_axes_reaches_a_pose_in_ways_that_differ():
    joints = random_joints(SEVEN_AXES, 2, seed=5)
    wanted = nominal_poses(SEVEN_AXES, joints)

    found = all_branches(SEVEN_AXES, wanted)

    assert np.isfinite(found).all()
    assert np.abs(nominal_poses(SEVEN_AXES, found[0]) - wanted[0]).max() < 1e-6
    assert len(np.unique(found[0].round(3), axis=0)) == 8


def test_the_search_finds_nothing_out_of_reach():
    robot = changed(load_robot("universal-robots-ur10"), 5, a_mm=5.0)
    far = np.eye(4)
    far[:3, 3] = 5000.0, 0.0, 0.0

    assert np.isnan(all_branches(robot, far)).all()


@pytest.mark.parametrize(
    "row",
    [{"alpha_rad": 1.0}, {"a_mm": 5.0}, {"d_mm": 5.0}],
)
def test_a_wrist_whose_axes_do_not_meet_has_no_closed_form(row):
    robot = changed(load_robot("abb-irb-120"), 5, **row)

    assert not has_closed_form(robot)


def test_joints_are_turned_towards_the_middle_of_their_range():
    limits = (JointRange(np.pi, 3 * np.pi), JointRange(-1.0, 1.0))

    turned, within = brought_within(np.array([[0.5, 0.5], [0.5, 2.0], [np.nan, 0.0]]), limits)

    assert turned[0, 0] == pytest.approx(0.5 + 2 * np.pi)
    assert within.tolist() == [True, False, False]


def test_a_row_may_be_built_by_hand():
    rows = tuple(JointRow(alpha, a, 0.0, d) for alpha, a, d in ((0, 0, 100), (-np.pi / 2, 0, 0)))
    robot = replace(load_robot("abb-irb-120"), joints=rows)

    assert not has_closed_form(robot)


@pytest.mark.parametrize("name", [*ARMS, *variants()])
def test_the_branch_of_joints_is_the_one_that_leads_back_to_them(name):
    robot = variants().get(name) or load_robot(name)
    joints = random_joints(robot, 500)

    branches = all_branches(robot, nominal_poses(robot, joints))

    nearest_one = np.nanargmin(apart_rad(branches, joints[:, None]), axis=1)
    assert branch_of(robot, joints).tolist() == nearest_one.tolist()


@pytest.mark.parametrize("name", [*ARMS, "universal-robots-ur10"])
@pytest.mark.parametrize("offset_rad", [0.0, np.pi, -np.pi])
@pytest.mark.parametrize("sign", [1, -1])
def test_where_the_wrist_is_straight_the_branch_is_the_lower_one_whatever_its_offset(name, offset_rad, sign):
    robot = changed(load_robot(name), 5, theta_offset_rad=offset_rad, sign=sign)
    joints = np.array([[0.3, -0.9, 0.8, 0.2, q5, 0.1] for q5 in (0.0, np.pi, 0.2, -0.2)])

    branch = branch_of(robot, joints)

    assert (branch % 2).tolist() == [0, 0, 0, 1]


def test_an_arm_without_a_closed_form_has_no_numbered_branches():
    with pytest.raises(ConfigurationError, match="no numbered branches"):
        branch_of(SEVEN_AXES, np.zeros((1, 7)))


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_reaches_out_for_what_is_too_far_and_for_nothing_else(name):
    robot = load_robot(name)
    near = nominal_poses(robot, random_joints(robot, 50))
    far = near.copy()
    far[:, :3, 3] += 5000.0

    exists = np.isfinite(all_branches(robot, near))
    assert all_branches(robot, near, reach_out=True)[exists] == pytest.approx(
        all_branches(robot, near)[exists]
    )
    assert np.isnan(all_branches(robot, far)).all()
    assert np.isfinite(all_branches(robot, far, reach_out=True)).all()


@pytest.mark.parametrize("name", ARMS)
def test_one_branch_is_that_of_all_of_them(name):
    robot = load_robot(name)
    pose = nominal_poses(robot, random_joints(robot, 80))
    branch = np.arange(80) % 8

    alone = one_branch(robot, pose, branch)

    assert alone == pytest.approx(all_branches(robot, pose, reach_out=True)[np.arange(80), branch])


@pytest.mark.parametrize("number", [-1, 8])
def test_numbers_of_branches_that_no_arm_has_are_refused(number):
    robot = load_robot(ARMS[0])

    check_branches(robot, np.arange(8))
    with pytest.raises(ConfigurationError, match=f"Branch {number} is unknown: .* from 0 to 7"):
        check_branches(robot, np.array([0, number]))


def test_an_arm_without_numbered_branches_takes_no_number_and_an_empty_list():
    check_branches(SEVEN_AXES, np.array([], dtype=int))
    with pytest.raises(ConfigurationError):
        check_branches(SEVEN_AXES, np.array([0]))


def test_only_poses_out_of_reach_are_brought_to_an_arm_five_degrees_from_straight():
    assert within_reach(np.array([-0.999, 0.0, 0.5])).tolist() == [-0.999, 0.0, 0.5]
    assert within_reach(np.array([-1.2, 1.0, 3.0])) == pytest.approx(
        np.cos(np.radians(5)) * np.array([-1, 1, 1])
    )


def test_a_wrist_on_the_first_axis_is_reached_with_whatever_angle_of_that_joint():
    robot = load_robot("abb-irb-120")
    pose = np.eye(4)[None].copy()
    pose[0, :3, 3] = [0.0, 0.0, 700.0 + robot.joints[5].d_mm]

    found = all_branches(robot, pose)[0]

    reached = found[np.isfinite(found).all(axis=1)]
    assert len(reached)
    assert nominal_poses(robot, reached) == pytest.approx(np.tile(pose, (len(reached), 1, 1)), abs=POSE)
