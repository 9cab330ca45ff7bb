"""The closed form of arms with three parallel axes against their forward kinematics."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.helpers.kinematics.nominal_poses import apart_rad, nominal_poses
from truepose.domain.robot import JointRow, Robot
from truepose.exchange.robots.named import load_robot
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.inverse import BRANCH_NAMES, all_branches, branch_of, has_closed_form, one_branch

POSE = 1e-7  # mm: doubles carry 16 digits of 1000 mm, and some are lost where branches meet
QUARTER = np.pi / 2

# d_1, a_2, a_3, d_4, d_5, d_6 [mm] of the maker's standard table (Universal Robots, DH parameters for
# calculations of kinematics and dynamics)
TABLES = {
    "UR3e": (151.85, -243.55, -213.2, 131.05, 85.35, 92.1),
    "UR5e": (162.5, -425.0, -392.2, 133.3, 99.7, 99.6),
    "UR10e": (180.7, -612.7, -571.55, 174.15, 119.85, 116.55),
}


def arm(name):
    if name == "against each other":
        return against_each_other()
    d_1, a_2, a_3, d_4, d_5, d_6 = TABLES[name]
    rows = (
        JointRow(0.0, 0.0, 0.0, d_1),
        JointRow(QUARTER, 0.0, 0.0, 0.0),
        JointRow(0.0, a_2, 0.0, 0.0),
        JointRow(0.0, a_3, 0.0, d_4),
        JointRow(QUARTER, 0.0, 0.0, d_5),
        JointRow(-QUARTER, 0.0, 0.0, d_6),
    )
    return Robot(name, rows)


def against_each_other():
    """An arm with every freedom that the closed form has: offsets, signs, slopes, axes turned round."""
    rows = (
        JointRow(0.3, 20.0, 0.2, 150.0, sign=-1),
        JointRow(-QUARTER, 35.0, -QUARTER, 40.0),
        JointRow(np.pi, 420.0, 0.4, -15.0, sign=-1),
        JointRow(np.pi, 390.0, 0.1, 120.0),
        JointRow(-QUARTER, 0.0, -0.3, 95.0, sign=-1),
        JointRow(-QUARTER, 0.0, 0.7, 80.0),
    )
    return Robot("against each other", rows)


ARMS = (*TABLES, "against each other")


@pytest.mark.parametrize("name", ARMS)
@given(mrad=arrays(np.int64, 6, elements=st.integers(-6283, 6283)))
def test_every_branch_reaches_the_pose(name, mrad):
    robot = arm(name)
    wanted = nominal_poses(robot, mrad[None] / 1000.0)

    found = all_branches(robot, wanted)[0]

    there = np.isfinite(found).all(axis=1)
    assert there.any()
    assert np.abs(nominal_poses(robot, found[there]) - wanted).max() < POSE


@pytest.mark.parametrize("name", ARMS)
def test_the_branch_of_joints_leads_back_to_them(name):
    robot = arm(name)
    joints = np.random.default_rng(0).uniform(-np.pi, np.pi, (2000, 6))
    wanted = nominal_poses(robot, joints)

    branch = branch_of(robot, joints)

    assert (
        apart_rad(one_branch(robot, wanted, branch), joints).max() < 1e-5
    )  # half the digits where branches meet
    assert apart_rad(all_branches(robot, wanted)[np.arange(2000), branch], joints).max() < 1e-5
    assert len(set(branch)) == 8


def test_every_pose_of_quarter_turns_is_reached_though_branches_meet_there():
    robot = arm("UR5e")
    joints = np.array(list(product(*[(-QUARTER, 0.0, QUARTER, np.pi)] * 6)))
    wanted = nominal_poses(robot, joints)

    found = all_branches(robot, wanted)

    there = np.isfinite(found).all(axis=2)
    pose, branch = np.nonzero(there)
    assert there.any(axis=1).all()  # of 4096 poses, half with a locked wrist, a third with a straight elbow
    assert np.abs(nominal_poses(robot, found[pose, branch]) - wanted[pose]).max() < 1e-5


@pytest.mark.parametrize("name", TABLES)
def test_with_parallel_axes_4_and_6_joint_6_is_zero_where_it_can_be(name):
    robot = arm(name)
    at_zero = -robot.joints[4].theta_offset_rad * robot.joints[4].sign  # of joint 5, where axes are parallel
    bent, straight = np.array([0.3, -1.2, 1.4, 0.2, 0.0, 0.9]), np.array([0.3, -1.2, 0.0, 0.2, 0.0, 0.9])
    bent[4] = straight[4] = at_zero
    straight[2] = -robot.joints[2].theta_offset_rad * robot.joints[2].sign
    wanted = nominal_poses(robot, np.array([bent, straight]))

    found = all_branches(robot, wanted)

    for branches, pose in zip(found, wanted, strict=True):
        there = np.isfinite(branches).all(axis=1)
        assert there.any()
        assert (
            np.abs(nominal_poses(robot, branches[there]) - pose).max() < 1e-5
        )  # a straight arm: half the digits
    assert np.nanmin(np.abs(found[0, :, 5])) < 1e-12
    assert np.nanmin(np.abs(found[1, :, 5])) > 0.1


@pytest.mark.parametrize("name", TABLES)
def test_branches_bear_the_names_of_what_the_arm_looks_like(name):
    robot = arm(name)
    joints = np.random.default_rng(1).uniform(-np.pi, np.pi, (300, 6))

    found = all_branches(robot, nominal_poses(robot, joints))

    for k, words in enumerate(BRANCH_NAMES):
        rows = found[:, k][np.isfinite(found[:, k]).all(axis=1)]
        chain = nominal_chain(robot, rows)
        forwards = -np.stack([np.cos(rows[:, 0]), np.sin(rows[:, 0])], axis=1)  # a UR lies along -x at zero
        ahead = np.einsum("ni,ni->n", chain.origin[4, :, :2], forwards)
        assert np.all(ahead > 0) == ("front" in words)
        assert np.all(rows[:, 4] >= 0) == ("no flip" in words)
    usual = np.radians([[0.0, -90.0, 90.0, -90.0, -90.0, 0.0], [0.0, -20.0, -60.0, -90.0, 90.0, 0.0]])
    assert [BRANCH_NAMES[k] for k in branch_of(robot, usual)] == ["front/up/flip", "front/down/no flip"]


def test_out_of_reach_there_is_no_branch_but_a_place_to_search_from():
    robot = arm("UR3e")
    far = np.eye(4)
    far[:3, 3] = 3000.0, 0.0, 300.0

    assert np.isnan(all_branches(robot, far)).all()
    assert np.isfinite(all_branches(robot, far, reach_out=True)).all()


def test_nearer_to_axis_1_than_the_arm_is_wide_there_is_no_branch():
    robot = arm("UR5e")
    above = np.eye(4)
    above[:3, 3] = 100.0, 0.0, 700.0  # axes 5 and 6 meet 100 mm from axis 1, the arm passes it by 133.3 mm

    assert np.isnan(all_branches(robot, above)).all()


def test_the_arm_that_ships_is_one_of_these():
    assert has_closed_form(load_robot("universal-robots-ur10"))


@pytest.mark.parametrize(
    ("joint", "row"), [(3, {"alpha_rad": 0.1}), (5, {"a_mm": 4.0}), (4, {"beta_rad": 1e-3})]
)
def test_what_bends_the_build_has_no_closed_form(joint, row):
    rows = list(arm("UR5e").joints)
    rows[joint - 1] = replace(rows[joint - 1], **row)

    assert not has_closed_form(replace(arm("UR5e"), joints=tuple(rows)))
