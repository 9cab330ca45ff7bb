"""Where the bodies of the arm are: product of exponentials with a small rigid motion at every joint.

Body i is the world placement of everything that turns with joint i (body 0: the base),

    body_i = body_(i-1) * A_i * exp(S_i * theta_i),   A_i = seat_i * E_i * seat_i^-1,

S_i the screw of axis i at the zero configuration, E_i the link's rigid motion stated in the seat.
Source: K. M. Lynch, F. C. Park, Modern Robotics, 2017, section 4.1.
"""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.physics.arm import Arm
from truepose_simulators.physics.rigid import (
    FloatArray,
    apply,
    inverse,
    motion,
    move,
    small_motion,
)


@dataclass(frozen=True, slots=True)
class Bodies:
    """Placement of the arm's bodies and axes for n configurations, world frame."""

    placements: FloatArray  # (n, J+1, 4, 4), base first
    axis_points_mm: FloatArray  # (n, J, 3)
    axis_directions: FloatArray  # (n, J, 3)
    last_frame: FloatArray  # (n, 4, 4) the flange, tool motion included


def screw_rotations(arm: Arm, angles_rad: FloatArray) -> FloatArray:
    """exp(S_i theta_i) of every joint, shape (n, J) -> (n, J, 4, 4)."""
    points = arm.seats[:, :3, 3]
    k, k_k = arm.axis_crosses
    sine = np.sin(angles_rad)[..., np.newaxis, np.newaxis]
    versine = 1.0 - np.cos(angles_rad)[..., np.newaxis, np.newaxis]
    rotations = np.eye(3) + sine * k + versine * k_k
    return motion(points - apply(rotations, points), rotations)


def link_motions(arm: Arm, motions: FloatArray) -> FloatArray:
    """Rigid motions of base, links and tool moved from their seats into the base frame.

    Parameters
    ----------
    arm : Arm
    motions : ndarray, shape (..., J+2, 6)
        `[tx ty tz rx ry rz]` [mm, rad] of the base (world frame), of every link (in the seat of its
        joint) and of the tool (in the last frame).

    Returns
    -------
    ndarray, shape (..., J+2, 4, 4)
    """
    seats = np.concatenate([np.eye(4)[np.newaxis], arm.seats, arm.flange[np.newaxis]])
    moved: FloatArray = seats @ small_motion(motions) @ inverse(seats)
    return moved


def place_bodies(arm: Arm, errors: FloatArray, angles_rad: FloatArray) -> Bodies:
    """Place all bodies.

    Parameters
    ----------
    arm : Arm
    errors : ndarray, shape (J+2, 4, 4) or (n, J+2, 4, 4)
        From `link_motions`.
    angles_rad : ndarray, shape (n, J)
        Angles that the joints truly turn by.
    """
    n = angles_rad.shape[0]
    turns = screw_rotations(arm, angles_rad)
    errors = np.broadcast_to(errors, (n, *errors.shape[-3:]))
    placements = np.empty((n, arm.n_joints + 1, 4, 4))
    seats = np.empty((n, arm.n_joints, 4, 4))
    placements[:, 0] = errors[:, 0]
    for i in range(arm.n_joints):
        np.matmul(placements[:, i], errors[:, i + 1], out=seats[:, i])
        np.matmul(seats[:, i], turns[:, i], out=placements[:, i + 1])
    return Bodies(
        placements=placements,
        axis_points_mm=move(seats, arm.seats[:, :3, 3]),
        axis_directions=apply(seats[..., :3, :3], arm.seats[:, :3, 2]),
        last_frame=placements[:, -1] @ errors[:, -1] @ arm.flange,
    )
