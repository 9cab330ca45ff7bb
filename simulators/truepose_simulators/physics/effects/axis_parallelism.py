"""An axis that should be parallel to the one before it and is not: Hayati's beta."""

from dataclasses import dataclass
from math import radians

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.rigid import FloatArray

_ABOUT_Y = 4  # across the axis and the common normal, in the seat of the joint


@dataclass(frozen=True, slots=True)
class TiltedAxis:
    """Link `joint` + 1 turns out of the plane in which it should lie."""

    joint: int  # 0-based
    tilt_rad: float
    from_s: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return the tilt of the link, in the seat of its joint."""
        del loads
        motion: FloatArray = np.zeros((len(conditions), 6))
        motion[:, _ABOUT_Y] = self.tilt_rad * conditions.since(self.from_s)
        return effect.Deflection.of_body(conditions, self.joint + 1, motion)


def plant(change: effect.PlantedChange, site: effect.Site) -> TiltedAxis:
    """Build the effect; the amplitude is the tilt [deg]."""
    effect.read_details(effect.NoDetails, change)
    joint = effect.joint_index(change, site.arm)
    if not site.arm.parallel_to_previous(joint):
        raise ScenarioError(
            f'effect {change.name}: the axis of "{change.subject}" is not nominally parallel to the one'
            f" before it; name a joint whose axis is, such as joint 3"
        )
    return TiltedAxis(joint, radians(change.amplitude), change.from_s)
