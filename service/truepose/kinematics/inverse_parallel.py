"""Closed form for arms whose axes 2, 3 and 4 are parallel, with axis 5 across them (UR and its kin).

With row 1 taken off and `w` the point where axes 5 and 6 meet, in front of joint 1:

    theta_1 : the coordinate of w along axes 2 to 4 is a constant:  y cos - x sin = m
    theta_5 : the angle between axis 6 and axis 4; its sign is the branch of the wrist
    theta_6 : where axis 4 points, seen in the flange frame
    theta_3 : the triangle from axis 2 to axis 4, which lies d_5 behind w along axis 5
    theta_2 : turns the closed triangle onto axis 4
    theta_4 : what is left to axis 5

*Front*: w lies on that side of axis 1 to which the arm is stretched at its zero position; *up*: the elbow is
above the straight line from axis 2 to axis 4 for an arm on a table that reaches to that side; *no flip*:
joint 5 at or above 0. Branches meet where w is as near to axis 1 as it can be (front and back), where the arm
is straight or folded (up and down) and where axis 6 is parallel to axis 4 (flip). There joint 6 is 0, or as
much as axis 4 takes to be within reach.

References
----------
K. P. Hawkins, Analytic inverse kinematics for the Universal Robots UR-5/UR-10 arms, Georgia Tech, 2013.
R. S. Andersen, Kinematics of a UR5, Aalborg University, 2018.
"""

from typing import NamedTuple

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


class _Last(NamedTuple):
    """Axes of the flange frame behind joint 1."""

    x: Vector
    y: Vector


def fits(robot: Robot) -> bool:
    """Say whether the arm is one of these: axes 2, 3, 4 parallel, axes 5 and 6 across, a_5 = a_6 = 0."""
    rows = robot.joints
    right = all(abs(np.cos(rows[i].alpha_rad)) < STRUCTURE_RAD for i in (1, 4, 5))
    parallel = all(abs(np.sin(rows[i].alpha_rad)) < STRUCTURE_RAD for i in (2, 3))
    meet = max(abs(rows[4].a_mm), abs(rows[5].a_mm)) < STRUCTURE_MM
    arm = min(abs(rows[2].a_mm), abs(rows[3].a_mm)) > STRUCTURE_MM
    return bool(right and parallel and meet and arm)


def angles(robot: Robot, wanted: Poses, which: Branches, ratio: Ratio) -> tuple[FloatArray, ...]:
    """Return theta_1 .. theta_6 of some branches; parameters and result as of `inverse_spherical.angles`."""
    # Of a UR the arm at zero is stretched to where frame 1 does not point: what people call front is back in
    # `column_angle`, whose sides are those of frame 1.
    turned_over = _stretched_mm(robot) < 0.0
    theta_1 = column_angle(robot, wanted.wrist_mm, which._replace(back=which.back ^ turned_over), ratio)
    wrist, x_axis, z_axis = (
        turned_back(column(vector), 0.0, theta_1)
        for vector in (wanted.wrist_mm, wanted.x_axis, wanted.z_axis)
    )
    side = positive_side(robot) * np.where(which.flip, -1.0, 1.0)  # sign of sin(theta_5)
    theta_5 = _angle_5(robot, z_axis, side)
    last = _Last(x_axis, _cross(z_axis, x_axis))
    theta_6 = _angle_6(robot, last, side)
    locked = np.hypot(z_axis[0], z_axis[2]) < LOCKED
    if locked.any():
        theta_6 = np.where(locked, _angle_6_within_reach(robot, wrist, last), theta_6)
    plane = _plane_angles(robot, wrist, _axis_5(robot, last, theta_6), which, ratio)
    return theta_1, *plane, theta_5, theta_6


def branches(robot: Robot, theta: FloatArray) -> tuple[BoolArray, BoolArray, BoolArray]:
    """Return in which branch arms are.

    Back is where w, in front of joint 1, is on the other side of axis 1 than the arm at zero; down and flip
    are signs of sin(theta_3) and sin(theta_5). Parameters and result as of `inverse_spherical.branches`.
    """
    upper, elbow, forearm, wrist = robot.joints[1:5]
    along = theta[:, 1] + same_way(robot) * theta[:, 2]
    reach = upper.a_mm + elbow.a_mm * np.cos(theta[:, 1]) + forearm.a_mm * np.cos(along)
    across = np.sin(along + _axis_4(robot) * theta[:, 3])
    reach += wrist.d_mm * np.sin(wrist.alpha_rad) * _axis_4(robot) * across
    back = is_beyond(reach * np.sign(_stretched_mm(robot)), STRUCTURE_MM)
    down = back ^ is_beyond(np.sin(theta[:, 2]) * _bend_upwards(robot), LOCKED)
    return back, down, is_beyond(np.sin(theta[:, 4]) * positive_side(robot), LOCKED)


def _axis_4(robot: Robot) -> float:
    """+1 where axis 4 points the same way as axis 2, else -1."""
    return same_way(robot) * float(np.sign(np.cos(robot.joints[3].alpha_rad)))


def _stretched_mm(robot: Robot) -> float:
    """Return to which side of axis 1 the arm is stretched at its zero position; positive where to neither."""
    upper, elbow, forearm = robot.joints[1:4]
    along = elbow.theta_offset_rad * same_way(robot) + upper.theta_offset_rad
    reach = upper.a_mm + elbow.a_mm * np.cos(upper.theta_offset_rad) + forearm.a_mm * np.cos(along)
    # An arm that stands upright at zero is stretched to neither side: rounding of its offsets must not name
    # one.
    return float(reach) if abs(reach) > 1.0 else 1.0


def _bend_upwards(robot: Robot) -> float:
    """Sign of sin(theta_3) with the elbow up, in front of axis 1."""
    upper, elbow, forearm = robot.joints[1:4]
    above = -np.sin(upper.alpha_rad) * elbow.a_mm * forearm.a_mm * same_way(robot) * _stretched_mm(robot)
    return float(np.sign(above))


def _along_axis_4(robot: Robot, vector: Vector) -> FloatArray:
    """Return the component along axis 4 of a vector behind joint 1."""
    return np.asarray(-_axis_4(robot) * np.sin(robot.joints[1].alpha_rad) * vector[1])


def _angle_5(robot: Robot, z_axis: Vector, side: FloatArray) -> FloatArray:
    """Angle between axes 4 and 6: its sine from the part of axis 6 across axis 4, with the branch's sign."""
    s_5, s_6 = (float(np.sin(row.alpha_rad)) for row in robot.joints[4:])
    return np.arctan2(side * np.hypot(z_axis[0], z_axis[2]), -s_5 * s_6 * _along_axis_4(robot, z_axis))


def _angle_6(robot: Robot, last: _Last, side: FloatArray) -> FloatArray:
    """Direction of axis 4 in the plane of x and y of the flange frame, with the branch's sign."""
    way = float(np.sin(robot.joints[4].alpha_rad)) * side
    x, y = (_along_axis_4(robot, axis) for axis in last)
    return np.arctan2(-way * y, way * x)


def _angle_6_within_reach(robot: Robot, wrist: Vector, last: _Last) -> FloatArray:
    """Return the angle nearest to that of joint 6 at 0 that brings axis 4 within reach of axis 2.

    Of the triangle from axis 2 over w to axis 4 two sides are known, |w| and d_5, and the third shall be one
    that upper arm and forearm can span: |a_3 - a_4| <= t <= a_3 + a_4, clipped from what it is at angle 0. By
    the law of cosines t gives the angle at w.
    """
    elbow, forearm, d_5 = abs(robot.joints[2].a_mm), abs(robot.joints[3].a_mm), robot.joints[4].d_mm
    offset = np.asarray(robot.joints[5].theta_offset_rad)
    x, y = _in_plane(robot, wrist, -robot.joints[1].a_mm)
    u, v = _in_plane(robot, _axis_5(robot, last, offset), 0.0)
    third = np.clip(np.hypot(x - d_5 * u, y - d_5 * v), abs(elbow - forearm), elbow + forearm)
    far = np.hypot(x, y)
    cosine = np.clip((far**2 + d_5**2 - third**2) / np.where(far * d_5, 2 * far * d_5, 1.0), -1.0, 1.0)
    towards, at_zero = np.arctan2(y, x), np.arctan2(v, u)
    angle = towards + np.copysign(np.arccos(cosine), np.sin(at_zero - towards))
    return np.asarray(offset - _axis_4(robot) * _last_axis(robot, last) * (angle - at_zero))


def _last_axis(robot: Robot, last: _Last) -> FloatArray:
    """+1 where axis 6 points the same way as axis 4, else -1; it is parallel to it."""
    return np.sign(_along_axis_4(robot, _cross(last.x, last.y)))


def _in_plane(robot: Robot, vector: Vector, beyond_mm: float) -> tuple[FloatArray, FloatArray]:
    """Return the components across axis 2 of a vector behind joint 1, shifted along x."""
    x, y, _ = turned_back(vector, robot.joints[1].alpha_rad, 0.0)
    return x + beyond_mm, y


def _axis_5(robot: Robot, last: _Last, theta_6: FloatArray) -> Vector:
    """Return axis 5 behind joint 1: s_6 (sin(theta_6) x + cos(theta_6) y) of the flange frame."""
    s_6, sine, cosine = float(np.sin(robot.joints[5].alpha_rad)), np.sin(theta_6), np.cos(theta_6)
    x, y, z = (s_6 * (sine * one + cosine * other) for one, other in zip(*last, strict=True))
    return x, y, z


def _plane_angles(
    robot: Robot, wrist: Vector, axis_5: Vector, which: Branches, ratio: Ratio
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return theta_2 .. theta_4: a triangle in the plane across axis 2, and the direction of axis 5 in it.

    Axis 4 is at p = w - d_5 axis_5, where |p|^2 = a_3^2 + a_4^2 + 2 a_3 a_4 cos(theta_3); theta_4 is what is
    left of the direction of axis 5 once theta_2 and theta_3 have turned it.
    """
    upper, elbow, forearm, last = robot.joints[1:5]
    x, y = _in_plane(robot, wrist, -upper.a_mm)
    u, v = _in_plane(robot, axis_5, 0.0)
    x, y = x - last.d_mm * u, y - last.d_mm * v
    lengths = elbow.a_mm * forearm.a_mm
    cosine = (x**2 + y**2 - elbow.a_mm**2 - forearm.a_mm**2) / (2 * lengths)
    upwards = np.where(which.back == which.down, _bend_upwards(robot), -_bend_upwards(robot))
    theta_3 = np.arccos(ratio(cosine)) * upwards
    aside, along = same_way(robot) * forearm.a_mm * np.sin(theta_3), forearm.a_mm * np.cos(theta_3)
    theta_2 = np.arctan2(y, x) - np.arctan2(aside, elbow.a_mm + along)
    s_5, way = float(np.sin(last.alpha_rad)), _axis_4(robot)
    direction = np.arctan2(s_5 * way * u, -s_5 * way * v)  # of x_4, across axes 4 and 5
    return theta_2, theta_3, way * (direction - theta_2 - same_way(robot) * theta_3)


def _cross(first: Vector, second: Vector) -> Vector:
    (a, b, c), (x, y, z) = first, second
    return b * z - c * y, c * x - a * z, a * y - b * x
