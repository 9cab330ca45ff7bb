"""Forward kinematics after Craig, written for tests: the route that the simulated physics does not take."""

import numpy as np

from tests.helpers.reference import reference

_ARMS = reference("thesis_arms")
NOMINAL = {name: arm["joints"] for name, arm in _ARMS.items()}
MASSES = {name: arm["masses"] for name, arm in _ARMS.items()}


def rotate(axis, angle_rad):
    """Homogenous rotation about a main axis."""
    result = np.eye(4)
    first, second = [i for i in range(3) if i != axis]
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    sign = -1.0 if axis == 1 else 1.0
    result[first, first] = result[second, second] = cosine
    result[first, second], result[second, first] = -sign * sine, sign * sine
    return result


def shift(x, y, z):
    """Homogenous translation."""
    result = np.eye(4)
    result[:3, 3] = x, y, z
    return result


def frames(table, angles_rad, base=None):
    """Return all frames of one configuration, base excluded."""
    frame = np.eye(4) if base is None else base
    result = []
    for (alpha, a, offset, d), angle in zip(table, angles_rad, strict=True):
        frame = frame @ rotate(0, np.radians(alpha)) @ shift(a, 0, 0)
        frame = frame @ rotate(2, angle + np.radians(offset)) @ shift(0, 0, d)
        result.append(frame)
    return result


def torques(table, masses, angles_rad):
    """Thesis, equation I.10: tau_ij = f_y c_x - f_x c_y in frame i, gravity along -z of the base [N mm]."""
    placed = frames(table, angles_rad)
    result = np.zeros(len(table))
    for i, frame in enumerate(placed):
        for number, mass, centre in masses:
            if number - 1 >= i:
                force = frame[:3, :3].T @ (0.0, 0.0, -9.81 * mass)
                x, y, _, _ = np.linalg.inv(frame) @ placed[number - 1] @ (*centre, 1.0)
                result[i] += force[1] * x - force[0] * y
    return result
