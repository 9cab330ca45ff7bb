"""A base that jumped once: somebody drove against the table, a foot screw gave way."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.effects.rigid_change import jump, motion_in_world
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class ShiftedBase:
    """The base stands elsewhere from `from_s` on, turned about the origin of the world."""

    motion: FloatArray  # (6,) [mm, rad]
    from_s: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return the jump, once it has happened."""
        del loads
        return effect.Deflection.of_body(
            conditions, 0, conditions.since(self.from_s)[:, np.newaxis] * self.motion
        )


def plant(change: effect.PlantedChange, site: effect.Site) -> ShiftedBase:
    """Build the effect; the amplitude is the norm of the translation [mm]."""
    effect.check_only(change, "base")
    return ShiftedBase(jump(change, site), change.from_s)


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[ShiftedBase, ...]:
    """Build the identified jumps, `jump_<time>_x`..`_rz` [mm, rad], along the axes of the base.

    Several jumps add up, each stated where the base stood at first.
    """
    jumps = stated.motions(r"jump_(-?[0-9.e+-]+)", "jump_<time>")
    return tuple(
        ShiftedBase(motion_in_world(site.base, motion), float(time_s) - site.origin_s)
        for time_s, motion in jumps.items()
    )
