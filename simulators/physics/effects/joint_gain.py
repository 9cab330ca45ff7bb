"""A joint that turns by a factor of what it should, as a wrong encoder or gear constant makes it."""

from dataclasses import dataclass

import numpy as np

from simulators.physics.arm import Arm
from simulators.physics.effects.effect import Conditions, Deflection, Effect, Loads, PlantedChange
from simulators.physics.effects.subject import joint_index


@dataclass(frozen=True, slots=True)
class JointGain:
    """Joint `joint` (0-based) turns by 1 + `gain` times the commanded angle from `from_s` on."""

    joint: int
    gain: float
    from_s: float

    def deflect(self, conditions: Conditions, loads: Loads) -> Deflection:
        """Return the share of the commanded angle that is too much."""
        del loads  # a gain is geometry of the drive, not its elasticity
        angles = np.zeros_like(conditions.joints_rad)
        angles[:, self.joint] = self.gain * conditions.joints_rad[:, self.joint]
        return Deflection(angles_rad=angles * (conditions.time_s >= self.from_s)[:, np.newaxis])


def plant(change: PlantedChange, arm: Arm) -> Effect:
    """Build the effect; the amplitude is the gain less one [1]."""
    return JointGain(joint_index(change, arm), change.amplitude, change.from_s)
