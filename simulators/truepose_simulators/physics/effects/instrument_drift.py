"""A tracker whose stand moves slowly: everything that it reads moves the other way, fixed nests as well.

The drift is stated in the world frame about its origin, so that its translation is what a reading near the
robot shows; about the tripod, three metres away, the same motion would have another translation.
"""

from dataclasses import dataclass

from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.effects.rigid_change import SHAPES, Drift, identified_drift, planted_drift
from truepose_simulators.physics.rigid import FloatArray, inverse, pose_matrix, to_six


@dataclass(frozen=True, slots=True)
class DriftingInstrument:
    """The tracker's frame moves."""

    come: Drift

    def frame_motion(self, time_s: FloatArray) -> FloatArray:
        """Return how far the frame has come, shape (n, 6)."""
        return self.come(time_s)


def plant(change: effect.PlantedChange, site: effect.Site) -> DriftingInstrument:
    """Build the effect; the amplitude is the norm of the translation [mm/h]."""
    effect.check_only(change, "tracker")
    return DriftingInstrument(planted_drift(change, site))


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[DriftingInstrument, ...]:
    """Build the identified drift of readings, `tracker_<shape>_x`..`_rz` [mm/h, rad/h] about the world.

    The frame moves the other way than the readings do.
    """
    del site
    rates = stated.motions(f"tracker_{SHAPES}", "tracker_<shape>")
    readings = identified_drift(rates)

    def come(time_s: FloatArray) -> FloatArray:
        seen = readings(time_s)
        return to_six(inverse(pose_matrix(seen[:, :3], seen[:, 3:])))

    return (DriftingInstrument(come),) if rates else ()
