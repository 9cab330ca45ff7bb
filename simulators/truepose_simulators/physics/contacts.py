"""What the tool meets in a closed loop: spheres, wires, flat faces, balls that a sensor looks at.

Everything is put into the frame of what stands still, or of what the tool carries, by rigid motions; what is
read then is a coordinate or a length there.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from truepose_simulators.physics.rigid import FloatArray, inverse, motion, move


class Met(Protocol):
    """What a reading is taken against."""

    def read_mm(self, last_frame: FloatArray, nest_mm: FloatArray) -> FloatArray:
        """Return true readings, shape (n, c), of n placements (n, 4, 4) of the last frame.

        `nest_mm` (n, 3) is the nest in it; c is 1, or 3 of a sensor with three axes.
        """
        ...


@dataclass(frozen=True, slots=True)
class Round:
    """A sphere that is touched, or the place where a wire ends."""

    centre_mm: FloatArray  # (3,) world
    zero_mm: float  # distance of the nest from the centre that reads 0

    def read_mm(self, last_frame: FloatArray, nest_mm: FloatArray) -> FloatArray:
        """Return distances as the tool sees them, shape (n, 1)."""
        in_tool = move(inverse(last_frame), self.centre_mm)
        read: FloatArray = np.linalg.norm(in_tool - nest_mm, axis=1, keepdims=True) - self.zero_mm
        return read


@dataclass(frozen=True, slots=True)
class Flat:
    """A plane, or the flat face of a gauge: z of its frame is what is read."""

    frame: FloatArray  # (4, 4) in the world

    def read_mm(self, last_frame: FloatArray, nest_mm: FloatArray) -> FloatArray:
        """Return heights of the nest above the face, shape (n, 1)."""
        tool_on_face = inverse(self.frame) @ last_frame
        height: FloatArray = move(tool_on_face, nest_mm)[:, 2:]
        return height


@dataclass(frozen=True, slots=True)
class Seen:
    """A ball that three axes of a sensor look at, which sits in the nest."""

    centre_mm: FloatArray  # (3,) world
    sensor: FloatArray  # (3, 3) its axes in the last frame, in columns

    def read_mm(self, last_frame: FloatArray, nest_mm: FloatArray) -> FloatArray:
        """Return where the ball is for the sensor, shape (n, 3)."""
        sensor = last_frame @ motion(nest_mm, self.sensor)
        return move(inverse(sensor), self.centre_mm)


@dataclass(frozen=True, slots=True)
class Ranged:
    """A plane that a sensor in the nest looks at, along the z axis of the sensor."""

    frame: FloatArray  # (4, 4) of the plane in the world
    sensor: FloatArray  # (3, 3) its axes in the last frame, in columns

    def read_mm(self, last_frame: FloatArray, nest_mm: FloatArray) -> FloatArray:
        """Return where the beam meets the plane, from the nest on, shape (n, 1)."""
        sensor = inverse(self.frame) @ last_frame @ motion(nest_mm, self.sensor)
        met: FloatArray = -sensor[:, 2, 3:] / sensor[:, 2, 2:3]
        return met
