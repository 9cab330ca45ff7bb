"""A tool that weighs something else, or elsewhere, than everybody was told."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.arm import CarriedMass, Vector
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.effects.mass_error import (
    IdentifiedMass,
    MassDetails,
    MassError,
    identified_mass,
)
from truepose_simulators.physics.loads import MassChange

_NOTHING: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class WrongPayload:
    """The tool as it truly is, in place of the stated one."""

    error: MassError
    from_s: float

    def mass_changes(self, conditions: effect.Conditions) -> list[MassChange]:
        """Take the stated tool away and hang on the true one."""
        return self.error.changes(conditions.since(self.from_s), on_tool=True)


def plant(change: effect.PlantedChange, site: effect.Site) -> WrongPayload:
    """Build the effect; the amplitude is true less stated mass [kg]."""
    effect.check_only(change, "tool")
    details = effect.read_details(MassDetails, change)
    stated = site.tool_mass or CarriedMass(site.arm.n_joints, 0.0, _NOTHING)
    if stated.mass_kg + change.amplitude < 0.0:
        raise ScenarioError(
            f"effect {change.name}: the tool weighs {stated.mass_kg:g} kg, so the amplitude cannot be"
            f" {change.amplitude:g}"
        )
    shift_mm = np.array(details.centre_shift_mm)
    return WrongPayload(MassError(stated, change.amplitude, shift_mm), change.from_s)


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[IdentifiedMass, ...]:
    """Build the identified tool, `payload_mass` [kg] and `payload_x`.. [kg mm, flange frame]."""
    extra_kg, moment = 0.0, np.zeros(3)
    for (part,), value in stated.matching(r"payload_(mass|x|y|z)", "payload_mass, payload_x, _y, _z"):
        if part == "mass":
            extra_kg = value
        else:
            moment["xyz".index(part)] = value
    return (identified_mass(site.arm.n_joints, extra_kg, moment, site),)
