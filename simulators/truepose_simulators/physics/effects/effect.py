"""What a physical effect may know and what it may do to the arm."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from truepose_simulators.physics.arm import Vector
from truepose_simulators.physics.chain import Bodies
from truepose_simulators.physics.loads import GRAVITY_M_S2, PlacedMass
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class Conditions:
    """The circumstances of n stops; everything but the loads, which only the equilibrium tells."""

    joints_rad: FloatArray  # (n, J) commanded
    direction: FloatArray  # (n, J) sign of each joint's last motion, 0 unknown
    time_s: FloatArray  # (n,) cell time
    temperature_c: FloatArray  # (n,)
    attachment: FloatArray  # (n,) how often the tool has been mounted
    # (n, J) what torque sensors said; None: gravity alone loads the gearboxes
    measured_torque_n_mm: FloatArray | None = None

    def __len__(self) -> int:
        return int(self.joints_rad.shape[0])

    def since(self, from_s: float) -> FloatArray:
        """1 where a change that begins at `from_s` is there, else 0; shape (n,)."""
        return since(self.time_s, from_s)


def since(time_s: FloatArray, from_s: float) -> FloatArray:
    """1 from `from_s` on, else 0."""
    return (time_s >= from_s).astype(np.float64)


@dataclass(frozen=True, slots=True)
class Loads:
    """What gravity does at the configuration as it truly is; nothing before the arm has been placed once."""

    torque_n_mm: FloatArray  # (n, J) about each axis, positive along it
    masses: tuple[PlacedMass, ...] = ()
    bodies: Bodies | None = None
    gravity_m_s2: Vector = GRAVITY_M_S2  # world


@dataclass(frozen=True, slots=True)
class Deflection:
    """What an effect adds: to the angles of the joints, and to the motions of base, links and tool."""

    angles_rad: FloatArray | None = None  # (n, J)
    motions: FloatArray | None = None  # (n, J+2, 6) [mm, rad], seats as in `chain.link_motions`

    @classmethod
    def of_joint(cls, conditions: Conditions, joint: int, angle_rad: FloatArray) -> "Deflection":
        """Turn one joint (0-based) by `angle_rad`, shape (n,)."""
        angles = np.zeros_like(conditions.joints_rad)
        angles[:, joint] = angle_rad
        return cls(angles_rad=angles)

    @classmethod
    def of_body(cls, conditions: Conditions, body: int, motion: FloatArray) -> "Deflection":
        """Move one body (0 base, then the links, -1 tool) by `motion`, shape (n, 6) [mm, rad]."""
        n, n_joints = conditions.joints_rad.shape
        motions = np.zeros((n, n_joints + 2, 6))
        motions[:, body] = motion
        return cls(motions=motions)


@dataclass(frozen=True, slots=True)
class PlantedChange:
    """A change planted in the cell, as a scenario names it; what `details` may say is up to the effect."""

    name: str
    subject: str
    amplitude: float
    from_s: float = 0.0
    details: Mapping[str, object] = field(default_factory=dict)
