"""A tracker whose stand moves slowly: everything that it reads moves the other way, fixed nests as well.

The drift is stated in the world frame about its origin, so that its translation is what a reading near the
robot shows; about the tripod, three metres away, the same motion would have another translation.
"""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.effects.rigid_change import SHAPES, SlowMotion, courses, drift_per_s
from truepose_simulators.physics.rigid import FloatArray, inverse, pose_matrix, to_six


@dataclass(frozen=True, slots=True)
class DriftingInstrument:
    """The tracker's frame goes on moving from `from_s`."""

    per_s: FloatArray  # (6,) [mm/s, rad/s]
    from_s: float

    def frame_motion(self, time_s: FloatArray) -> FloatArray:
        """Return how far the frame has come, shape (n, 6)."""
        elapsed_s = np.maximum(time_s - self.from_s, 0.0)
        come: FloatArray = elapsed_s[:, np.newaxis] * self.per_s
        return come


def plant(change: effect.PlantedChange, site: effect.Site) -> DriftingInstrument:
    """Build the effect; the amplitude is the norm of the translation [mm/h]."""
    effect.check_only(change, "tracker")
    return DriftingInstrument(drift_per_s(change, site), change.from_s)


@dataclass(frozen=True, slots=True)
class DriftedInstrument:
    """The tracker's frame moves the other way than an identified drift says of the readings."""

    courses: tuple[SlowMotion, ...]

    def frame_motion(self, time_s: FloatArray) -> FloatArray:
        """Return how far the frame has come, shape (n, 6)."""
        come = np.sum([course.come(time_s) for course in self.courses], axis=0)
        return to_six(inverse(pose_matrix(come[..., :3], come[..., 3:])))


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[DriftedInstrument, ...]:
    """Build the identified drift of readings, `tracker_<shape>_x`..`_rz` [mm/h, rad/h] about the world."""
    del site
    rates = stated.motions(f"tracker_{SHAPES}", "tracker_<shape>")
    return (DriftedInstrument(courses(rates)),) if rates else ()
