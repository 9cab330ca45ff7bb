r"""Inverse kinematics of the nominal robot: every way in which the arm reaches a pose.

Closed form (Pieper) for six axes of which 2 and 3 are parallel, 1 and 2 perpendicular, and the last three
meet in one point under right angles; other arms by iteration from many starts (`inverse_search`).
With row 1 taken off and `w = (x, y, z)` the wrist point in front of joint 1, above its `d_1`:

    theta_1 : the coordinate of w along axis 2 is a constant m:  y cos - x sin = m
    theta_3 : upper arm a_3 and forearm hypot(a_4, d_4) close the triangle from axis 2 to w
    theta_2 : turns the closed triangle onto w
    theta_4 .. theta_6 : the rotation that is left is RotX RotZ RotX RotZ RotX RotZ

Branches are numbered `4 * back + 2 * down + flip`. *Front*: the wrist lies on that side of axis 1 to which
frame 1 points; *up*: the elbow is above the straight line from shoulder to wrist for an arm on a table that
bends forwards at its zero position; *no flip*: joint 5 at or above 0. Each pair meets in a singularity.

References
----------
D. L. Pieper, The kinematics of manipulators under computer control, PhD thesis, Stanford, 1968.
J. J. Craig, Introduction to Robotics, 3rd ed., 2005, sections 4.4 to 4.6.
"""

from itertools import product
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange, Robot
from truepose.kinematics.frames import rotation_x, rotation_z
from truepose.kinematics.inverse_search import BRANCHES, searched_branches

BRANCH_NAMES: Final = tuple(
    "/".join(words) for words in product(("front", "back"), ("up", "down"), ("no flip", "flip"))
)
_STRUCTURE_RAD: Final = (
    1e-9  # twists this close to a right angle are one; tables are written in whole degrees
)
_STRUCTURE_MM: Final = 1e-9
_STRETCHED: Final = 1e-12  # cosines may pass 1 by rounding where the arm is just stretched
_LOCKED: Final = 1e-10  # sine of joint 5 below which joints 4 and 6 turn about the same line


def has_closed_form(robot: Robot) -> bool:
    """Whether the arm has parallel axes 2 and 3 and a spherical wrist, so that its inverse is exact."""
    if robot.n_joints != 6:
        return False
    rows = robot.joints
    right = all(abs(np.cos(rows[i].alpha_rad)) < _STRUCTURE_RAD for i in (1, 3, 4, 5))
    parallel = abs(np.sin(rows[2].alpha_rad)) < _STRUCTURE_RAD
    offsets = (rows[4].a_mm, rows[5].a_mm, rows[4].d_mm)
    meet = max(abs(value) for value in offsets) < _STRUCTURE_MM
    arm = abs(rows[2].a_mm) > _STRUCTURE_MM and np.hypot(rows[3].a_mm, rows[3].d_mm) > _STRUCTURE_MM
    return bool(right and parallel and meet and arm)


def all_branches(robot: Robot, pose: FloatArray) -> FloatArray:
    """Return the joint angles of every branch that reaches a pose of the last frame.

    Parameters
    ----------
    robot : Robot
        The nominal one; angles are those of its controller, signs and offsets undone.
    pose : ndarray, shape (..., 4, 4)
        Of the frame of the last joint in the robot's base [mm].

    Returns
    -------
    ndarray, shape (..., 8, J)
        Radians in (-pi, pi], joint limits not looked at; NaN rows where a branch does not exist. At a wrist
        singularity joint 4 is 0; with the wrist on axis 1, theta_1 is 0 or -pi. Arms without a closed form:
        the branches that the search finds, at most eight, in no order that has a meaning.

    Raises
    ------
    ConfigurationError
        The pose is no 4 x 4 matrix, or not finite.
    """
    if pose.shape[-2:] != (4, 4) or not np.all(np.isfinite(pose)):
        raise ConfigurationError("A pose is a 4 x 4 matrix with finite entries; check what was passed.")
    flat = pose.reshape(-1, 4, 4)
    found = _closed_form(robot, flat) if has_closed_form(robot) else searched_branches(robot, flat)
    return found.reshape(*pose.shape[:-2], BRANCHES, robot.n_joints)


def equivalents(joints_rad: FloatArray, limits: tuple[JointRange, ...]) -> FloatArray:
    """Return all joint angles that differ by whole turns and lie within the limits.

    Parameters
    ----------
    joints_rad : ndarray, shape (J,)
        NaN for a branch that does not exist.
    limits : tuple of JointRange
        One per joint.

    Returns
    -------
    ndarray, shape (m, J)
        The least turned first; m = 0 where a joint cannot be within its limits.

    Raises
    ------
    ConfigurationError
        There are not as many limits as joints.
    """
    if len(limits) != len(joints_rad):
        raise ConfigurationError(f"{len(limits)} limits are given for {len(joints_rad)} joints.")
    if not np.all(np.isfinite(joints_rad)):
        return np.zeros((0, len(joints_rad)))
    turns = [_whole_turns(float(q), limit) for q, limit in zip(joints_rad, limits, strict=True)]
    rows = sorted(product(*turns), key=lambda row: float(np.sum(np.abs(row))))
    return np.array(rows).reshape(-1, len(joints_rad))


def brought_within(joints_rad: FloatArray, limits: tuple[JointRange, ...]) -> tuple[FloatArray, BoolArray]:
    """Turn joints by whole turns towards the middles of their limits, and say which rows are within.

    Parameters
    ----------
    joints_rad : ndarray, shape (n, J)
    limits : tuple of JointRange

    Returns
    -------
    joints_rad : ndarray, shape (n, J)
    within : ndarray, shape (n,)
        False for rows with NaN.
    """
    low = np.array([limit.lower_rad for limit in limits])
    high = np.array([limit.upper_rad for limit in limits])
    turned = joints_rad - 2 * np.pi * np.round((joints_rad - (low + high) / 2) / (2 * np.pi))
    within: BoolArray = np.all((turned >= low) & (turned <= high), axis=1)
    return turned, within


def _whole_turns(angle_rad: float, limit: JointRange) -> list[float]:
    first = int(np.ceil((limit.lower_rad - angle_rad) / (2 * np.pi)))
    last = int(np.floor((limit.upper_rad - angle_rad) / (2 * np.pi)))
    return [angle_rad + 2 * np.pi * turn for turn in range(first, last + 1)]


def _closed_form(robot: Robot, pose: FloatArray) -> FloatArray:
    """Angles of the eight branches of n poses, shape (n, 8, 6)."""
    first = robot.joints[0]
    tilt = rotation_x(first.alpha_rad)
    rotation = tilt.T @ pose[:, :3, :3]
    wrist = pose[:, :3, 3] - robot.joints[5].d_mm * pose[:, :3, 2]
    wrist = (wrist - np.array([first.a_mm, 0.0, 0.0])) @ tilt - np.array([0.0, 0.0, first.d_mm])
    with np.errstate(divide="ignore", invalid="ignore"):  # NaN is the answer where there is no branch
        branches = [
            _branch(robot, rotation, wrist, back, down, flip)
            for back, down, flip in product((0, 1), repeat=3)
        ]
    return _controller_angles(robot, np.stack(branches, axis=1))


def _branch(
    robot: Robot, rotation: FloatArray, wrist: FloatArray, back: int, down: int, flip: int
) -> FloatArray:
    theta_1 = _column_angle(robot, wrist, back)
    theta_2, theta_3 = _arm_angles(robot, wrist, theta_1, _bends_as_at_zero(back, down))
    forearm = rotation_z(theta_1) @ rotation_x(robot.joints[1].alpha_rad) @ rotation_z(theta_2)
    forearm = forearm @ rotation_x(robot.joints[2].alpha_rad) @ rotation_z(theta_3)
    forearm = forearm @ rotation_x(robot.joints[3].alpha_rad)
    wrist_angles = _wrist_angles(robot, np.swapaxes(forearm, 1, 2) @ rotation, flip)
    return np.stack([theta_1, theta_2, theta_3, *wrist_angles], axis=1)


def _bends_as_at_zero(back: int, down: int) -> bool:
    """Whether the elbow bends as at the zero position: over its head an arm hangs its elbow that way."""
    return back == down


def _column_angle(robot: Robot, wrist: FloatArray, back: int) -> FloatArray:
    upper, elbow, forearm = robot.joints[1:4]
    along_axis_2 = upper.d_mm + np.cos(elbow.alpha_rad) * elbow.d_mm
    along_axis_2 += np.cos(elbow.alpha_rad) * np.cos(forearm.alpha_rad) * forearm.d_mm
    distance = np.hypot(wrist[:, 0], wrist[:, 1])
    on_axis = (distance < _STRUCTURE_MM) & (abs(along_axis_2) < _STRUCTURE_MM)
    share = np.where(on_axis, 0.0, -along_axis_2 / np.sin(upper.alpha_rad) / distance)
    aside = np.arcsin(_rounded(share))
    direction = np.arctan2(wrist[:, 1], wrist[:, 0])
    return np.asarray(direction - np.pi + aside if back else direction - aside)


def _arm_angles(
    robot: Robot, wrist: FloatArray, theta_1: FloatArray, as_at_zero: bool
) -> tuple[FloatArray, FloatArray]:
    upper, elbow, forearm = robot.joints[1:4]
    before_2 = rotation_z(theta_1) @ rotation_x(upper.alpha_rad)
    reach = np.einsum("nji,nj->ni", before_2, wrist)[:, :2] - np.array([upper.a_mm, 0.0])
    side = np.array([forearm.a_mm, -np.sin(forearm.alpha_rad) * forearm.d_mm])
    length, angle = float(np.hypot(*side)), float(np.arctan2(side[1], side[0]))
    cosine = (np.sum(reach**2, axis=1) - elbow.a_mm**2 - length**2) / (2 * elbow.a_mm * length)
    bend = np.arccos(_rounded(cosine)) * (
        _zero_bend(robot, angle) if as_at_zero else -_zero_bend(robot, angle)
    )
    turned = float(np.sign(np.cos(elbow.alpha_rad)))
    inner = np.arctan2(turned * length * np.sin(bend), elbow.a_mm + length * np.cos(bend))
    return np.arctan2(reach[:, 1], reach[:, 0]) - inner, bend - angle


def _zero_bend(robot: Robot, forearm_angle: float) -> float:
    """Sign of the elbow's bend with joint 3 at zero; +1 for an arm that is straight there."""
    return -1.0 if np.sin(robot.joints[2].theta_offset_rad + forearm_angle) < 0.0 else 1.0


def _wrist_angles(robot: Robot, left: FloatArray, flip: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    s_5, s_6 = (float(np.sin(row.alpha_rad)) for row in robot.joints[4:])
    side = _positive_side(robot) * (-1.0 if flip else 1.0)  # sign of sin(theta_5)
    sine = np.hypot(left[:, 0, 2], left[:, 1, 2])
    theta_5 = np.arctan2(side * sine, -left[:, 2, 2] / (s_5 * s_6))
    theta_4 = np.arctan2(left[:, 1, 2] * side * s_6, left[:, 0, 2] * side * s_6)
    theta_4 = np.where(sine < _LOCKED, robot.joints[3].theta_offset_rad, theta_4)
    done = rotation_z(theta_4) @ rotation_x(robot.joints[4].alpha_rad)
    done = done @ rotation_z(theta_5) @ rotation_x(robot.joints[5].alpha_rad)
    last = np.swapaxes(done, 1, 2) @ left
    return theta_4, theta_5, np.arctan2(last[:, 1, 0], last[:, 0, 0])


def _positive_side(robot: Robot) -> float:
    """Sign of sin(theta_5) at a small positive angle of joint 5, its offset included."""
    row = robot.joints[4]
    return 1.0 if np.sin(row.theta_offset_rad + row.sign * 1e-6) > 0.0 else -1.0


def _rounded(ratio: FloatArray) -> FloatArray:
    """Ratios that pass 1 by rounding alone, brought back to it."""
    return np.where(np.abs(np.abs(ratio) - 1.0) < _STRETCHED, np.sign(ratio), ratio)


def _controller_angles(robot: Robot, theta_rad: FloatArray) -> FloatArray:
    sign = np.array([row.sign for row in robot.joints], dtype=float)
    offset = np.array([row.theta_offset_rad for row in robot.joints])
    angle = sign * (theta_rad - offset)
    wrapped: FloatArray = -(np.mod(np.pi - angle, 2 * np.pi) - np.pi)
    wrapped[np.isnan(wrapped).any(axis=2)] = np.nan
    return wrapped
