"""A plane that a sensor or gauge in the tool reads along its own axis.

With the nest at P, from which readings count, its axis a, which the tool carries, and a plane as in `planes`,

    reading = -h / (n . a),    h = n . (P - Q) - s

Source: the axis from P meets the plane at P + reading a.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.targets import Target
from truepose.identification.observations.contacts.against import Probe, Slope
from truepose.identification.observations.contacts.planes import Plane, point_of, tilted


class Face(Plane):
    """Shift and two slopes of a plane that is read askew."""

    def reading_mm(self, target: Target, values: FloatArray, probe: Probe) -> FloatArray:
        """Return the distances along the axes."""
        normal, _ = tilted(target, values)
        return -super().reading_mm(target, values, probe) / (probe.along @ normal)

    def slope(self, target: Target, values: FloatArray, probe: Probe) -> Slope:
        """Return what moving does, what turning the axis does, and what tilting the plane does."""
        normal, across = tilted(target, values)
        arm = probe.place_mm - point_of(target)
        facing = probe.along @ normal
        reading = self.reading_mm(target, values, probe)
        turn = -(reading / facing)[:, None] * np.cross(probe.along, normal)
        tilts = -(across @ arm.T + reading * (across @ probe.along.T)) / facing
        return Slope(-normal / facing[:, None], turn, np.vstack([1.0 / facing, tilts]))

    def started(self, target: Target, probe: Probe, reading_mm: FloatArray) -> tuple[Target, FloatArray]:
        """Return the plane through the points that were met."""
        met = probe.place_mm + reading_mm[:, None] * probe.along
        return super().started(target, Probe(met, probe.along), np.zeros_like(reading_mm))
