"""Links that weigh something else, or elsewhere, than the maker states."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.arm import CarriedMass
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.effects.mass_error import (
    IdentifiedMass,
    MassDetails,
    MassError,
    identified_mass,
)
from truepose_simulators.physics.loads import MassChange
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class WrongLinkMasses:
    """The links as they truly are, in place of the stated ones."""

    errors: tuple[MassError, ...]
    from_s: float

    def mass_changes(self, conditions: effect.Conditions) -> list[MassChange]:
        """Take the stated links away and put the true ones in their place."""
        present = conditions.since(self.from_s)
        return [change for error in self.errors for change in error.changes(present, on_tool=False)]


def plant(change: effect.PlantedChange, site: effect.Site) -> WrongLinkMasses:
    """Build the effect; the amplitude is true less stated mass [kg], of `links` that of each.

    The centre of gravity shifts along the base axes as they lie in the zero configuration.
    """
    details = effect.read_details(MassDetails, change)
    stated = {mass.joint: mass for mass in site.arm.masses}
    links = effect.link_numbers(change, tuple(stated))
    shift_mm = np.array(details.centre_shift_mm)
    errors = tuple(_error(change, stated[link], shift_mm) for link in links)
    return WrongLinkMasses(errors, change.from_s)


def _error(change: effect.PlantedChange, stated: CarriedMass, shift_mm: FloatArray) -> MassError:
    if stated.mass_kg + change.amplitude < 0.0:
        raise ScenarioError(
            f"effect {change.name}: link {stated.joint} weighs {stated.mass_kg:g} kg, so the amplitude"
            f" cannot be {change.amplitude:g}"
        )
    return MassError(stated, change.amplitude, shift_mm)


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[IdentifiedMass, ...]:
    """Build the identified links, `mass_<link>` [kg] and `moment_<link>_x`.. [kg mm, frame of the joint]."""
    extra_kg: dict[int, float] = {}
    moments: dict[int, FloatArray] = {}
    pattern, form = r"(?:mass_([0-9]+)|moment_([0-9]+)_([xyz]))", "mass_<link>, moment_<link>_x, _y, _z"
    for (of_mass, of_moment, axis), value in stated.matching(pattern, form):
        link = 1 + stated.index(of_mass or of_moment, site.arm.n_joints, "link")
        if axis is None:
            extra_kg[link] = value
        else:
            moments.setdefault(link, np.zeros(3))["xyz".index(axis)] = value
    return tuple(
        identified_mass(link, extra_kg.get(link, 0.0), moments.get(link, np.zeros(3)), site)
        for link in sorted({*extra_kg, *moments})
    )
