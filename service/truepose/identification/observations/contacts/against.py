"""What something that readings are taken against has to say of itself."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, Table
from truepose.domain.measurement.targets import Target
from truepose.effects.ports import ParameterSpec

PLACE_WIDTH_MM = 10.0  # about the start found from the data, as for an unknown base


@dataclass(frozen=True, slots=True)
class Probe(Table):
    """Where the tool was at n readings, world frame."""

    place_mm: FloatArray  # (n, 3) of its nest
    along: FloatArray  # (n, 3) unit vector of the sensor's axis, zeros of a reading that has none


@dataclass(frozen=True, slots=True)
class Slope:
    """How n predicted readings change."""

    place: FloatArray  # (n, 3) per mm of the tool nest
    turn: FloatArray  # (n, 3) per rad of the tool about its nest, axes of the world
    own: FloatArray  # (p, n) per unit of the target's own parameters


class Against(Protocol):
    """A kind of target; `values` (p,) are those of its parameters, in their order."""

    def parameters(self, target: Target, values: FloatArray) -> tuple[ParameterSpec, ...]:
        """Return the parameters of a target about the values where it was found."""
        ...

    def reading_mm(self, target: Target, values: FloatArray, probe: Probe) -> FloatArray:
        """Return what is read, shape (n,)."""
        ...

    def slope(self, target: Target, values: FloatArray, probe: Probe) -> Slope:
        """Return how it changes."""
        ...

    def started(self, target: Target, probe: Probe, reading_mm: FloatArray) -> tuple[Target, FloatArray]:
        """Return the target where readings (n,) of a nominal robot put it, and values to start from."""
        ...

    def centred(self, target: Target, values: FloatArray) -> tuple[Target, FloatArray]:
        """Return the same about where these values put it."""
        ...


def sensor_axes(end_rotation: FloatArray, axis: IntArray) -> FloatArray:
    """Return the axis of the sensor of each reading, shape (n, 3); zeros where it has none.

    Parameters
    ----------
    end_rotation : ndarray, shape (n, 3, 3)
        Orientation of the tool.
    axis : ndarray, shape (n,)
        0 to 2, or NO_AXIS.
    """
    along = end_rotation[np.arange(len(axis)), :, np.maximum(axis, 0)]
    return np.where((axis >= 0)[:, None], along, 0.0)
