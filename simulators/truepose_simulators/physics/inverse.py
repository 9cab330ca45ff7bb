"""Joint angles for a pose of the nominal arm, found from where the arm stands (a controller's MoveL)."""

import numpy as np

from truepose_simulators.errors import SimulatorError
from truepose_simulators.physics.arm import Arm
from truepose_simulators.physics.chain import Bodies, place_bodies
from truepose_simulators.physics.rigid import FloatArray, to_rotation_vector

_MOST_STEPS = 60
_LONGEST_STEP_RAD = 0.2  # Newton leaps across branches when the start is far
_CLOSE_MM = 1e-7
_CLOSE_RAD = 1e-10


class UnreachableError(SimulatorError):
    """No configuration near the present one reaches the pose."""


def reach(arm: Arm, last_frame: FloatArray, start_rad: FloatArray) -> FloatArray:
    """Return joint angles that place the nominal last frame, by Newton steps from `start_rad`.

    Parameters
    ----------
    arm : Arm
    last_frame : ndarray, shape (4, 4)
        Wanted placement [mm].
    start_rad : ndarray, shape (J,)

    Raises
    ------
    UnreachableError
        The steps do not arrive: out of reach, singular or too far away.
    """
    joints = start_rad.copy()
    no_errors = np.broadcast_to(np.eye(4), (arm.n_joints + 2, 4, 4))
    for _ in range(_MOST_STEPS):
        bodies = place_bodies(arm, no_errors, joints[np.newaxis])
        missing = _missing(bodies.last_frame[0], last_frame)
        if np.all(np.abs(missing[:3]) < _CLOSE_MM) and np.all(np.abs(missing[3:]) < _CLOSE_RAD):
            return joints
        step = np.linalg.lstsq(_jacobian(bodies), missing, rcond=1e-9)[0]
        joints = joints + step * min(1.0, _LONGEST_STEP_RAD / max(float(np.max(np.abs(step))), 1e-12))
    raise UnreachableError("no configuration near the present one reaches the pose")


def _missing(present: FloatArray, wanted: FloatArray) -> FloatArray:
    """Return translation [mm] and rotation vector [rad] from present to wanted frame, shape (6,)."""
    turn = to_rotation_vector(wanted[:3, :3] @ present[:3, :3].T)
    return np.concatenate([wanted[:3, 3] - present[:3, 3], turn])


def _jacobian(bodies: Bodies) -> FloatArray:
    """Motion of the last frame per joint angle, shape (6, J)."""
    directions = bodies.axis_directions[0]
    levers = bodies.last_frame[0, :3, 3] - bodies.axis_points_mm[0]
    return np.concatenate([np.cross(directions, levers), directions], axis=1).T
