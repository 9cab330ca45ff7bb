"""What a FANUC controller shows of an arm: its own count of the joints, its world and its flange angles.

The controller counts by inclinations: joint 2 is how far the upper arm leans forward, joint 3 how far the
forearm points up, whatever joint 2 does. Both come here from the directions of the links; joints 4 to 6 turn
the other way round than the drawing's axes. Its world has its origin at the height of axis 2.
"""

import math

import numpy as np

from truepose_simulators.physics.arm import Arm
from truepose_simulators.physics.rigid import FloatArray, motion

_WRIST_TURNS = np.array([-1.0, -1.0, -1.0])


def shown_deg(joints_rad: FloatArray) -> FloatArray:
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
