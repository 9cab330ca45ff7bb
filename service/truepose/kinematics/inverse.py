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

import math
from collections.abc import Callable
from itertools import product
from typing import Final, NamedTuple, TypeAlias

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange, Robot
from truepose.kinematics.chain import nominal_values
from truepose.kinematics.frames import rotation_x
from truepose.kinematics.inverse_search import BRANCHES, searched_branches

BRANCH_NAMES: Final = tuple(
    "/".join(words) for words in product(("front", "back"), ("up", "down"), ("no flip", "flip"))
)
_STRUCTURE_RAD: Final = (
    1e-9  # twists this close to a right angle are one; tables are written in whole degrees
)
_STRUCTURE_MM: Final = 1e-9
_STRETCHED: Final = 1e-12  # cosines may pass 1 by rounding where the arm is just stretched
_NEARLY_STRAIGHT: Final = float(np.cos(np.deg2rad(5.0)))  # from a straight arm no step leads inwards
_Vector: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]  # components
_Ratio: TypeAlias = Callable[[FloatArray], FloatArray]  # what to do with cosines and sines beyond 1
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
    untilted = all(abs(row.beta_rad) < _STRUCTURE_RAD for row in rows)
    return bool(right and parallel and meet and arm and untilted)


def all_branches(robot: Robot, pose: FloatArray, *, reach_out: bool = False) -> FloatArray:
    """Return the joint angles of every branch that reaches a pose of the last frame.

    Parameters
    ----------
    robot : Robot
        The nominal one; angles are those of its controller, signs and offsets undone.
    pose : ndarray, shape (..., 4, 4)
        Of the frame of the last joint in the robot's base [mm].
    reach_out : bool, optional
        Where a branch does not exist, stretch or fold the arm towards the pose: somewhere to search from.
        Arms without a closed form do not.

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
    closed = has_closed_form(robot)
    found = _closed_form(robot, flat, _ALL, reach_out) if closed else searched_branches(robot, flat)
    return found.reshape(*pose.shape[:-2], BRANCHES, robot.n_joints)


def one_branch(robot: Robot, pose: FloatArray, branch: IntArray) -> FloatArray:
    """Return the joint angles of one branch of each pose, the arm stretched towards what it does not reach.

    Parameters
    ----------
    robot : Robot
        With a closed form.
    pose : ndarray, shape (n, 4, 4)
        As for `all_branches`.
    branch : ndarray, shape (n,)

    Returns
    -------
    ndarray, shape (n, 6)
    """
    which = _Which(*((branch >> bit & 1)[None, None, None] for bit in (2, 1, 0)))
    return np.asarray(_closed_form(robot, pose, which, reach_out=True)[:, 0])


def branch_of(robot: Robot, joints_rad: FloatArray) -> IntArray:
    """Return the branch of configurations, numbered as those of `all_branches`.

    Parameters
    ----------
    robot : Robot
        With a closed form.
    joints_rad : ndarray, shape (n, 6)

    Returns
    -------
    ndarray, shape (n,)
        In 0..7; in a singularity the lower one of the two that meet there.

    Raises
    ------
    ConfigurationError
        The arm has no closed form, hence no numbered branches.
    """
    if not has_closed_form(robot):
        raise ConfigurationError(f"{robot.name} has no numbered branches: its inverse has no closed form.")
    theta = nominal_values(robot, joints_rad).theta_rad
    length, angle = _forearm(robot)
    bend = theta[:, 2] + angle
    reach = robot.joints[1].a_mm + robot.joints[2].a_mm * np.cos(theta[:, 1])
    reach += length * np.cos(theta[:, 1] + _same_way(robot) * bend)
    back = reach < 0.0
    down = back ^ (np.sin(bend) * _zero_bend(robot) < 0.0)
    flip = np.sin(theta[:, 4]) * _positive_side(robot) < 0.0
    return np.asarray(4 * back + 2 * down + flip, dtype=np.int64)


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


class _Which(NamedTuple):
    """Branches, 0 or 1 each; of shapes that come together to (back, down, flip, poses)."""

    back: IntArray
    down: IntArray
    flip: IntArray


_ALL: Final = _Which(*(np.arange(2).reshape(shape) for shape in ((2, 1, 1, 1), (1, 2, 1, 1), (1, 1, 2, 1))))


def _closed_form(robot: Robot, pose: FloatArray, which: _Which, reach_out: bool) -> FloatArray:
    """Angles of some branches of n poses, shape (n, branches, 6).

    Below, branches come first (back, down, flip) and poses last: (2, 2, 2, n) where all are asked for.
    """
    before_1 = rotation_x(robot.joints[0].alpha_rad)
    x_axis, z_axis = (
        _column(before_1.T @ pose[:, :3, k].T) for k in (0, 2)
    )  # of the wanted frame, in front of joint 1
    wrist = before_1.T @ (pose[:, :3, 3] - robot.joints[5].d_mm * pose[:, :3, 2]).T
    wrist -= before_1.T @ np.array([[robot.joints[0].a_mm], [0.0], [0.0]])
    wrist[2] -= robot.joints[0].d_mm
    with np.errstate(divide="ignore", invalid="ignore"):  # NaN is the answer where there is no branch
        ratio = _within_reach if reach_out else _rounded
        theta_1 = _column_angle(robot, wrist, which, ratio)
        theta_2, theta_3 = _arm_angles(robot, _column(wrist), theta_1, which, ratio)
        arm = (theta_1, theta_2, theta_3)
        wrist_angles = _wrist_angles(
            robot, which, _before_wrist(robot, x_axis, arm), _before_wrist(robot, z_axis, arm)
        )
    angles = np.broadcast_arrays(*arm, *wrist_angles)
    count = math.prod(angles[0].shape[:3])  # of branches
    return _controller_angles(
        robot, np.stack([angle.reshape(count, len(pose)).T for angle in angles], axis=2)
    )


def _column(planes: FloatArray) -> _Vector:
    """Return the components (3, n) of vectors, each (1, 1, 1, n)."""
    x, y, z = (plane[None, None, None] for plane in planes)
    return x, y, z


def _turned_back(vector: _Vector, alpha_rad: float, theta_rad: FloatArray | float) -> _Vector:
    """Return vectors as a frame sees them that RotX(alpha) RotZ(theta) turned."""
    x, y, z = vector
    c, s = float(np.cos(alpha_rad)), float(np.sin(alpha_rad))
    y, z = c * y + s * z, c * z - s * y
    cosine, sine = np.cos(theta_rad), np.sin(theta_rad)
    return cosine * x + sine * y, cosine * y - sine * x, z


def _before_wrist(robot: Robot, vector: _Vector, arm: tuple[FloatArray, FloatArray, FloatArray]) -> _Vector:
    """Return a vector in front of joint 1 as the frame sees it that joint 4 turns."""
    vector = _turned_back(vector, 0.0, arm[0])
    vector = _turned_back(vector, robot.joints[1].alpha_rad, arm[1])
    vector = _turned_back(vector, robot.joints[2].alpha_rad, arm[2])
    return _turned_back(vector, robot.joints[3].alpha_rad, 0.0)


def _column_angle(robot: Robot, wrist: FloatArray, which: _Which, ratio: _Ratio) -> FloatArray:
    """Return theta_1, shape (2, 1, 1, n)."""
    upper, elbow, forearm = robot.joints[1:4]
    along_axis_2 = upper.d_mm + np.cos(elbow.alpha_rad) * elbow.d_mm
    along_axis_2 += np.cos(elbow.alpha_rad) * np.cos(forearm.alpha_rad) * forearm.d_mm
    distance = np.hypot(wrist[0], wrist[1])
    on_axis = (distance < _STRUCTURE_MM) & (abs(along_axis_2) < _STRUCTURE_MM)
    share = np.where(on_axis, 0.0, -along_axis_2 / np.sin(upper.alpha_rad) / distance)
    aside, direction = np.arcsin(ratio(share)), np.arctan2(wrist[1], wrist[0])
    return np.asarray(np.where(which.back, direction - np.pi + aside, direction - aside))


def _arm_angles(
    robot: Robot, wrist: _Vector, theta_1: FloatArray, which: _Which, ratio: _Ratio
) -> tuple[FloatArray, FloatArray]:
    """Return theta_2 and theta_3, shape (2, 2, 1, n)."""
    upper, elbow = robot.joints[1:3]
    x, y, _ = _turned_back(_turned_back(wrist, 0.0, theta_1), upper.alpha_rad, 0.0)
    x = x - upper.a_mm
    length, angle = _forearm(robot)
    cosine = (x**2 + y**2 - elbow.a_mm**2 - length**2) / (2 * elbow.a_mm * length)
    as_at_zero = which.back == which.down  # over its head an arm hangs its elbow as it does at zero
    bend = np.arccos(ratio(cosine)) * np.where(as_at_zero, _zero_bend(robot), -_zero_bend(robot))
    inner = np.arctan2(_same_way(robot) * length * np.sin(bend), elbow.a_mm + length * np.cos(bend))
    return np.arctan2(y, x) - inner, bend - angle


def _forearm(robot: Robot) -> tuple[float, float]:
    """Return the length from axis 3 to the wrist [mm], and its direction in frame 3 [rad]."""
    row = robot.joints[3]
    across = -np.sin(row.alpha_rad) * row.d_mm
    return float(np.hypot(row.a_mm, across)), float(np.arctan2(across, row.a_mm))


def _same_way(robot: Robot) -> float:
    """+1 where axes 2 and 3 point the same way, else -1."""
    return float(np.sign(np.cos(robot.joints[2].alpha_rad)))


def _zero_bend(robot: Robot) -> float:
    """Sign of the elbow's bend with joint 3 at zero; +1 for an arm that is straight there."""
    return -1.0 if np.sin(robot.joints[2].theta_offset_rad + _forearm(robot)[1]) < 0.0 else 1.0


def _wrist_angles(robot: Robot, which: _Which, x_axis: _Vector, z_axis: _Vector) -> _Vector:
    """Return theta_4 .. theta_6, shape (2, 2, 2, n), from axes as the frame sees them that joint 4 turns."""
    s_5, s_6 = (float(np.sin(row.alpha_rad)) for row in robot.joints[4:])
    side = _positive_side(robot) * np.where(which.flip, -1.0, 1.0)  # sign of sin(theta_5)
    sine = np.hypot(z_axis[0], z_axis[1])
    theta_5 = np.arctan2(side * sine, -z_axis[2] / (s_5 * s_6))
    theta_4 = np.arctan2(z_axis[1] * side * s_6, z_axis[0] * side * s_6)
    theta_4 = np.where(sine < _LOCKED, robot.joints[3].theta_offset_rad, theta_4)
    last = _turned_back(x_axis, 0.0, theta_4)
    last = _turned_back(last, robot.joints[4].alpha_rad, theta_5)
    last = _turned_back(last, robot.joints[5].alpha_rad, 0.0)
    return theta_4, theta_5, np.arctan2(last[1], last[0])


def _positive_side(robot: Robot) -> float:
    """Sign of sin(theta_5) at a small positive angle of joint 5, its offset included."""
    row = robot.joints[4]
    return 1.0 if np.sin(row.theta_offset_rad + row.sign * 1e-6) > 0.0 else -1.0


def _rounded(ratio: FloatArray) -> FloatArray:
    """Ratios that pass 1 by rounding alone, brought back to it."""
    return np.where(np.abs(np.abs(ratio) - 1.0) < _STRETCHED, np.sign(ratio), ratio)


def _within_reach(ratio: FloatArray) -> FloatArray:
    """Ratios of reachable poses as they are, others brought to an arm that is nearly straight or folded."""
    return np.where(np.abs(ratio) < 1.0, ratio, np.sign(ratio) * _NEARLY_STRAIGHT)


def _controller_angles(robot: Robot, theta_rad: FloatArray) -> FloatArray:
    sign = np.array([row.sign for row in robot.joints], dtype=float)
    offset = np.array([row.theta_offset_rad for row in robot.joints])
    angle = sign * (theta_rad - offset)
    wrapped: FloatArray = -(np.mod(np.pi - angle, 2 * np.pi) - np.pi)
    wrapped[np.isnan(wrapped).any(axis=2)] = np.nan
    return wrapped
