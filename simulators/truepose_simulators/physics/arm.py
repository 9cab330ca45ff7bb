"""An arm as its drawing shows it, and where its bodies are: product of exponentials, an error at each joint.

Everything is in the base frame of the drawing (z up, x forward), in mm and rad. No Denavit-Hartenberg
table is used here, so a wrong row of such a table cannot hide in the truth.

Body i is the world placement of everything that turns with joint i (body 0: the base),

    body_i = body_(i-1) * A_i * exp(S_i * theta_i),   A_i = seat_i * E_i * seat_i^-1,

S_i the screw of axis i at the zero configuration, E_i the link's rigid motion stated in the seat.
Source: K. M. Lynch, F. C. Park, Modern Robotics, 2017, section 4.1.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from truepose_simulators.physics.rigid import (
    FloatArray,
    apply,
    cross_matrix,
    inverse,
    motion,
    move,
    small_motion,
)

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class JointAxis:
    """One joint at the zero configuration: its screw axis and the seat in which a link error is stated.

    The seat is the frame at `point_mm` with z along `direction` and x along `normal`, the common normal of
    the previous axis and this one.
    """

    point_mm: Vector
    direction: Vector
    normal: Vector
    lower_rad: float  # what the controller accepts
    upper_rad: float
    speed_rad_s: float


@dataclass(frozen=True, slots=True)
class CarriedMass:
    """A mass that moves with joint `joint` (1-based), at its place in the zero configuration."""

    joint: int
    mass_kg: float
    centre_of_gravity_mm: Vector


@dataclass(frozen=True)
class Arm:
    """The nominal arm; its true errors are in the plant."""

    name: str
    model: str  # as the controller states it
    joints: tuple[JointAxis, ...]
    masses: tuple[CarriedMass, ...]  # without tool
    flange_mm: Vector  # origin of the flange frame, zero configuration
    flange_x: Vector
    flange_z: Vector
    typical_compliance_rad_per_n_mm: tuple[float, ...]
    gear_ratio: tuple[float, ...]  # turns of the motor per turn of the joint

    @property
    def n_joints(self) -> int:
        """Number of joints."""
        return len(self.joints)

    @cached_property
    def seats(self) -> FloatArray:
        """Seats of all joints at the zero configuration, shape (J, 4, 4)."""
        return np.array([_frame(joint.point_mm, joint.normal, joint.direction) for joint in self.joints])

    @cached_property
    def axis_crosses(self) -> tuple[FloatArray, FloatArray]:
        """K of all axes with K b = axis x b, and K K, at the zero configuration, shape (J, 3, 3) each."""
        k = cross_matrix(self.seats[:, :3, 2])
        return k, k @ k

    @cached_property
    def flange(self) -> FloatArray:
        """The flange frame at the zero configuration, shape (4, 4)."""
        return _frame(self.flange_mm, self.flange_x, self.flange_z)

    def parallel_to_previous(self, joint: int) -> bool:
        """Whether the axis of a joint (0-based) is parallel to the one before it."""
        if joint == 0:
            return False
        cosine = np.dot(self.joints[joint].direction, self.joints[joint - 1].direction)
        return bool(abs(cosine) > 1.0 - 1e-12)

    @cached_property
    def limits_rad(self) -> FloatArray:
        """What the controller accepts, shape (J, 2)."""
        return np.array([(joint.lower_rad, joint.upper_rad) for joint in self.joints])

    @cached_property
    def speeds_rad_s(self) -> FloatArray:
        """Highest speeds of the joints, shape (J,)."""
        return np.array([joint.speed_rad_s for joint in self.joints])


def _frame(origin_mm: Vector, x: Vector, z: Vector) -> FloatArray:
    x_axis, z_axis = np.array(x), np.array(z)
    return motion(np.array(origin_mm), np.column_stack([x_axis, np.cross(z_axis, x_axis), z_axis]))


@dataclass(frozen=True, slots=True)
class Bodies:
    """Placement of the arm's bodies and axes for n configurations, world frame."""

    placements: FloatArray  # (n, J+1, 4, 4), base first
    axis_points_mm: FloatArray  # (n, J, 3)
    axis_directions: FloatArray  # (n, J, 3)
    last_frame: FloatArray  # (n, 4, 4) the flange, tool motion included


def screw_rotations(arm: Arm, angles_rad: FloatArray) -> FloatArray:
    """exp(S_i theta_i) of every joint, shape (n, J) -> (n, J, 4, 4).

    R = 1 + sin(theta) K + (1 - cos(theta)) K K (Rodrigues); a point q of the axis stays: t = q - R q.
    """
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
        joint) and of the tool (in the flange frame).

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
