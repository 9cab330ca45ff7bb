"""A base that moves slowly and evenly: settling ground, a floor in the sun."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.effects.rigid_change import (
    SHAPES,
    SlowMotion,
    courses,
    drift_per_s,
    motion_in_world,
)
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class DriftingBase:
    """The base goes on moving from `from_s`, about the origin of the world."""

    per_s: FloatArray  # (6,) [mm/s, rad/s]
    from_s: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return how far the base has come."""
        del loads
        elapsed_s = np.maximum(conditions.time_s - self.from_s, 0.0)
        return effect.Deflection.of_body(conditions, 0, elapsed_s[:, np.newaxis] * self.per_s)


def plant(change: effect.PlantedChange, site: effect.Site) -> DriftingBase:
    """Build the effect; the amplitude is the norm of the translation [mm/h]."""
    effect.check_only(change, "base")
    return DriftingBase(drift_per_s(change, site), change.from_s)


@dataclass(frozen=True, slots=True)
class DriftedBase:
    """The base moves as an identified drift says, along its own axes and about its own origin."""

    courses: tuple[SlowMotion, ...]
    base: FloatArray  # (4, 4)

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return how far the base has come."""
        del loads
        come = np.sum([course.come(conditions.time_s) for course in self.courses], axis=0)
        return effect.Deflection.of_body(conditions, 0, motion_in_world(self.base, come))


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[DriftedBase, ...]:
    """Build the identified drift, `drift_<shape>_x`..`_rz` [mm/h, rad/h]; shapes as `time_shape` has them."""
    rates = stated.motions(f"drift_{SHAPES}", "drift_<shape>")
    return (DriftedBase(courses(rates), site.base),) if rates else ()
