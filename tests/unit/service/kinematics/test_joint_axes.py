"""Axes in space against the table that they become, by forward kinematics of both."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120, SEVEN_AXES
from tests.helpers.kinematics.nominal_poses import nominal_poses
from truepose.domain.robot import JointRow, Robot
from truepose.exchange.robots.named import list_robots, load_robot
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import rotation_from_vector
from truepose.kinematics.inverse import has_closed_form
from truepose.kinematics.joint_axes import JointAxis, table_of

NANOMETRE = 1e-6


def turned_about(axes, joints, tip):
    """Products of exponentials: turn the tip about every axis, the last joint first."""
    pose = tip.copy()
    for axis, angle in reversed(list(zip(axes, joints, strict=True))):
        rotation = rotation_from_vector(axis.sign * angle * axis.direction)
        motion = np.eye(4)
        motion[:3, :3], motion[:3, 3] = rotation, axis.point_mm - rotation @ axis.point_mm
        pose = motion @ pose
    return pose


def axes_of(robot, rng=None):
    """The axes of a robot at zero, each given by any of its points."""
    chain = nominal_chain(robot, np.zeros((1, robot.n_joints)))
    along = np.zeros(robot.n_joints) if rng is None else rng.uniform(-500.0, 500.0, robot.n_joints)
    return [
        JointAxis(origin + way * rotation[:, 2], rotation[:, 2], row.sign)
        for origin, rotation, row, way in zip(
            chain.origin[:, 0], chain.rotation[:, 0], robot.joints, along, strict=True
        )
    ]


def assert_same_motion(axes, tip, table, n=20):
    robot = Robot("found", table.rows)
    rng = np.random.default_rng(8)
    last = np.linalg.inv(table.frames[-1]) @ tip
    for joints in rng.uniform(-3.0, 3.0, (n, len(axes))):
        found = table.base @ nominal_poses(robot, joints[None])[0] @ last
        np.testing.assert_allclose(found, turned_about(axes, joints, tip), atol=NANOMETRE)


@pytest.mark.parametrize("name", list_robots())
def test_a_makers_table_comes_back_from_its_axes(name):
    robot = load_robot(name)
    (tip,) = nominal_poses(robot, np.zeros((1, robot.n_joints)))

    table = table_of(axes_of(robot, np.random.default_rng(1)), np.eye(4), tip)

    assert table.base == pytest.approx(np.eye(4))
    for row, stated in zip(table.rows, robot.joints, strict=True):
        turns = (row.alpha_rad - stated.alpha_rad, row.theta_offset_rad - stated.theta_offset_rad)
        assert np.cos(turns) == pytest.approx(1.0)
        assert (row.a_mm, row.d_mm, row.sign) == pytest.approx(
            (stated.a_mm, stated.d_mm, stated.sign), abs=1e-9
        )
        assert row.beta_rad == 0.0


def random_axes(rng, n):
    directions = rng.standard_normal((n, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    signs = rng.choice([-1, 1], n).tolist()
    return [
        JointAxis(point, z, sign)
        for point, z, sign in zip(rng.uniform(-800.0, 800.0, (n, 3)), directions, signs, strict=True)
    ]


@pytest.mark.parametrize("seed", range(20))
def test_skew_axes_keep_their_motion(seed):
    rng = np.random.default_rng(seed)
    axes = random_axes(rng, 1 + seed % 7)
    base, tip = np.eye(4), np.eye(4)
    base[:3, :3] = rotation_from_vector(rng.standard_normal(3))
    tip[:3, :3], tip[:3, 3] = rotation_from_vector(rng.standard_normal(3)), rng.uniform(-500.0, 500.0, 3)

    assert_same_motion(axes, tip, table_of(axes, base, tip))


@pytest.mark.parametrize("tilt", [0.0, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 0.0349, 0.035, np.pi, np.pi - 1e-7])
@pytest.mark.parametrize("apart_mm", [0.0, 1e-9, 1.0, 400.0])
def test_nearly_parallel_axes_keep_their_motion_at_any_tilt_and_distance(tilt, apart_mm):
    """Axes 2 and 3 are apart by a distance and tilted out of every plane; before and behind stand others."""
    rotation = rotation_from_vector(tilt * np.array([0.6, 0.8, 0.0]))
    axes = [
        JointAxis(np.array([0.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])),
        JointAxis(np.array([0.0, 50.0, 300.0]), np.array([1.0, 0.0, 0.0])),
        JointAxis(np.array([30.0, 50.0, 300.0 + apart_mm]), rotation @ [1.0, 0.0, 0.0], -1),
        JointAxis(np.array([40.0, 350.0, 320.0]), rotation @ [1.0, 0.0, 0.0]),
        JointAxis(np.array([40.0, 500.0, 300.0]), np.array([0.0, 1.0, 0.0])),
    ]
    tip = np.eye(4)
    tip[:3, 3] = 60.0, 620.0, 310.0

    table = table_of(axes, np.eye(4), tip)

    assert_same_motion(axes, tip, table)
    assert max(abs(row.a_mm) + abs(row.d_mm) for row in table.rows) < 30_000.0


def test_parallel_axes_alone_keep_their_motion():
    z = np.array([0.0, 0.0, 1.0])
    axes = [JointAxis(np.array(p), z) for p in ((0.0, 0.0, 0.0), (325.0, 0.0, 10.0), (550.0, 0.0, 20.0))]
    tip = np.eye(4)
    tip[:3, 3] = 550.0, 0.0, 150.0

    table = table_of(axes, np.eye(4), tip)

    assert_same_motion(axes, tip, table)
    assert [row.a_mm for row in table.rows] == pytest.approx([0.0, 325.0, 225.0])


@pytest.mark.parametrize("robot", [IRB_120, SEVEN_AXES], ids=["irb120", "seven-axes"])
def test_a_beta_of_the_nominal_table_moves_the_chain_as_that_parameter_does(robot):
    tilted = replace(robot.joints[2], beta_rad=0.01)
    bent = replace(robot, joints=(*robot.joints[:2], tilted, *robot.joints[3:]))
    joints = np.zeros((1, robot.n_joints))

    before, after = nominal_chain(robot, joints), nominal_chain(bent, joints)

    leaning = np.arccos(np.clip(before.z[2, 0] @ after.z[2, 0], -1.0, 1.0))
    assert leaning == pytest.approx(0.01, abs=1e-9)
    assert np.abs(after.z[2, 0] @ before.y_middle(2)[0]) < 1e-12


def test_a_row_has_no_beta_unless_it_is_given_one():
    assert JointRow(0.0, 1.0, 0.0, 2.0).beta_rad == 0.0


def test_a_tilted_axis_has_no_closed_inverse():
    tilted = replace(IRB_120.joints[2], beta_rad=1e-4)
    assert has_closed_form(IRB_120)
    assert not has_closed_form(replace(IRB_120, joints=(*IRB_120.joints[:2], tilted, *IRB_120.joints[3:])))
