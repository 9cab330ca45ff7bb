"""A base that tilts under the arm's weight, as a slender pedestal or a thin table top does."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.loads import overturning_moment_n_mm
from truepose_simulators.physics.rigid import FloatArray, apply, rotation


@dataclass(frozen=True, slots=True)
class SoftBase:
    """The base turns about a point by compliance times the overturning moment about that point."""

    compliance_rad_per_n_mm: float
    about_mm: FloatArray  # (3,) world
    from_s: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return the tilt of the base."""
        moment = overturning_moment_n_mm(loads.masses, len(conditions), loads.gravity_m_s2, self.about_mm)
        tilt = self.compliance_rad_per_n_mm * moment * conditions.since(self.from_s)[:, np.newaxis]
        # A turn R about a point q is a turn about the origin and a shift by q - R q.
        shift = self.about_mm - apply(rotation(tilt), self.about_mm)
        return effect.Deflection.of_body(conditions, 0, np.concatenate([shift, tilt], axis=1))


def plant(change: effect.PlantedChange, site: effect.Site) -> SoftBase:
    """Build the effect; the amplitude is the compliance about every horizontal axis [rad/(N mm)].

    It turns about the origin of the world, where drawings have the foot of the arm.
    """
    del site
    effect.check_only(change, "base")
    effect.read_details(effect.NoDetails, change)
    return SoftBase(change.amplitude, np.zeros(3), change.from_s)


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[SoftBase, ...]:
    """Build the identified compliance, `base_c` [rad/(N mm)], about the origin of the identified base."""
    origin_mm = site.base[:3, 3]
    return tuple(
        SoftBase(value, origin_mm, effect.ALWAYS_S) for _, value in stated.matching("base_c", "base_c")
    )
