"""Inverse kinematics of the nominal robot: every way in which the arm reaches a pose.

Closed forms for six axes with a spherical wrist (`inverse_spherical`) and for three parallel axes without one
(`inverse_parallel`). For other arms a search: damped Gauss-Newton from many starts at once,

    q <- q + (J^T J + lambda 1)^-1 J^T e,     e = (shift, L turn) from the attained pose to the wanted one,

with the geometric Jacobian J of the nominal chain, turns weighed by the lever L, and lambda proportional to
|e| far from the goal. The starts are a Halton sequence, the same every time, so that the same pose gives the
same answer. An arm with more than six joints reaches a pose in infinitely many ways, of which some are
returned.

Branches are numbered `4 * back + 2 * down + flip`. *Front*: the wrist lies on that side of axis 1 to which
frame 1 points, of three parallel axes to which the arm is stretched at zero; *up*: the elbow is above the
straight line from shoulder to wrist for an arm on a table that bends forwards at its zero position; *no
flip*: joint 5 at or above 0. Each pair meets in a singularity.

References
----------
Y. Nakamura, H. Hanafusa, J. Dyn. Sys. Meas. Control 108, 1986, 163-171 (damping near singularities).
J. H. Halton, Numerische Mathematik 2, 1960, 84-90 (starts).
"""

import math
from itertools import product
from typing import Final, Protocol

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange, Robot
from truepose.kinematics import inverse_parallel, inverse_spherical
from truepose.kinematics.chain import Chain, nominal_chain, nominal_values
from truepose.kinematics.frames import cross, rotation_x, vector_from_rotation
from truepose.kinematics.inverse_parts import (
    ALL,
    STRUCTURE_RAD,
    Branches,
    Poses,
    Ratio,
    clip_rounding,
    within_reach,
)

BRANCHES: Final = 8
_STARTS: Final = 64
_PASSES: Final = 40
_LEVER_MM: Final = 300.0  # weighs turns against shifts: about the arm's own size
_DAMPING: Final = 1e-3  # of the squared lever per joint; keeps steps short near singularities
_LONGEST_STEP_RAD: Final = 0.5
_ARRIVED_MM: Final = 1e-7  # with turns at the lever; hundred times the rounding of the chain
_SAME_RAD: Final = 1e-4  # two solutions closer than this are one
_AT_ONCE: Final = 64  # poses that are searched together; a few megabytes
_PRIMES: Final = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29)


def searched_branches(robot: Robot, pose: FloatArray) -> FloatArray:
    """Search up to eight different answers per pose, of any arm of revolute joints.

    Parameters
    ----------
    robot : Robot
        With J joints.
    pose : ndarray, shape (n, 4, 4)
        Of the flange frame in the robot's base [mm].

    Returns
    -------
    ndarray, shape (n, 8, J)
        [rad] in (-pi, pi], joint limits not looked at; NaN rows behind the last answer.
    """
    # In parts: each pose is 64 starts, and their frames and Jacobians are all held at once.
    found = np.full((len(pose), BRANCHES, robot.n_joints), np.nan)
    for first in range(0, len(pose), _AT_ONCE):
        part = pose[first : first + _AT_ONCE]
        joints, arrived = _search(robot, part)
        for row in range(len(part)):
            for place, angles in enumerate(_different(joints[row][arrived[row]])):
                found[first + row, place] = angles
    return found


def _search(robot: Robot, wanted: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Where each start of each pose ended, wrapped, (n, starts, J), and whether it arrived, (n, starts)."""
    starts = _starts(robot.n_joints)
    joints = np.tile(starts, (len(wanted), 1))
    goal = np.repeat(wanted, len(starts), axis=0)
    left = np.arange(len(joints))
    for _ in range(_PASSES):
        chain = nominal_chain(robot, joints[left])
        error = _error(chain, goal[left])
        under_way = np.linalg.norm(error, axis=1) >= _ARRIVED_MM
        step = _step(chain, error, _signs(robot))
        longest = np.abs(step).max(axis=1, keepdims=True)
        joints[left] += step * np.minimum(1.0, _LONGEST_STEP_RAD / np.maximum(longest, 1e-300))
        # Rows that have arrived keep the step that was worked out with all others: it can only bring them
        # nearer.
        left = left[under_way]
        if not len(left):
            break
    # Judged anew at the end: a row that was still under way in the last pass may have arrived by its step.
    arrived = np.linalg.norm(_error(nominal_chain(robot, joints), goal), axis=1) < _ARRIVED_MM
    # The other way round than usual: an angle of exactly half a turn is told as +pi, never as -pi.
    wrapped = -(np.mod(np.pi - joints, 2 * np.pi) - np.pi)
    shape = (len(wanted), len(starts))
    return wrapped.reshape(*shape, robot.n_joints), arrived.reshape(shape)


def _starts(joints: int) -> FloatArray:
    """Evenly spread angles, shape (starts, J), in (-pi, pi): a Halton sequence, one prime for each joint."""
    index = np.arange(1, _STARTS + 1)
    columns = [_radical_inverse(index, _PRIMES[joint % len(_PRIMES)]) for joint in range(joints)]
    return (2.0 * np.stack(columns, axis=1) - 1.0) * np.pi


def _radical_inverse(index: IntArray, base: int) -> FloatArray:
    """Digits of whole numbers in a base, mirrored at the point: sum of digit_k base^-(k+1), in [0, 1)."""
    value, share, rest = np.zeros(len(index)), 1.0 / base, index.copy()
    while rest.any():
        value += share * (rest % base)
        rest //= base
        share /= base
    return value


def _error(chain: Chain, wanted: FloatArray) -> FloatArray:
    """Shift [mm] and turn [mm at the lever] that are left to go to poses (n, 4, 4), shape (n, 6)."""
    # Along the axes of the base, in which the chain tells the axes that the Jacobian is made from.
    turn = vector_from_rotation(wanted[:, :3, :3] @ np.swapaxes(chain.end_rotation, 1, 2))
    return np.concatenate([wanted[:, :3, 3] - chain.end_origin, _LEVER_MM * turn], axis=1)


def _signs(robot: Robot) -> FloatArray:
    return np.array([row.sign for row in robot.joints], dtype=float)


def _step(chain: Chain, error: FloatArray, signs: FloatArray) -> FloatArray:
    """Damped Gauss-Newton step of joint angles, shape (n, J) [rad], for an error (n, 6) at the lever."""
    shift = cross(chain.z, chain.end_origin - chain.origin)
    jacobian = np.moveaxis(np.concatenate([shift, _LEVER_MM * chain.z], axis=2), 0, 2) * signs
    damping = _DAMPING * np.minimum(1.0, np.linalg.norm(error, axis=1) / _LEVER_MM) * _LEVER_MM**2
    transposed = np.swapaxes(jacobian, 1, 2)
    normal = transposed @ jacobian
    # damping vanishes with the error, so that the last steps are Newton's; 1e-9 keeps singular ones solvable
    normal += (damping + 1e-9 * _LEVER_MM**2)[:, None, None] * np.eye(jacobian.shape[2])
    return np.asarray(np.linalg.solve(normal, transposed @ error[:, :, None])[:, :, 0])


def _different(joints: FloatArray) -> list[FloatArray]:
    """Return the first of every group of joint angles (m, J) that are the same."""
    kept: list[FloatArray] = []
    for row in joints:
        if len(kept) < BRANCHES and not any(_same(row, other) for other in kept):
            kept.append(row)
    return kept


def _same(first: FloatArray, second: FloatArray) -> bool:
    """Say whether two configurations are one, whole turns of each joint aside."""
    apart: BoolArray = np.abs(np.mod(first - second + np.pi, 2 * np.pi) - np.pi) > _SAME_RAD
    return not bool(apart.any())


BRANCH_NAMES: Final = tuple(
    "/".join(words) for words in product(("front", "back"), ("up", "down"), ("no flip", "flip"))
)


class _Form(Protocol):
    """A closed form: which arms it is for (`fits`), all branches of theirs, and in which one joints are.

    `angles` gives theta_1 .. theta_6 of shapes that broadcast to (back, down, flip, n); `branches` takes them
    as (n, 6) and says whether each arm is back, down and flipped.
    """

    def fits(self, robot: Robot) -> bool: ...

    def angles(
        self, robot: Robot, wanted: Poses, which: Branches, ratio: Ratio
    ) -> tuple[FloatArray, ...]: ...

    def branches(self, robot: Robot, theta: FloatArray) -> tuple[BoolArray, BoolArray, BoolArray]: ...


_FORMS: Final[tuple[_Form, ...]] = (inverse_spherical, inverse_parallel)


def has_closed_form(robot: Robot) -> bool:
    """Say whether the inverse is exact, with branches that have numbers.

    Parameters
    ----------
    robot : Robot
    """
    return _form_of(robot) is not None


def _form_of(robot: Robot) -> _Form | None:
    # Both forms are worked out for tables as makers write them: a tilted axis, however little, has no such
    # wrist.
    untilted = all(abs(row.beta_rad) < STRUCTURE_RAD for row in robot.joints)
    usual = robot.n_joints == 6 and untilted
    return next((form for form in _FORMS if usual and form.fits(robot)), None)


def all_branches(robot: Robot, pose: FloatArray, *, reach_out: bool = False) -> FloatArray:
    """Return the joint angles of every branch that reaches a pose of the flange frame.

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
        singularity joint 4 is 0, of three parallel axes joint 6; with the wrist on axis 1, theta_1 is 0 or
        -pi. Arms without a closed form: the branches that the search finds, at most eight, in no order that
        has a meaning.

    Raises
    ------
    ConfigurationError
        The pose is no 4 x 4 matrix, or not finite.
    """
    if pose.shape[-2:] != (4, 4) or not np.all(np.isfinite(pose)):
        raise ConfigurationError("A pose must be a 4 x 4 matrix with finite entries.")
    flat = pose.reshape(-1, 4, 4)
    form = _form_of(robot)
    found = (
        searched_branches(robot, flat)
        if form is None
        else _closed_form(form, robot, flat, ALL, reach_out=reach_out)
    )
    return found.reshape(*pose.shape[:-2], BRANCHES, robot.n_joints)


def one_branch(robot: Robot, pose: FloatArray, branch: IntArray) -> FloatArray:
    """Return the joint angles of one branch of each pose, the arm stretched towards what it does not reach.

    Parameters
    ----------
    robot : Robot
        With a closed form.
    pose : ndarray, shape (n, 4, 4)
        As for `all_branches`, but not checked: NaN in a pose is NaN in its angles.
    branch : ndarray of int, shape (n,)
        In 0..7.

    Returns
    -------
    ndarray, shape (n, 6)
        [rad], as of `all_branches`.

    Raises
    ------
    ConfigurationError
        The arm has no closed form, hence no numbered branches.
    """
    form = _numbered_form(robot)
    # Bits of the number, each on its own axis of length 1: the closed forms then work out this branch alone,
    # an eighth of the work of all of them.
    which = Branches(*((branch >> bit & 1)[None, None, None] for bit in (2, 1, 0)))
    return np.asarray(_closed_form(form, robot, pose, which, reach_out=True)[:, 0])


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
    form = _numbered_form(robot)
    # From the angles, not from a pose: at given joints the branch is read off the sides of the arm's
    # triangle, and no inverse has to be compared.
    back, down, flip = form.branches(robot, nominal_values(robot, joints_rad).theta_rad)
    return np.asarray(4 * back + 2 * down + flip, dtype=np.int64)


def check_branches(robot: Robot, branch: IntArray) -> None:
    """Refuse numbers of branches that an arm does not have.

    Parameters
    ----------
    robot : Robot
    branch : ndarray of int, shape (n,)

    Raises
    ------
    ConfigurationError
        The arm has no closed form, hence no numbered branches; or a number is not in 0..7.
    """
    if not len(branch):
        return
    _numbered_form(robot)
    unknown = branch[(branch < 0) | (branch >= BRANCHES)]
    if len(unknown):
        raise ConfigurationError(
            f"Branch {int(unknown[0])} is unknown: branches are numbered from 0 to {BRANCHES - 1}."
        )


def brought_within(joints_rad: FloatArray, limits: tuple[JointRange, ...]) -> tuple[FloatArray, BoolArray]:
    """Turn joints by whole turns towards the middles of their limits, and say which rows are within.

    A range of more than one turn holds several of the same attitude: the one nearest to its middle is chosen.

    Parameters
    ----------
    joints_rad : ndarray, shape (n, J)
    limits : tuple of JointRange
        J of them.

    Returns
    -------
    joints_rad : ndarray, shape (n, J)
    within : ndarray of bool, shape (n,)
        False for rows with NaN.
    """
    low = np.array([limit.lower_rad for limit in limits])
    high = np.array([limit.upper_rad for limit in limits])
    # The middle and not zero: ranges of several turns, or all on one side of zero, hold their angles nearest
    # to it.
    turned = joints_rad - 2 * np.pi * np.round((joints_rad - (low + high) / 2) / (2 * np.pi))
    within: BoolArray = np.all((turned >= low) & (turned <= high), axis=1)
    return turned, within


def _numbered_form(robot: Robot) -> _Form:
    """Return the closed form of an arm; raises ConfigurationError where it has none."""
    form = _form_of(robot)
    if form is None:
        raise ConfigurationError(
            f"{robot.name} has no numbered branches: its inverse kinematics has no closed form."
        )
    return form


def _closed_form(
    form: _Form, robot: Robot, pose: FloatArray, which: Branches, *, reach_out: bool
) -> FloatArray:
    """Angles of some branches of n poses, shape (n, branches, 6)."""
    # A pose out of reach is no exception: of eight branches some are always missing, and all are worked out
    # at once.
    with np.errstate(divide="ignore", invalid="ignore"):  # NaN is the answer where there is no branch
        theta = form.angles(robot, _wanted(robot, pose), which, within_reach if reach_out else clip_rounding)
    angles = np.broadcast_arrays(*theta)
    count = math.prod(angles[0].shape[:3])  # of branches
    return _controller_angles(
        robot, np.stack([angle.reshape(count, len(pose)).T for angle in angles], axis=2)
    )


def _wanted(robot: Robot, pose: FloatArray) -> Poses:
    """Return what n poses ask of the joints, in the frame that joint 1 turns.

    Row 1 is RotX(alpha_1) TransX(a_1) RotZ(theta_1) TransZ(d_1): its alpha, a and d are taken off here, so
    that the forms begin with theta_1. The wrist is d_6 behind the origin of the flange frame along axis 6.
    """
    first = robot.joints[0]
    before_1 = rotation_x(first.alpha_rad)
    x_axis, z_axis = (before_1.T @ pose[:, :3, k].T for k in (0, 2))
    wrist = before_1.T @ (pose[:, :3, 3] - robot.joints[5].d_mm * pose[:, :3, 2]).T
    wrist -= before_1.T @ np.array([[first.a_mm], [0.0], [0.0]])
    wrist[2] -= first.d_mm
    return Poses(x_axis, z_axis, wrist)


def _controller_angles(robot: Robot, theta_rad: FloatArray) -> FloatArray:
    """Return angles q of theta = sign q + offset, wrapped to (-pi, pi]; a row with one NaN is NaN."""
    sign = np.array([row.sign for row in robot.joints], dtype=float)
    offset = np.array([row.theta_offset_rad for row in robot.joints])
    angle = sign * (theta_rad - offset)
    wrapped: FloatArray = -(np.mod(np.pi - angle, 2 * np.pi) - np.pi)
    # Half an answer is none: theta_1 of a branch may exist where its elbow does not.
    wrapped[np.isnan(wrapped).any(axis=2)] = np.nan
    return wrapped
