"""Inverse kinematics of any arm: damped Gauss-Newton from many starts at once.

For arms without a closed form. The starts are the same every time (scrambled nothing: a Halton sequence),
so that the same pose gives the same answer. An arm with more than six joints reaches a pose in
infinitely many ways, of which some are returned.
"""

from typing import Final

import numpy as np

from service.domain.arrays import BoolArray, FloatArray
from service.domain.robot import Robot
from service.kinematics.chain import Chain, nominal_chain
from service.kinematics.frames import cross, vector_from_rotation

BRANCHES: Final = 8
_STARTS: Final = 96
_PASSES: Final = 60
_LEVER_MM: Final = 300.0  # weighs turns against shifts: about the arm's own size
_DAMPING: Final = 1e-3  # of the squared lever per joint; keeps steps short near singularities
_LONGEST_STEP_RAD: Final = 0.5
_ARRIVED_MM: Final = 1e-7  # with turns at the lever; hundred times the rounding of the chain
_SAME_RAD: Final = 1e-4  # two solutions closer than this are one
_PRIMES: Final = (2, 3, 5, 7, 11, 13, 17, 19, 23, 29)


def searched_branches(robot: Robot, pose: FloatArray) -> FloatArray:
    """Return up to eight different joint angles per pose (n, 4, 4), NaN rows after them, shape (n, 8, J)."""
    found = np.full((len(pose), BRANCHES, robot.n_joints), np.nan)
    for row, wanted in enumerate(pose):
        for place, joints in enumerate(_different(_search(robot, wanted))):
            found[row, place] = joints
    return found


def _search(robot: Robot, wanted: FloatArray) -> FloatArray:
    """Joint angles that arrived, each wrapped into (-pi, pi], shape (m, J)."""
    joints = _starts(robot.n_joints)
    for _ in range(_PASSES):
        chain = nominal_chain(robot, joints)
        step = _step(chain, _error(chain, wanted), _signs(robot))
        longest = np.abs(step).max(axis=1, keepdims=True)
        joints = joints + step * np.minimum(1.0, _LONGEST_STEP_RAD / np.maximum(longest, 1e-300))
    arrived = np.linalg.norm(_error(nominal_chain(robot, joints), wanted), axis=1) < _ARRIVED_MM
    wrapped: FloatArray = -(np.mod(np.pi - joints[arrived], 2 * np.pi) - np.pi)
    return wrapped


def _starts(joints: int) -> FloatArray:
    """Evenly spread angles, shape (starts, J)."""
    index = np.arange(1, _STARTS + 1)
    columns = [_radical_inverse(index, _PRIMES[joint % len(_PRIMES)]) for joint in range(joints)]
    return (2.0 * np.stack(columns, axis=1) - 1.0) * np.pi


def _radical_inverse(index: np.ndarray, base: int) -> FloatArray:
    value, share, rest = np.zeros(len(index)), 1.0 / base, index.copy()
    while rest.any():
        value += share * (rest % base)
        rest //= base
        share /= base
    return value


def _error(chain: Chain, wanted: FloatArray) -> FloatArray:
    """Shift [mm] and turn [mm at the lever] that are left to go, shape (n, 6)."""
    turn = vector_from_rotation(wanted[:3, :3] @ np.swapaxes(chain.end_rotation, 1, 2))
    return np.concatenate([wanted[:3, 3] - chain.end_origin, _LEVER_MM * turn], axis=1)


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
    kept: list[FloatArray] = []
    for row in joints:
        if len(kept) < BRANCHES and not any(_same(row, other) for other in kept):
            kept.append(row)
    return kept


def _same(first: FloatArray, second: FloatArray) -> bool:
    apart: BoolArray = np.abs(np.mod(first - second + np.pi, 2 * np.pi) - np.pi) > _SAME_RAD
    return not bool(apart.any())
