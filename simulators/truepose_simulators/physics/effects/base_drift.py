"""A base that moves slowly and evenly: settling ground, a floor in the sun."""

from dataclasses import dataclass

from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.effects.rigid_change import (
    SHAPES,
    Drift,
    identified_drift,
    motion_in_world,
    planted_drift,
)
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class DriftingBase:
    """The base moves about the origin of the world."""

    come: Drift

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return how far the base has come."""
        del loads
        return effect.Deflection.of_body(conditions, 0, self.come(conditions.time_s))


def plant(change: effect.PlantedChange, site: effect.Site) -> DriftingBase:
    """Build the effect; the amplitude is the norm of the translation [mm/h]."""
    effect.check_only(change, "base")
    return DriftingBase(planted_drift(change, site))


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[DriftingBase, ...]:
    """Build the identified drift, `drift_<shape>_x`..`_rz` [mm/h, rad/h]; shapes as `time_shape` has them.

    It goes along the base's own axes and about its own origin.
    """
    rates = stated.motions(f"drift_{SHAPES}", "drift_<shape>")
    own = identified_drift(rates)

    def come(time_s: FloatArray) -> FloatArray:
        return motion_in_world(site.base, own(time_s))

    return (DriftingBase(come),) if rates else ()
