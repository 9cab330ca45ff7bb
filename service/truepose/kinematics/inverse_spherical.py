r"""Closed form (Pieper) for arms with parallel axes 2 and 3 and three last axes that meet under right angles.

With row 1 taken off and `w = (x, y, z)` the wrist point in front of joint 1, above its `d_1`:

    theta_1 : the coordinate of w along axis 2 is a constant m:  y cos - x sin = m
    theta_3 : upper arm a_3 and forearm hypot(a_4, d_4) close the triangle from axis 2 to w
    theta_2 : turns the closed triangle onto w
    theta_4 .. theta_6 : the rotation that is left is RotX RotZ RotX RotZ RotX RotZ

References
----------
D. L. Pieper, The kinematics of manipulators under computer control, PhD thesis, Stanford, 1968.
J. J. Craig, Introduction to Robotics, 3rd ed., 2005, sections 4.4 to 4.6.
"""

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.robot import Robot
from truepose.kinematics.inverse_parts import (
    LOCKED,
    STRUCTURE_MM,
    STRUCTURE_RAD,
    Branches,
    Poses,
    Ratio,
    Vector,
    column,
    column_angle,
    is_beyond,
    positive_side,
    same_way,
    turned_back,
)


def fits(robot: Robot) -> bool:
    """Say whether the arm is one of these: axes 2, 4, 5, 6 at right angles, 3 parallel to 2, a wrist."""
    rows = robot.joints
    right = all(abs(np.cos(rows[i].alpha_rad)) < STRUCTURE_RAD for i in (1, 3, 4, 5))
    parallel = abs(np.sin(rows[2].alpha_rad)) < STRUCTURE_RAD
    offsets = (rows[4].a_mm, rows[5].a_mm, rows[4].d_mm)
    meet = max(abs(value) for value in offsets) < STRUCTURE_MM
    arm = abs(rows[2].a_mm) > STRUCTURE_MM and np.hypot(rows[3].a_mm, rows[3].d_mm) > STRUCTURE_MM
    return bool(right and parallel and meet and arm)


def angles(robot: Robot, wanted: Poses, which: Branches, ratio: Ratio) -> tuple[FloatArray, ...]:
    """Return theta_1 .. theta_6 of some branches.

    Parameters
    ----------
    robot : Robot
        One that `fits`.
    wanted : Poses
        n of them.
    which : Branches
    ratio : callable
        What to do with sines and cosines beyond 1.

    Returns
    -------
    tuple of six ndarray
        [rad], of shapes that broadcast to (back, down, flip, n); NaN where there is no branch.
    """
    theta_1 = column_angle(robot, wanted.wrist_mm, which, ratio)
    theta_2, theta_3 = _arm_angles(robot, column(wanted.wrist_mm), theta_1, which, ratio)
    arm = (theta_1, theta_2, theta_3)
    x_axis, z_axis = (_before_wrist(robot, column(axis), arm) for axis in (wanted.x_axis, wanted.z_axis))
    return *arm, *_wrist_angles(robot, which, x_axis, z_axis)


def branches(robot: Robot, theta: FloatArray) -> tuple[BoolArray, BoolArray, BoolArray]:
    """Return in which branch arms are.

    Back is where the wrist's distance from axis 1, along frame 1, is negative; down and flip are the signs of
    sin(bend) and sin(theta_5) against those of the zero position.

    Parameters
    ----------
    robot : Robot
    theta : ndarray, shape (n, 6)
        theta_1 .. theta_6 [rad], offsets and signs in them.

    Returns
    -------
    back, down, flip : ndarray of bool, shape (n,)
    """
    length, angle = _forearm(robot)
    bend = theta[:, 2] + angle
    reach = robot.joints[1].a_mm + robot.joints[2].a_mm * np.cos(theta[:, 1])
    reach += length * np.cos(theta[:, 1] + same_way(robot) * bend)
    back = is_beyond(reach, STRUCTURE_MM)
    down = back ^ is_beyond(np.sin(bend) * _zero_bend(robot), LOCKED)
    return back, down, is_beyond(np.sin(theta[:, 4]) * positive_side(robot), LOCKED)


def _before_wrist(robot: Robot, vector: Vector, arm: tuple[FloatArray, FloatArray, FloatArray]) -> Vector:
    """Return a vector in front of joint 1 as the frame sees it that joint 4 turns."""
    vector = turned_back(vector, 0.0, arm[0])
    vector = turned_back(vector, robot.joints[1].alpha_rad, arm[1])
    vector = turned_back(vector, robot.joints[2].alpha_rad, arm[2])
    return turned_back(vector, robot.joints[3].alpha_rad, 0.0)


def _arm_angles(
    robot: Robot, wrist: Vector, theta_1: FloatArray, which: Branches, ratio: Ratio
) -> tuple[FloatArray, FloatArray]:
    """Return theta_2 and theta_3, shape (2, 2, 1, n).

    Of the triangle axis 2 - axis 3 - wrist all sides are known: |w|^2 = a_3^2 + l^2 + 2 a_3 l cos(bend), with
    l the forearm; bend is theta_3 and the forearm's own direction in frame 3.
    """
    upper, elbow = robot.joints[1:3]
    x, y, _ = turned_back(turned_back(wrist, 0.0, theta_1), upper.alpha_rad, 0.0)
    x = x - upper.a_mm
    length, angle = _forearm(robot)
    cosine = (x**2 + y**2 - elbow.a_mm**2 - length**2) / (2 * elbow.a_mm * length)
    as_at_zero = which.back == which.down  # over its head an arm hangs its elbow as it does at zero
    bend = np.arccos(ratio(cosine)) * np.where(as_at_zero, _zero_bend(robot), -_zero_bend(robot))
    inner = np.arctan2(same_way(robot) * length * np.sin(bend), elbow.a_mm + length * np.cos(bend))
    return np.arctan2(y, x) - inner, bend - angle


def _forearm(robot: Robot) -> tuple[float, float]:
    """Return the length from axis 3 to the wrist [mm], and its direction in frame 3 [rad]."""
    row = robot.joints[3]
    across = -np.sin(row.alpha_rad) * row.d_mm
    return float(np.hypot(row.a_mm, across)), float(np.arctan2(across, row.a_mm))


def _zero_bend(robot: Robot) -> float:
    """Sign of the elbow's bend with joint 3 at zero; +1 for an arm that is straight there."""
    return -1.0 if np.sin(robot.joints[2].theta_offset_rad + _forearm(robot)[1]) < 0.0 else 1.0


def _wrist_angles(robot: Robot, which: Branches, x_axis: Vector, z_axis: Vector) -> Vector:
    """Return theta_4 .. theta_6, shape (2, 2, 2, n), from axes as the frame sees them that joint 4 turns.

    With s_5, s_6 = sin(alpha_5), sin(alpha_6) = +-1, the wanted axis 6 in that frame is
    z = (s_6 c_4 s_5', s_6 s_4 s_5', -s_5 s_6 c_5'), c_5', s_5' those of theta_5: theta_5 from the length of
    its first two components, whose sign is the branch, theta_4 from their direction, theta_6 from the x axis
    then.
    """
    s_5, s_6 = (float(np.sin(row.alpha_rad)) for row in robot.joints[4:])
    side = positive_side(robot) * np.where(which.flip, -1.0, 1.0)  # sign of sin(theta_5)
    sine = np.hypot(z_axis[0], z_axis[1])
    # From sine and cosine together: an arc cosine alone loses half of its digits where the wrist is nearly
    # straight.
    theta_5 = np.arctan2(side * sine, -z_axis[2] / (s_5 * s_6))
    theta_4 = np.arctan2(z_axis[1] * side * s_6, z_axis[0] * side * s_6)
    # Axes 4 and 6 turn about one line: only their sum is asked for, and joint 4 stays at its zero.
    theta_4 = np.where(sine < LOCKED, robot.joints[3].theta_offset_rad, theta_4)
    last = turned_back(x_axis, 0.0, theta_4)
    last = turned_back(last, robot.joints[4].alpha_rad, theta_5)
    last = turned_back(last, robot.joints[5].alpha_rad, 0.0)
    return theta_4, theta_5, np.arctan2(last[1], last[0])
