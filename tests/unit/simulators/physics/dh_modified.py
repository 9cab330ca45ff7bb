"""Forward kinematics after Craig, written for tests: the route that the simulated physics does not take."""

import numpy as np

# alpha [deg], a [mm], theta offset [deg], d [mm]; A. Nubiola, thesis, ETS Montreal 2014, section 2.3.
NOMINAL = {
    "irb120": [
        (0.0, 0.0, 0.0, 290.0),
        (-90.0, 0.0, -90.0, 0.0),
        (0.0, 270.0, 0.0, 0.0),
        (-90.0, 70.0, 0.0, 302.0),
        (90.0, 0.0, 0.0, 0.0),
        (-90.0, 0.0, 180.0, 72.0),
    ],
    "lrmate200ic": [
        (0.0, 0.0, 0.0, 330.0),
        (-90.0, 75.0, -90.0, 0.0),
        (0.0, 300.0, 0.0, 0.0),
        (-90.0, 75.0, 0.0, 320.0),
        (90.0, 0.0, 0.0, 0.0),
        (-90.0, 0.0, 0.0, 80.0),
    ],
}
# frame, mass [kg], centre of gravity in that frame [mm]; same source, tool of section 2.2.1.
MASSES = {
    "irb120": [(2, 4.2, (140.0, 0, 0)), (4, 5.0, (0, 0, -193.6)), (6, 2.7, (50.0, 25.0, 100.0))],
    "lrmate200ic": [(2, 10.0, (150.0, 0, 0)), (4, 10.0, (0, 0, -160.0)), (6, 2.7, (50.0, 25.0, 100.0))],
}


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
