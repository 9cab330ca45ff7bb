"""Directions of the beam: horizontal angle, zenith angle [rad] and distance [mm] in the instrument frame."""

import math

import numpy as np

from truepose_simulators.physics.rigid import FloatArray

_TURNING_SPEED_RAD_S = math.pi / 2.0


def direction(position_mm: FloatArray) -> tuple[float, float]:
    """Return horizontal angle (right-handed from x) and zenith angle of a point."""
    x, y, z = position_mm.tolist()
    return math.atan2(y, x), math.atan2(math.hypot(x, y), z)


def point_at(horizontal_rad: float, zenith_rad: float, distance_mm: float) -> FloatArray:
    """Return the point in that direction at that distance, shape (3,)."""
    radius = distance_mm * math.sin(zenith_rad)
    height = distance_mm * math.cos(zenith_rad)
    return np.array([radius * math.cos(horizontal_rad), radius * math.sin(horizontal_rad), height])


def turning_time_s(from_mm: FloatArray, to_mm: FloatArray) -> float:
    """Return how long the head turns from one aim to another."""
    across = float(np.linalg.norm(np.cross(from_mm, to_mm)))
    return math.atan2(across, float(from_mm @ to_mm)) / _TURNING_SPEED_RAD_S
