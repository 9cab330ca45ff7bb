"""Inverse kinematics of any arm: damped Gauss-Newton from many starts at once.

For arms without a closed form. The starts are a Halton sequence, the same every time, so that the same pose
gives the same answer. An arm with more than six joints reaches a pose in
infinitely many ways, of which some are returned.
"""

from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.robot import Robot
from truepose.kinematics.chain import Chain, nominal_chain
from truepose.kinematics.frames import cross, vector_from_rotation

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
    """Return up to eight different joint angles per pose (n, 4, 4), NaN rows after them, shape (n, 8, J)."""
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
        left = left[under_way]
        if not len(left):
            break
    arrived = np.linalg.norm(_error(nominal_chain(robot, joints), goal), axis=1) < _ARRIVED_MM
    wrapped = -(np.mod(np.pi - joints, 2 * np.pi) - np.pi)
    shape = (len(wanted), len(starts))
    return wrapped.reshape(*shape, robot.n_joints), arrived.reshape(shape)


def _starts(joints: int) -> FloatArray:
    """Evenly spread angles, shape (starts, J)."""
    index = np.arange(1, _STARTS + 1)
    columns = [_radical_inverse(index, _PRIMES[joint % len(_PRIMES)]) for joint in range(joints)]
    return (2.0 * np.stack(columns, axis=1) - 1.0) * np.pi


def _radical_inverse(index: IntArray, base: int) -> FloatArray:
    value, share, rest = np.zeros(len(index)), 1.0 / base, index.copy()
    while rest.any():
        value += share * (rest % base)
        rest //= base
        share /= base
    return value


def _error(chain: Chain, wanted: FloatArray) -> FloatArray:
    """Shift [mm] and turn [mm at the lever] that are left to go to poses (n, 4, 4), shape (n, 6)."""
    turn = vector_from_rotation(wanted[:, :3, :3] @ np.swapaxes(chain.end_rotation, 1, 2))
    return np.concatenate([wanted[:, :3, 3] - chain.end_origin, _LEVER_MM * turn], axis=1)


def _signs(robot: Robot) -> FloatArray:
    return np.array([row.sign for row in robot.joints], dtype=float)


def _step(chain: Chain, error: FloatArray, signs: FloatArray) -> FloatArray:
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
    apart: BoolArray = np.abs(np.mod(first - second + np.pi, 2 * np.pi) - np.pi) > _SAME_RAD
    return not bool(apart.any())
