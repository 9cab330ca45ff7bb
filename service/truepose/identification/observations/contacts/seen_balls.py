"""A fixed ball that sensors in the tool look at: its place in their frame, one axis a reading.

With the sensor at P, its axis a (a unit vector that the tool carries) and the ball at C,

    reading = a . (C - P)

Where the sensor sits in the tool is its nest, how it is turned the rotation of the tool.

Source: ROSY and LaserLAB as the thesis of A. Nubiola, 2014, describes them in section 1.8; three gauges that
the tool carries to fixed balls: C. Icli, O. Stepanenko, I. Bonev, Sensors 20, 2020, 5919.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.targets import Target
from truepose.effects.ports import ParameterSpec
from truepose.identification.observations.contacts.against import PLACE_WIDTH_MM, Probe, Slope


class SeenBall:
    """The place of a ball."""

    def parameters(self, target: Target, values: FloatArray) -> tuple[ParameterSpec, ...]:
        """Return its coordinates in the world."""
        return tuple(
            ParameterSpec(axis, "mm", start, PLACE_WIDTH_MM)
            for axis, start in zip("xyz", values.tolist(), strict=True)
        )

    def reading_mm(self, target: Target, values: FloatArray, probe: Probe) -> FloatArray:
        """Return how far the ball is along the axis."""
        return np.asarray(((values - probe.place_mm) * probe.along).sum(axis=1))

    def slope(self, target: Target, values: FloatArray, probe: Probe) -> Slope:
        """Return the axes; a tool that turns by w turns them by w x a."""
        turned = np.cross(probe.along, values - probe.place_mm)
        return Slope(-probe.along, turned, probe.along.T)

    def started(self, target: Target, probe: Probe, reading_mm: FloatArray) -> tuple[Target, FloatArray]:
        """Return the place that the axes meet in."""
        if target.place_mm is not None:
            return target, np.array(target.place_mm)
        right = (probe.place_mm * probe.along).sum(axis=1) + reading_mm
        return target, np.linalg.lstsq(probe.along, right, rcond=1e-9)[0]

    def centred(self, target: Target, values: FloatArray) -> tuple[Target, FloatArray]:
        """Return it as it is: coordinates count from the world."""
        return target, values
