"""A mass that is truly another one, or elsewhere, than stated."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.arm import CarriedMass, Vector
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.loads import MassChange
from truepose_simulators.physics.rigid import FloatArray, apply

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


@dataclass(frozen=True, slots=True)
class IdentifiedMass:
    """A body that weighs something else, or elsewhere, than stated; base frame, zero configuration.

    The true mass takes the place of the stated one. Where nothing would be left of it, a kilogram more than
    the change is borrowed at the stated centre: weights add up to the same.
    """

    stated: CarriedMass
    extra_kg: float
    extra_moment_kg_mm: FloatArray  # (3,) about the origin

    def mass_changes(self, conditions: effect.Conditions) -> list[MassChange]:
        """Take the stated mass away and put the identified one in its place."""
        always = np.ones(len(conditions))
        borrowed_kg = self.stated.mass_kg
        if borrowed_kg + self.extra_kg <= 0.0:
            borrowed_kg = 1.0 + abs(self.extra_kg)
        centre_mm = np.array(self.stated.centre_of_gravity_mm)
        true_kg = borrowed_kg + self.extra_kg
        true_mm = (borrowed_kg * centre_mm + self.extra_moment_kg_mm) / true_kg
        joint = self.stated.joint
        return [
            MassChange(joint, -borrowed_kg * always, centre_mm),
            MassChange(joint, true_kg * always, true_mm),
        ]


def identified_mass(
    joint: int, extra_kg: float, extra_moment_kg_mm: FloatArray, site: effect.ModelArm
) -> IdentifiedMass:
    """Return a body of other mass and first moment (3,); changes are stated in the frame of its joint."""
    frame = site.frames[joint - 1]
    # From the frame of the joint to the base: m (o + R c) = R (m c) + m o.
    moment = apply(frame[:3, :3], extra_moment_kg_mm) + extra_kg * frame[:3, 3]
    return IdentifiedMass(_stated_mass(joint, site), extra_kg, moment)


def _stated_mass(joint: int, site: effect.ModelArm) -> CarriedMass:
    """Return all that the model's robot carries there, in one; of nothing, nothing at the joint's frame."""
    carried = [mass for mass in site.arm.masses if mass.joint == joint and mass.mass_kg > 0.0]
    x, y, z = site.frames[joint - 1, :3, 3]
    total_kg = sum(mass.mass_kg for mass in carried)
    if carried:
        centres = np.array([mass.centre_of_gravity_mm for mass in carried])
        x, y, z = np.array([mass.mass_kg for mass in carried]) @ centres / total_kg
    return CarriedMass(joint, total_kg, (float(x), float(y), float(z)))
