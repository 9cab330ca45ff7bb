"""Gears that are softer while they carry little, as their teeth come to bear one by one.

The angle on top of c * tau is share * c * t0 * tanh(tau / t0): near zero torque the spring is softer by
`share`, far beyond t0 it has its own stiffness again.
"""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class SofteningDetails:
    """Where the softness ends."""

    t0_n_mm: float = 2000.0

    def __post_init__(self) -> None:
        if not 1.0 <= self.t0_n_mm <= 1e6:
            raise ScenarioError(f'key "t0_n_mm" must be 1 to 1e6, not {self.t0_n_mm:g}')


@dataclass(frozen=True, slots=True)
class SofterUnloaded:
    """Gearboxes with an S-shaped characteristic."""

    extra_rad_per_n_mm: FloatArray  # (J,) at zero torque
    t0_n_mm: float
    from_s: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return what the teeth give before they bear."""
        bearing = self.t0_n_mm * np.tanh(loads.torque_n_mm / self.t0_n_mm)
        angles = self.extra_rad_per_n_mm * bearing
        return effect.Deflection(angles_rad=angles * conditions.since(self.from_s)[:, np.newaxis])


def plant(change: effect.PlantedChange, site: effect.Site) -> SofterUnloaded:
    """Build the effect; the amplitude is the relative extra compliance near zero torque."""
    details = effect.read_details(SofteningDetails, change)
    extra = np.zeros(site.arm.n_joints)
    joints = list(effect.joint_indices(change, site.arm))
    extra[joints] = change.amplitude * site.compliance_rad_per_n_mm[joints]
    return SofterUnloaded(extra, details.t0_n_mm, change.from_s)


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[SofterUnloaded, ...]:
    """Build the identified characteristics, `soft_<joint>_<t0 in N mm>` [rad/(N mm)]."""
    form, n = "soft_<joint>_<t0>", site.arm.n_joints
    found = []
    for (joint, t0_n_mm), extra in stated.matching(r"soft_([0-9]+)_([0-9.e+]+)", form):
        softness = np.zeros(n)
        softness[stated.index(joint, n, "joint")] = extra
        found.append(SofterUnloaded(softness, float(t0_n_mm), effect.ALWAYS_S))
    return tuple(found)
