"""Where the nominal robot is at some joint angles, and how far such angles are apart."""

import numpy as np

from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import poses_of


def nominal_poses(robot, joints_rad):
    """Poses (n, 4, 4) of the flange frame at joint angles (n, J)."""
    chain = nominal_chain(robot, joints_rad)
    return poses_of(chain.end_rotation, chain.end_origin)


def apart_rad(first_rad, second_rad):
    """Largest difference of joint angles (.., J), whole turns aside."""
    return np.abs(np.mod(first_rad - second_rad + np.pi, 2 * np.pi) - np.pi).max(axis=-1)
