"""Waves of a joint's own angle: eccentric gears and encoders, and the cycle of a strain-wave gear."""

from dataclasses import dataclass
from math import pi, radians

import numpy as np

from simulators.errors import ScenarioError
from simulators.physics.effects.effect import Conditions, Deflection, Loads, PlantedChange
from simulators.physics.effects.site import Site, read_details
from simulators.physics.effects.subject import joint_index


@dataclass(frozen=True, slots=True)
class HarmonicDetails:
    """Which wave: the angle that the joint is off by is amplitude * sin(order * q + phase)."""

    order: float = 2.0  # periods per turn of the joint; a strain-wave gear has 2 per turn of its generator
    phase_deg: float | None = None  # absent: drawn


@dataclass(frozen=True, slots=True)
class JointHarmonic:
    """One wave of one joint."""

    joint: int  # 0-based
    amplitude_rad: float
    order: float
    phase_rad: float
    from_s: float

    def deflect(self, conditions: Conditions, loads: Loads) -> Deflection:
        """Return the wave at the commanded angle."""
        del loads  # the wave is cut into the teeth
        wave = np.sin(self.order * conditions.joints_rad[:, self.joint] + self.phase_rad)
        return Deflection.of_joint(
            conditions, self.joint, self.amplitude_rad * wave * conditions.since(self.from_s)
        )


def plant(change: PlantedChange, site: Site) -> JointHarmonic:
    """Build the effect; the amplitude is half of peak to peak [deg]."""
    details = read_details(HarmonicDetails, change)
    joint = joint_index(change, site.arm)
    highest = 2.0 * site.arm.gear_ratio[joint]
    if not 0.0 < details.order <= highest:
        raise ScenarioError(
            f'effect {change.name}: key "order" of {change.subject} must be above 0 and at most {highest:g},'
            f" twice the gear ratio, not {details.order:g}"
        )
    drawn_rad = float(site.rng().uniform(-pi, pi))
    phase_rad = drawn_rad if details.phase_deg is None else radians(details.phase_deg)
    return JointHarmonic(joint, radians(change.amplitude), details.order, phase_rad, change.from_s)
