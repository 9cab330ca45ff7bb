"""The chain against literal products of matrices, and every gradient against finite differences."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120, SEVEN_AXES
from truepose.domain.robot import LinkMass
from truepose.kinematics.chain import (
    alpha_gradient,
    beta_gradient,
    body_gradients,
    forward,
    nominal_values,
    theta_gradient,
)
from truepose.kinematics.frames import rotation_x, rotation_xyz, rotation_z
from truepose.kinematics.gravity import centre_of_gravity, gravity_torques, moment_regressor

CONFIGURATIONS = np.random.default_rng(1).uniform(-2.0, 2.0, (6, 7))
BASE = rotation_xyz(0.1, -0.2, 0.7), np.array([100.0, -50.0, 20.0])
GRAVITY = np.array([0.3, -0.2, -9.7])
TIP = np.array([12.0, -30.0, 125.0])


def joints_of(robot):
    return CONFIGURATIONS[:, : robot.n_joints]


def matrix(rotation, translation=(0.0, 0.0, 0.0)):
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = rotation, translation
    return result


def literal_product(robot, joints_rad, base_rotation, base_origin):
    """Craig's product, written out link by link."""
    result = matrix(base_rotation, base_origin)
    for row, q in zip(robot.joints, joints_rad, strict=True):
        theta = row.sign * q + row.theta_offset_rad
        result = result @ matrix(rotation_x(row.alpha_rad)) @ matrix(np.eye(3), (row.a_mm, 0, 0))
        result = result @ matrix(rotation_z(theta)) @ matrix(np.eye(3), (0, 0, row.d_mm))
    return result


@pytest.mark.parametrize("robot", [IRB_120, SEVEN_AXES], ids=lambda robot: robot.name)
def test_the_chain_is_the_product_of_its_links(robot):
    chain = forward(nominal_values(robot, joints_of(robot)), *BASE)

    for k, joints_rad in enumerate(joints_of(robot)):
        expected = literal_product(robot, joints_rad, *BASE)
        assert chain.rotation[-1, k] == pytest.approx(expected[:3, :3], abs=1e-12)
        assert chain.origin[-1, k] == pytest.approx(expected[:3, 3], abs=1e-9)


def test_the_irb_120_stands_at_zero_as_its_drawing_shows():
    chain = forward(nominal_values(IRB_120, np.zeros((1, 6))), np.eye(3), np.zeros(3))

    assert chain.origin[-1, 0] == pytest.approx([374.0, 0.0, 630.0], abs=1e-9)  # 302 + 72, 290 + 270 + 70


@pytest.mark.parametrize("quantity", ["alpha_rad", "a_mm", "beta_rad", "theta_rad", "d_mm"])
@pytest.mark.parametrize("robot", [IRB_120, SEVEN_AXES], ids=lambda robot: robot.name)
def test_every_gradient_agrees_with_central_differences(robot, quantity):
    rng = np.random.default_rng(5)
    values = nominal_values(robot, joints_of(robot))
    values = replace(values, beta_rad=rng.normal(size=robot.n_joints) * 0.05)  # away from the special case 0
    chain = forward(values, *BASE)
    points = chain.points(TIP)
    analytic = {
        "alpha_rad": lambda joint: alpha_gradient(chain, points)[joint],
        "a_mm": lambda joint: chain.x_before[joint],
        "beta_rad": lambda joint: beta_gradient(chain, points, joint),
        "theta_rad": lambda joint: theta_gradient(chain, points)[joint],
        "d_mm": lambda joint: chain.z[joint],
    }[quantity]

    for joint in range(robot.n_joints):
        step = 1e-5 if quantity.endswith("rad") else 1e-2
        ends = []
        for sign in (1.0, -1.0):
            moved = getattr(values, quantity).copy()
            moved[..., joint] += sign * step
            ends.append(forward(replace(values, **{quantity: moved}), *BASE).points(TIP))
        # truncation of central differences: step^2 / 6 of the third derivative, about 1e3 mm * 1e-10
        assert analytic(joint) == pytest.approx((ends[0] - ends[1]) / (2.0 * step), abs=1e-6)


def potential_energy(robot, joints_rad):
    chain = forward(nominal_values(robot, joints_rad), *BASE)
    energy = np.zeros(len(joints_rad))
    for link in robot.masses:
        centre = chain.origin[link.frame - 1] + chain.rotation[link.frame - 1] @ link.centre_of_gravity_mm
        energy -= link.mass_kg * centre @ GRAVITY
    return energy


def test_gravity_torques_are_the_slope_of_the_potential_energy():
    chain = forward(nominal_values(IRB_120, joints_of(IRB_120)), *BASE)

    torques = gravity_torques(chain, IRB_120.masses, GRAVITY)

    for joint in range(6):
        step = np.eye(6)[joint] * 1e-4
        rise = potential_energy(IRB_120, joints_of(IRB_120) + step)
        fall = potential_energy(IRB_120, joints_of(IRB_120) - step)
        # weight turns the joint towards less energy; 1e-8 of some 1e4 N mm by the step's square
        assert torques[:, joint] == pytest.approx(-(rise - fall) / 2e-4, abs=1e-3)


def test_torques_of_joints_two_and_three_have_the_range_found_by_recomputing_the_thesis():
    """Section 2.5 calls them negative; with I.10 as written they are positive (facts, section 9)."""
    rng = np.random.default_rng(6)
    joints = rng.uniform(
        np.deg2rad([-90, 0, -80, -150, -90, -180]), np.deg2rad([90, 90, 50, 150, 90, 180]), (4000, 6)
    )
    chain = forward(nominal_values(IRB_120, joints), np.eye(3), np.zeros(3))

    torques_nm = gravity_torques(chain, IRB_120.masses, np.array([0, 0, -9.81])) / 1e3

    assert torques_nm[:, 0] == pytest.approx(0.0, abs=1e-9)  # joint 1 is parallel to gravity
    assert 40.0 < torques_nm[:, 1].max() < 48.0
    assert 15.0 < torques_nm[:, 2].max() < 20.0


def test_moments_of_unknown_masses_enter_linearly():
    """A mass at a place is its two moments across the axis plus what regroups into the frames before it."""
    chain = forward(nominal_values(IRB_120, joints_of(IRB_120)), *BASE)
    link = (LinkMass(3, 2.0, (10.0, -20.0, 0.0)),)

    whole = gravity_torques(chain, link, GRAVITY)[:, 2]
    parts = 2.0 * 10.0 * moment_regressor(chain, 2, 2, 0, GRAVITY)
    parts = parts - 2.0 * 20.0 * moment_regressor(chain, 2, 2, 1, GRAVITY)

    assert whole == pytest.approx(parts, abs=1e-6)


@pytest.mark.parametrize("body", [0, 3, 6])
def test_points_of_a_body_follow_its_shifts_and_turns(body):
    chain = forward(nominal_values(IRB_120, joints_of(IRB_120)), *BASE)
    rotation, about = chain.body(body)
    motion = np.tile([1.0, -2.0, 0.5, 0.2, -0.1, 0.3], (len(about), 1))

    def places(shift, angles):
        return about + rotation @ shift + rotation @ rotation_xyz(*angles) @ TIP

    gradient = body_gradients(chain, body, motion, places(np.zeros(3), motion[0, 3:]))

    for k, one in enumerate(np.eye(3)):
        by_shift = places(one, motion[0, 3:]) - places(np.zeros(3), motion[0, 3:])
        by_angle = (
            places(np.zeros(3), motion[0, 3:] + 1e-6 * one) - places(np.zeros(3), motion[0, 3:] - 1e-6 * one)
        ) / 2e-6
        assert gradient[k] == pytest.approx(by_shift)
        assert gradient[3 + k] == pytest.approx(by_angle, abs=1e-5)


def test_the_weight_of_a_link_acts_at_its_centre_of_gravity_in_the_world():
    chain = forward(nominal_values(IRB_120, np.zeros((1, 6))), np.eye(3), np.array([0.0, 0.0, 100.0]))
    upright = LinkMass(1, 5.0, (10.0, 20.0, 30.0))

    assert centre_of_gravity(chain, upright) == pytest.approx(chain.origin[0] + [10.0, 20.0, 30.0])
