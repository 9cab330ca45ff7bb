"""Gravity torques about the axes where they truly are: r x F of every mass beyond a joint."""

from collections.abc import Sequence

import numpy as np

from simulators.physics.arm import CarriedMass
from simulators.physics.chain import Bodies
from simulators.physics.rigid import FloatArray, apply, move

# 1 kg in 1 m/s2 weighs 1 N; levers are in mm, so torques come out in N mm.
GRAVITY_M_S2 = (0.0, 0.0, -9.81)


def gravity_torques(bodies: Bodies, masses: Sequence[CarriedMass], tool: CarriedMass | None) -> FloatArray:
    """Torque of gravity about every joint axis [N mm], positive along the axis.

    Parameters
    ----------
    bodies : Bodies
        Of n configurations.
    masses : sequence of CarriedMass
        Of the arm, places in the zero configuration.
    tool : CarriedMass or None
        Its place is stated in the last frame.

    Returns
    -------
    ndarray, shape (n, J)
    """
    n, n_joints = bodies.axis_points_mm.shape[:2]
    mass = np.zeros(n_joints)
    first_moment = np.zeros((n, n_joints, 3))  # [kg mm] of what hangs on each joint alone
    for item in masses:
        centre = move(bodies.placements[:, item.joint], np.array(item.centre_of_gravity_mm))
        mass[item.joint - 1] += item.mass_kg
        first_moment[:, item.joint - 1] += item.mass_kg * centre
    if tool is not None:
        mass[tool.joint - 1] += tool.mass_kg
        first_moment[:, tool.joint - 1] += tool.mass_kg * move(
            bodies.last_frame, np.array(tool.centre_of_gravity_mm)
        )
    beyond_mass = _sum_beyond(mass[np.newaxis, :, np.newaxis])
    levers = _sum_beyond(first_moment) - beyond_mass * bodies.axis_points_mm
    torques: FloatArray = np.einsum("nji,nji->nj", _moments(levers), bodies.axis_directions)
    return torques


def _sum_beyond(per_joint: FloatArray) -> FloatArray:
    """Sum over a joint and all that follow it along the arm (axis 1)."""
    return np.cumsum(per_joint[:, ::-1], axis=1)[:, ::-1]


def _moments(levers_kg_mm: FloatArray) -> FloatArray:
    gravity = np.array(GRAVITY_M_S2)
    # r x g as a matrix product: cheaper than np.cross for a single configuration
    minus_gravity_cross = np.array([
        [0.0, gravity[2], -gravity[1]],
        [-gravity[2], 0.0, gravity[0]],
        [gravity[1], -gravity[0], 0.0],
    ])
    return apply(minus_gravity_cross, levers_kg_mm)
