"""Damped Newton steps of many arms at once.

Components come first and rows last, as in the chain: six equations are then eliminated by some sixty
operations on whole columns, several times faster than one small system after the other.

References
----------
Y. Nakamura, H. Hanafusa, J. Dyn. Sys. Meas. Control 108, 1986, 163-171 (damping near singularities).
"""

from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.identification.model.evaluation import State
from truepose.kinematics.frames import cross

LEVER_MM: Final = 1000.0  # weighs turns against shifts
_LONGEST_STEP_RAD: Final = 0.3
_DAMPING: Final = 1e-4  # of the squared error: no hindrance once the error is small
_ROUNDING: Final = 1e-13  # of the squared lever: keeps the equations of a singular arm solvable


def damped_steps(state: State, rows: IntArray, error: FloatArray, sign: FloatArray) -> FloatArray:
    """Return what joints have to turn by so that an error goes; of more than six joints, the least turn.

    Parameters
    ----------
    state : State
        At n targets.
    rows : ndarray, shape (m,)
        Of the state.
    error : ndarray, shape (m, 6)
        Shift [mm] and turn [mm at the lever] that are left to go.
    sign : ndarray, shape (J,)
        Of the joints.

    Returns
    -------
    ndarray, shape (m, J)
        Of controller angles, none longer than 0.3 rad.
    """
    jacobian = _jacobian(state, rows, sign)
    damping = _DAMPING * np.minimum((error**2).sum(axis=1), LEVER_MM**2) + _ROUNDING * LEVER_MM**2
    weights = _solved(_normal(jacobian, damping), error.T.copy())
    step = np.einsum("ijn,in->nj", jacobian, weights)
    longest = np.abs(step).max(axis=1, keepdims=True, initial=_LONGEST_STEP_RAD)
    return np.asarray(step * (_LONGEST_STEP_RAD / longest))


def _jacobian(state: State, rows: IntArray, sign: FloatArray) -> FloatArray:
    """Return shifts [mm] and turns [mm at the lever] per angle of each joint, shape (6, J, m)."""
    axes, origins = state.chain.z[:, rows], state.chain.origin[:, rows]
    jacobian = np.empty((6, *axes.shape[:2]))
    jacobian[:3] = np.moveaxis(cross(axes, state.unscaled_mm[rows] - origins), 2, 0)
    np.multiply(np.moveaxis(axes, 2, 0), LEVER_MM, out=jacobian[3:])
    jacobian *= sign[:, None]
    return jacobian


def _normal(jacobian: FloatArray, damping: FloatArray) -> FloatArray:
    """Return J J^T with a damped diagonal, shape (6, 6, m); its upper half is not filled in."""
    normal = np.empty((6, *jacobian.shape[::2]))
    for i, row in enumerate(jacobian):
        np.multiply(row[0], jacobian[: i + 1, 0], out=normal[i, : i + 1])
        for joint in range(1, len(row)):
            normal[i, : i + 1] += row[joint] * jacobian[: i + 1, joint]
        normal[i, i] += damping
    return normal


def _solved(normal: FloatArray, right: FloatArray) -> FloatArray:
    """Solve positive definite equations, of which the lower half counts, (6, 6, m), for (6, m); in place."""
    for k in range(6):
        share = normal[k + 1 :, k] / normal[k, k]
        for i in range(k + 1, 6):
            normal[i, k + 1 : i + 1] -= share[i - k - 1] * normal[k + 1 : i + 1, k]
        right[k + 1 :] -= share * right[k]
    for k in reversed(range(6)):
        for i in range(k + 1, 6):
            right[k] -= normal[i, k] * right[i]
        right[k] /= normal[k, k]
    return right
