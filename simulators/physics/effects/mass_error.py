"""A mass that is truly another one, or elsewhere, than stated."""

from dataclasses import dataclass

import numpy as np

from simulators.errors import ScenarioError
from simulators.physics.arm import CarriedMass, Vector
from simulators.physics.loads import MassChange
from simulators.physics.rigid import FloatArray

_FARTHEST_MM = 1000.0


@dataclass(frozen=True, slots=True)
class MassDetails:
    """Where the mass truly is."""

    centre_shift_mm: Vector = (0.0, 0.0, 0.0)  # true less stated centre of gravity

    def __post_init__(self) -> None:
        if max(abs(part) for part in self.centre_shift_mm) > _FARTHEST_MM:
            raise ScenarioError(
                f'key "centre_shift_mm" must stay within {_FARTHEST_MM:g} mm, not'
                f" {list(self.centre_shift_mm)}"
            )


@dataclass(frozen=True, slots=True)
class MassError:
    """Difference between the stated mass and the true one."""

    stated: CarriedMass
    extra_kg: float
    shift_mm: FloatArray  # (3,)

    def changes(self, present: FloatArray, *, on_tool: bool) -> list[MassChange]:
        """Take the stated mass away and put the true one in its place, where `present` (n,) is 1."""
        joint, mass_kg = self.stated.joint, self.stated.mass_kg
        centre_mm = np.array(self.stated.centre_of_gravity_mm)
        return [
            MassChange(joint, -mass_kg * present, centre_mm, on_tool),
            MassChange(joint, (mass_kg + self.extra_kg) * present, centre_mm + self.shift_mm, on_tool),
        ]
