"""Joint 3 counted from the horizontal: against a pose and joints that were published together."""

import numpy as np
import pytest

from truepose.domain.robot import JointRow, Robot
from truepose.exchange.programs.joints_reached import can_be_coupled, from_horizontal, from_upper_arm
from truepose.exchange.programs.program import Configuration
from truepose.kinematics.chain import nominal_chain

RIGHT = np.pi / 2


def r_2000ib(sign_3=1):
    """Shoulder 312 mm out, upper arm 1075, forearm 225 up and 1280 out; its world stands at axis 2.

    Dimensions from the maker's data sheet. Joint 2 leans forwards, joint 3 lifts the forearm.
    """
    rows = (
        JointRow(0.0, 0.0, 0.0, 0.0),
        JointRow(-RIGHT, 312.0, -RIGHT, 0.0),
        JointRow(0.0, 1075.0, 0.0, 0.0, sign=-sign_3),
        JointRow(-RIGHT, 225.0, 0.0, 1280.0),
        JointRow(RIGHT, 0.0, 0.0, 0.0),
        JointRow(-RIGHT, 0.0, 0.0, 0.0),
    )
    return Robot("R-2000iB/165F", rows)


def test_a_published_pose_and_its_joints_agree_only_if_joint_3_counts_from_the_horizontal():
    # onerobotics.com, The perils of six-axis robots (2013): NUT 000 at X 1500, Z 360, W 135, P -45, R 0.
    shown = Configuration(tuple(np.radians([7.962, -5.284, -36.250, 77.661, -51.975, -79.273]).tolist()))
    approach = np.array([0.5, -np.sqrt(0.5), -0.5])  # axis of the flange there
    length = 1500.0 * np.tan(np.radians(7.962)) / (np.sqrt(0.5) + 0.5 * np.tan(np.radians(7.962)))  # tool
    wrist = np.array([1500.0, 0.0, 360.0]) - length * approach

    coupled, as_read = (
        nominal_chain(r_2000ib(), np.array([one.joints_rad])).origin[3, 0]
        for one in (from_upper_arm(r_2000ib(), shown), shown)
    )

    assert coupled == pytest.approx(wrist, abs=0.3)  # joints were printed to a thousandth of a degree
    assert np.linalg.norm(as_read - wrist) > 100.0


@pytest.mark.parametrize("sign_3", [1, -1])
def test_what_a_controller_shows_keeps_its_joint_3_while_joint_2_moves_the_forearm_along(sign_3):
    robot = r_2000ib(sign_3)
    joints = [
        from_upper_arm(robot, Configuration((0.1, q, 0.3, 0.0, 0.2, 0.0))).joints_rad for q in (0.0, 0.4)
    ]

    chain = nominal_chain(robot, np.array(joints))

    assert chain.rotation[2, 0] == pytest.approx(chain.rotation[2, 1], abs=1e-12)


def test_there_and_back_again_nothing_has_changed():
    joints = Configuration((0.1, 0.7, -0.3, 0.5, 0.2, 0.9))

    again = from_horizontal(r_2000ib(), from_upper_arm(r_2000ib(), joints))

    assert again.joints_rad == pytest.approx(joints.joints_rad, abs=1e-15)


def test_an_arm_whose_axes_cross_has_no_such_joint():
    rows = list(r_2000ib().joints)
    rows[2] = JointRow(0.5, 1075.0, 0.0, 0.0)

    assert can_be_coupled(r_2000ib())
    assert not can_be_coupled(Robot("crossed", tuple(rows)))
