"""What a controller computes of its nominal arm: FANUC's count of joints, inverse kinematics, straight lines.

The controller counts by inclinations: joint 2 is how far the upper arm leans forward, joint 3 how far the
forearm points up, whatever joint 2 does. Both come here from the directions of the links; joints 4 to 6 turn
the other way round than the drawing's axes. Its world has its origin at the height of axis 2.
"""

import math

import numpy as np

from truepose_simulators.cell.robot import nominal_bodies
from truepose_simulators.errors import SimulatorError
from truepose_simulators.physics.arm import Arm, Bodies
from truepose_simulators.physics.rigid import (
    FloatArray,
    from_quaternion,
    motion,
    to_quaternion,
    to_rotation_vector,
)

_WRIST_TURNS = np.array([-1.0, -1.0, -1.0])


def displayed_deg(joints_rad: FloatArray) -> FloatArray:
    """Return the joints as the pendant shows them, (6,) [deg]."""
    leaning_rad, bent_rad = joints_rad[1], joints_rad[2]
    pitch_of_forearm_rad = leaning_rad + bent_rad  # about the axis to the left: down is positive
    shown: FloatArray = np.degrees([
        joints_rad[0],
        leaning_rad,
        -pitch_of_forearm_rad,
        *(_WRIST_TURNS * joints_rad[3:]),
    ])
    return shown


def joints_rad(shown: FloatArray) -> FloatArray:
    """Return the joints of the drawing that the pendant shows so, (6,) [deg] -> [rad]."""
    first, leaning, pointing_up = np.radians(shown[:3])
    bent = -pointing_up - leaning
    return np.array([first, leaning, bent, *(_WRIST_TURNS * np.radians(shown[3:]))])


def world(arm: Arm) -> FloatArray:
    """Return the controller's world in the frame of the drawing, shape (4, 4)."""
    return motion(np.array([0.0, 0.0, arm.joints[1].point_mm[2]]), np.eye(3))


def flange_angles_deg(rotation: FloatArray) -> tuple[float, float, float]:
    """Return W, P, R of a rotation Rz(R) Ry(P) Rx(W)."""
    p = math.atan2(-rotation[2, 0], math.hypot(rotation[0, 0], rotation[1, 0]))
    if math.isclose(abs(rotation[2, 0]), 1.0, abs_tol=1e-12):  # only W and R together count: R is 0
        w, r = math.atan2(-rotation[1, 2], rotation[1, 1]), 0.0
    else:
        w = math.atan2(rotation[2, 1], rotation[2, 2])
        r = math.atan2(rotation[1, 0], rotation[0, 0])
    return math.degrees(w), math.degrees(p), math.degrees(r)


def rotation_of(w_deg: float, p_deg: float, r_deg: float) -> FloatArray:
    """Return Rz(R) Ry(P) Rx(W), shape (3, 3)."""
    (cw, sw), (cp, sp), (cr, sr) = (
        (math.cos(angle), math.sin(angle)) for angle in map(math.radians, (w_deg, p_deg, r_deg))
    )
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cw, -sw], [0.0, sw, cw]])
    about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    about_z = np.array([[cr, -sr, 0.0], [sr, cr, 0.0], [0.0, 0.0, 1.0]])
    product: FloatArray = about_z @ about_y @ about_x
    return product


_MOST_STEPS = 60
_LONGEST_STEP_RAD = 0.2  # Newton leaps across branches when the start is far
_CLOSE_MM = 1e-7
_CLOSE_RAD = 1e-10


class UnreachableError(SimulatorError):
    """No configuration near the current one reaches the pose."""


def reach(arm: Arm, last_frame: FloatArray, start_rad: FloatArray) -> FloatArray:
    """Return joint angles that place the nominal flange frame, by Newton steps from `start_rad`.

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
    for _ in range(_MOST_STEPS):
        bodies = nominal_bodies(arm, joints[np.newaxis])
        missing = _missing(bodies.last_frame[0], last_frame)
        if np.all(np.abs(missing[:3]) < _CLOSE_MM) and np.all(np.abs(missing[3:]) < _CLOSE_RAD):
            return joints
        step = np.linalg.lstsq(_jacobian(bodies), missing, rcond=1e-9)[0]
        joints = joints + step * min(1.0, _LONGEST_STEP_RAD / max(float(np.max(np.abs(step))), 1e-12))
    raise UnreachableError("no configuration near the current one reaches the pose")


def _missing(present: FloatArray, wanted: FloatArray) -> FloatArray:
    """Return translation [mm] and rotation vector [rad] from present to wanted frame, shape (6,)."""
    turn = to_rotation_vector(wanted[:3, :3] @ present[:3, :3].T)
    return np.concatenate([wanted[:3, 3] - present[:3, 3], turn])


def _jacobian(bodies: Bodies) -> FloatArray:
    """Motion of the flange frame per joint angle, shape (6, J)."""
    directions = bodies.axis_directions[0]
    levers = bodies.last_frame[0, :3, 3] - bodies.axis_points_mm[0]
    return np.concatenate([np.cross(directions, levers), directions], axis=1).T


_LINE_STEP_MM = 20.0
_LONGEST_LINE_MM = 4000.0  # these arms reach less than 1.2 m to every side, tool included


def straight_line(start: FloatArray, end: FloatArray) -> list[FloatArray]:
    """Return placements on the straight line from `start` (left out) to `end`, orientation turning evenly.

    Raises UnreachableError when it is longer than any arm here.
    """
    length_mm = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
    if not length_mm <= _LONGEST_LINE_MM:
        raise UnreachableError(f"a line of {length_mm:g} mm leads out of the arm's reach")
    steps = max(1, math.ceil(length_mm / _LINE_STEP_MM))
    turn = to_quaternion(end[:3, :3] @ start[:3, :3].T)
    frames = [_between(start, end, turn, step / steps) for step in range(1, steps)]
    return [*frames, end]


def _between(start: FloatArray, end: FloatArray, turn: FloatArray, share: float) -> FloatArray:
    half = share * math.acos(min(1.0, float(turn[0])))
    sine = float(np.linalg.norm(turn[1:]))
    axis = turn[1:] / sine if sine > 0.0 else np.zeros(3)
    partial = from_quaternion(np.array([math.cos(half), *(math.sin(half) * axis)]))
    position = start[:3, 3] + share * (end[:3, 3] - start[:3, 3])
    return motion(position, partial @ start[:3, :3])
