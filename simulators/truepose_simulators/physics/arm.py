"""An arm as its drawing shows it: where every joint axis lies while all joints read zero.

Everything is in the base frame of the drawing (z up, x forward), in mm and rad. No Denavit-Hartenberg
table is used here, so a wrong row of such a table cannot hide in the truth.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from truepose_simulators.physics.rigid import FloatArray, cross_matrix, motion

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
    flange_mm: Vector  # origin of the last frame, zero configuration
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
        """The last frame at the zero configuration, shape (4, 4)."""
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
