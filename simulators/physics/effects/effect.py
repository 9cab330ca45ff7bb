"""What a physical effect may know and what it may do to the arm."""

from dataclasses import dataclass
from typing import Protocol

from simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class Conditions:
    """The circumstances of n stops; everything but the loads, which only the equilibrium tells."""

    joints_rad: FloatArray  # (n, J) commanded
    direction: FloatArray  # (n, J) sign of each joint's last motion, 0 unknown
    time_s: FloatArray  # (n,) cell time
    temperature_c: FloatArray  # (n,)
    attachment: FloatArray  # (n,) how often the tool has been mounted

    def __len__(self) -> int:
        return int(self.joints_rad.shape[0])


@dataclass(frozen=True, slots=True)
class Loads:
    """What gravity does at the configuration as it truly is."""

    torque_n_mm: FloatArray  # (n, J) about each axis, positive along it


@dataclass(frozen=True, slots=True)
class Deflection:
    """What an effect adds: to the angles of the joints, and to the motions of base, links and tool."""

    angles_rad: FloatArray | None = None  # (n, J)
    motions: FloatArray | None = None  # (n, J+2, 6) [mm, rad], seats as in `chain.link_motions`


class Effect(Protocol):
    """A physical source of error; pure, so that it can be asked again while the equilibrium is sought."""

    def deflect(self, conditions: Conditions, loads: Loads) -> Deflection:
        """Return what the effect adds under these conditions and loads."""
        ...


@dataclass(frozen=True, slots=True)
class PlantedChange:
    """A change planted in the cell, as a scenario names it."""

    name: str
    subject: str
    amplitude: float
    from_s: float = 0.0
