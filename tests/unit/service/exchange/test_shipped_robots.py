"""The shipped robots are what their makers and the thesis say."""

import math

import numpy as np
import pytest

from truepose.exchange.errors import UnknownRobotError
from truepose.exchange.robots.shipped import list_robots, load_robot, load_robot_with_tool


def rot_x(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1.0]])


def rot_z(angle):
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def shift(x, z):
    frame = np.eye(4)
    frame[0, 3], frame[2, 3] = x, z
    return frame


def modified_frames(robot, q):
    frame, frames = np.eye(4), []
    for row, angle in zip(robot.joints, q, strict=True):
        turn = rot_z(row.sign * angle + row.theta_offset_rad)
        frame = frame @ rot_x(row.alpha_rad) @ shift(row.a_mm, 0.0) @ turn @ shift(0.0, row.d_mm)
        frames.append(frame)
    return frames


# The maker's page on kinematics and dynamics, UR10: a [mm], d [mm], alpha, mass [kg], centre of mass [mm].
UR10 = (
    (0.0, 127.3, math.pi / 2, 7.1, (21.0, 0.0, 27.0)),
    (-612.0, 0.0, 0.0, 12.7, (380.0, 0.0, 158.0)),
    (-572.3, 0.0, 0.0, 4.27, (240.0, 0.0, 68.0)),
    (0.0, 163.941, math.pi / 2, 2.0, (0.0, 7.0, 18.0)),
    (0.0, 115.7, -math.pi / 2, 2.0, (0.0, 7.0, 18.0)),
    (0.0, 92.2, 0.0, 0.365, (0.0, 0.0, -26.0)),
)


def standard_frames(q):
    frame, frames = np.eye(4), []
    for (a, d, alpha, _, _), angle in zip(UR10, q, strict=True):
        frame = frame @ rot_z(angle) @ shift(0.0, d) @ shift(a, 0.0) @ rot_x(alpha)
        frames.append(frame)
    return frames


def test_the_ur10_is_the_makers_in_another_convention():
    robot = load_robot("universal-robots-ur10")
    rng = np.random.default_rng(1)

    for q in rng.uniform(-math.pi, math.pi, (50, 6)):
        ours, theirs = modified_frames(robot, q), standard_frames(q)
        np.testing.assert_allclose(ours[-1], theirs[-1], atol=1e-11)  # 1e-16 of 1300 mm, a dozen products
        for mass, frame, (*_, kg, centre) in zip(robot.masses, theirs, UR10, strict=True):
            here = ours[mass.frame - 1] @ [*mass.centre_of_gravity_mm, 1.0]
            np.testing.assert_allclose(here, frame @ [*centre, 1.0], atol=1e-11)
            assert mass.mass_kg == kg


def test_the_irb_120_is_the_thesis_table():
    robot = load_robot("abb-irb-120")

    assert [row.a_mm for row in robot.joints] == [0, 0, 270, 70, 0, 0]
    assert [row.d_mm for row in robot.joints] == [290, 0, 0, 302, 0, 72]
    assert [math.degrees(row.alpha_rad) for row in robot.joints] == [0, -90, 0, -90, 90, -90]
    assert [math.degrees(row.theta_offset_rad) for row in robot.joints] == [0, -90, 0, 0, 0, 180]


def test_the_lr_mate_is_the_thesis_table():
    robot = load_robot("fanuc-lr-mate-200ic")

    assert [row.a_mm for row in robot.joints] == [0, 75, 300, 75, 0, 0]
    assert [row.d_mm for row in robot.joints] == [330, 0, 0, 320, 0, 80]
    assert [math.degrees(row.theta_offset_rad) for row in robot.joints] == [0, -90, 0, 0, 0, 0]


@pytest.mark.parametrize("name", list_robots())
def test_every_robot_names_the_source_of_its_numbers(name):
    robot = load_robot(name)

    assert robot.source
    assert robot.repeatability_mm > 0.0


@pytest.mark.parametrize("name", ["abb-irb-120", "fanuc-lr-mate-200ic"])
def test_the_triangular_artefact_has_sides_of_150_mm(name):
    centres = [np.array(nest.centre_mm) for nest in load_robot_with_tool(name).nests]

    sides = [np.linalg.norm(centres[i] - centres[j]) for i, j in ((0, 1), (1, 2), (2, 0))]

    assert sides == pytest.approx([150.0] * 3, abs=0.01)  # nest 2 is given to 0.001 mm in a plane at 90 mm


def test_calibration_ranges_lie_within_the_joint_limits():
    robot = load_robot("abb-irb-120")

    for calibration, limit in zip(robot.calibration_ranges, robot.joint_limits, strict=True):
        assert limit.lower_rad <= calibration.lower_rad < calibration.upper_rad <= limit.upper_rad


def test_an_unknown_robot_is_answered_with_the_known_ones():
    with pytest.raises(UnknownRobotError) as refusal:
        load_robot("abb-irb-1600")

    assert str(refusal.value) == (
        "No robot is called 'abb-irb-1600'; the shipped ones are "
        "abb-irb-120, fanuc-lr-mate-200ic, universal-robots-ur10."
    )


@pytest.mark.parametrize("name", ["../robots/abb-irb-120", "", "abb-irb-120.toml"])
def test_a_name_is_no_path(name):
    with pytest.raises(UnknownRobotError):
        load_robot(name)
