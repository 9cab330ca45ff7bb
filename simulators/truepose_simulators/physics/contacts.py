"""What the tool meets in a closed loop, and how far a gauge is pushed in by it.

A probe's tip sits at its own centre when the gauge reads 0, and gives way along the probe's axis; what it
touches keeps it outside. None where nothing is touched at any travel.

Everything is put into the frame of what stands still, or of what the tool carries, by rigid motions; what is
read then is a coordinate or a length there.
"""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from truepose_simulators.physics.rigid import FloatArray, inverse, motion, move


def probe_on_sphere_mm(tip_mm: FloatArray, axis: FloatArray, centre_mm: FloatArray, radii_mm: float) -> float:
    """Return how far a tip gives way to a sphere; `radii_mm` is of sphere and tip together.

    The tip at travel s is at tip - s axis. It leaves the sphere backwards, hence the larger root of
    |tip - s axis - centre| = radii. Not touched: minus infinity.
    """
    off = tip_mm - centre_mm
    along = float(axis @ off)
    inside = along**2 - float(off @ off) + radii_mm**2
    return along + math.sqrt(inside) if inside >= 0.0 else -math.inf


def probe_on_plane_mm(
    tip_mm: FloatArray, axis: FloatArray, point_mm: FloatArray, normal: FloatArray, radius_mm: float
) -> float:
    """Return how far a tip gives way to a plane, whose normal points away from it; a probe along it: none."""
    # (tip - s axis - point) . normal = radius, solved for s. An axis that does not point at the plane never
    # meets it.
    height = float((tip_mm - point_mm) @ normal) - radius_mm
    against = float(axis @ normal)
    return height / against if against < 0.0 else -math.inf


def ball_on_gauge_mm(
    ball_mm: FloatArray, rest_mm: FloatArray, direction: FloatArray, face_mm: float
) -> float:
    """Return how far a ball pushes a fixed gauge whose flat face, of radius `face_mm`, is at rest there."""
    off = ball_mm - rest_mm
    along = float(off @ direction)
    beside = float(np.linalg.norm(off - along * direction))
    return along if beside <= face_mm else -math.inf


def wire_mm(end_mm: FloatArray, drum_mm: FloatArray, zero_mm: float) -> float:
    """Return how far a wire is drawn out beyond the length at which it reads 0."""
    return float(np.linalg.norm(end_mm - drum_mm)) - zero_mm


def ball_position_mm(sensor_mm: FloatArray, rotation: FloatArray, ball_mm: FloatArray, axis: int) -> float:
    """Return where a fixed ball is along one axis of a sensor in the tool; `rotation` is the tool's."""
    return float(rotation[:, axis] @ (ball_mm - sensor_mm))


class Contact(Protocol):
    """What a reading is taken against."""

    def read_mm(self, last_frame: FloatArray, nest_mm: FloatArray) -> FloatArray:
        """Return true readings, shape (n, c), of n placements (n, 4, 4) of the flange frame.

        `nest_mm` (n, 3) is the nest in it; c is 1, or 3 of a sensor with three axes.
        """


@dataclass(frozen=True, slots=True)
class Sphere:
    """A sphere that is touched, or the place where a wire ends."""

    centre_mm: FloatArray  # (3,) world
    zero_mm: float  # distance of the nest from the centre that reads 0

    def read_mm(self, last_frame: FloatArray, nest_mm: FloatArray) -> FloatArray:
        """Return distances as the tool sees them, shape (n, 1)."""
        in_tool = move(inverse(last_frame), self.centre_mm)
        read: FloatArray = np.linalg.norm(in_tool - nest_mm, axis=1, keepdims=True) - self.zero_mm
        return read


@dataclass(frozen=True, slots=True)
class Plane:
    """A plane, or the flat face of a gauge: z of its frame is what is read."""

    frame: FloatArray  # (4, 4) in the world

    def read_mm(self, last_frame: FloatArray, nest_mm: FloatArray) -> FloatArray:
        """Return heights of the nest above the face, shape (n, 1)."""
        tool_on_face = inverse(self.frame) @ last_frame
        height: FloatArray = move(tool_on_face, nest_mm)[:, 2:]
        return height


@dataclass(frozen=True, slots=True)
class BallAtSensor:
    """A ball that three axes of a sensor look at, which sits in the nest."""

    centre_mm: FloatArray  # (3,) world
    sensor: FloatArray  # (3, 3) its axes in the flange frame, in columns

    def read_mm(self, last_frame: FloatArray, nest_mm: FloatArray) -> FloatArray:
        """Return where the ball is for the sensor, shape (n, 3)."""
        sensor = last_frame @ motion(nest_mm, self.sensor)
        return move(inverse(sensor), self.centre_mm)


@dataclass(frozen=True, slots=True)
class PlaneAtSensor:
    """A plane that a sensor in the nest looks at, along the z axis of the sensor."""

    frame: FloatArray  # (4, 4) of the plane in the world
    sensor: FloatArray  # (3, 3) its axes in the flange frame, in columns

    def read_mm(self, last_frame: FloatArray, nest_mm: FloatArray) -> FloatArray:
        """Return where the beam meets the plane, from the nest on, shape (n, 1); along it: infinite."""
        # In the frame of the plane the beam is at height z + s z' after s: it meets the plane where that is
        # 0.
        sensor = inverse(self.frame) @ last_frame @ motion(nest_mm, self.sensor)
        height, slope = sensor[:, 2, 3:], sensor[:, 2, 2:3]
        met: FloatArray = np.divide(-height, slope, out=np.full_like(height, np.inf), where=slope != 0.0)
        return met
