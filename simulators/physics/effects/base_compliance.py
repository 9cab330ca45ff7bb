"""A base that tilts under the arm's weight, as a slender pedestal or a thin table top does."""

from dataclasses import dataclass

import numpy as np

from simulators.physics.effects.effect import Conditions, Deflection, Loads, PlantedChange
from simulators.physics.effects.site import NoDetails, Site, read_details
from simulators.physics.effects.stated import ALWAYS_S, ModelArm, Stated
from simulators.physics.effects.subject import check_only
from simulators.physics.loads import overturning_moment_n_mm


@dataclass(frozen=True, slots=True)
class SoftBase:
    """The base turns about the origin of the world by compliance times overturning moment."""

    compliance_rad_per_n_mm: float
    from_s: float

    def deflect(self, conditions: Conditions, loads: Loads) -> Deflection:
        """Return the tilt of the base."""
        moment = overturning_moment_n_mm(loads.masses, len(conditions), loads.gravity_m_s2)
        tilt = self.compliance_rad_per_n_mm * moment * conditions.since(self.from_s)[:, np.newaxis]
        return Deflection.of_body(conditions, 0, np.concatenate([np.zeros_like(tilt), tilt], axis=1))


def plant(change: PlantedChange, site: Site) -> SoftBase:
    """Build the effect; the amplitude is the compliance about every horizontal axis [rad/(N mm)]."""
    del site
    check_only(change, "base")
    read_details(NoDetails, change)
    return SoftBase(change.amplitude, change.from_s)


def realise(stated: Stated, site: ModelArm) -> tuple[SoftBase, ...]:
    """Build the identified compliance, `base_c` [rad/(N mm)]."""
    del site
    return tuple(SoftBase(value, ALWAYS_S) for _, value in stated.matching("base_c", "base_c"))
