"""How far a gauge is pushed in, by the geometry of what it touches. Pure: places in, travel out.

A probe's tip sits at its own centre when the gauge reads 0, and gives way along the probe's axis; what it
touches keeps it outside. None where nothing is touched at any travel.
"""

import math

import numpy as np

from truepose_simulators.physics.rigid import FloatArray


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


def seen_mm(sensor_mm: FloatArray, rotation: FloatArray, ball_mm: FloatArray, axis: int) -> float:
    """Return where a fixed ball is along one axis of a sensor in the tool; `rotation` is the tool's."""
    return float(rotation[:, axis] @ (ball_mm - sensor_mm))
