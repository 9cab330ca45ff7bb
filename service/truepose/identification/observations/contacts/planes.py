"""A plane that a probe touches, and a fixed gauge whose flat face a ball pushes: distances along a normal.

With the nest at P, a point Q of the plane and its normal n, tilted by slopes a and b about a start n0,

    reading = n . (P - Q) - s,    n = (n0 + a t1 + b t2) / |n0 + a t1 + b t2|

with t1 and t2 across n0, and s the shift of the plane, in which the gauge's zero is. A gauge of a flat face
reads the same: its face is the plane, its axis the normal.

Source: H. Zhuang, S. H. Motaghedi, Z. S. Roth, Robot calibration with planar constraints, ICRA 1999 (one
plane is seldom enough, three are as good as points); three perpendicular gauges: future work of the thesis of
A. Nubiola, 2014.
"""

from dataclasses import replace

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.targets import Target
from truepose.effects.ports import ParameterSpec
from truepose.identification.observations.contacts.against import PLACE_WIDTH_MM, Probe, Slope

# A gauge of a few millimetres' travel finds its direction to some degrees from a nominal robot's places.
_SLOPE_WIDTH = 0.3


class Plane:
    """Shift and two slopes of a plane about where it was found."""

    def parameters(self, target: Target, values: FloatArray) -> tuple[ParameterSpec, ...]:
        """Return the shift along the normal, and two slopes."""
        shift, first, second = values.tolist()
        return (
            ParameterSpec("shift", "mm", shift, PLACE_WIDTH_MM),
            ParameterSpec("slope1", "1", first, _SLOPE_WIDTH),
            ParameterSpec("slope2", "1", second, _SLOPE_WIDTH),
        )

    def reading_mm(self, target: Target, values: FloatArray, probe: Probe) -> FloatArray:
        """Return the distances from the plane."""
        normal, _ = tilted(target, values)
        return np.asarray((probe.place_mm - point_of(target)) @ normal - values[0])

    def slope(self, target: Target, values: FloatArray, probe: Probe) -> Slope:
        """Return the normal, and what tilting it does."""
        normal, across = tilted(target, values)
        arm = probe.place_mm - point_of(target)
        own = np.vstack([np.full(len(arm), -1.0), across @ arm.T])
        place = np.broadcast_to(normal, arm.shape)
        return Slope(place, np.zeros_like(arm), own)

    def started(self, target: Target, probe: Probe, reading_mm: FloatArray) -> tuple[Target, FloatArray]:
        """Return the plane through the middle of the places; its normal is the one that fits best."""
        middle = np.median(probe.place_mm, axis=0)
        off = probe.place_mm - middle
        told = target.normal
        normal = _best_normal(off, reading_mm) if told is None else np.array(told) / np.linalg.norm(told)
        x, y, z = middle.tolist()
        nx, ny, nz = normal.tolist()
        shift = float(np.median(off @ normal - reading_mm))
        return replace(target, place_mm=(x, y, z), normal=(nx, ny, nz)), np.array([shift, 0.0, 0.0])

    def centred(self, target: Target, values: FloatArray) -> tuple[Target, FloatArray]:
        """Return it about the normal as it is tilted."""
        nx, ny, nz = tilted(target, values)[0].tolist()
        return replace(target, normal=(nx, ny, nz)), np.array([values[0], 0.0, 0.0])


def point_of(target: Target) -> FloatArray:
    """Return the point that a plane's shift counts from, shape (3,) [mm, world frame]."""
    return np.zeros(3) if target.place_mm is None else np.array(target.place_mm)


def tilted(target: Target, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the normal, shape (3,), and its change per slope, shape (2, 3)."""
    start = np.array([0.0, 0.0, 1.0]) if target.normal is None else np.array(target.normal)
    start = start / np.linalg.norm(start)
    beside = np.eye(3)[int(np.argmin(np.abs(start)))]
    first = np.cross(beside, start)
    first /= np.linalg.norm(first)
    axes = np.stack([first, np.cross(start, first)])
    tilted = start + values[1:3] @ axes
    length = float(np.linalg.norm(tilted))
    normal = tilted / length
    return normal, (axes - np.outer(axes @ normal, normal)) / length


def _best_normal(off_mm: FloatArray, reading_mm: FloatArray) -> FloatArray:
    """Return the direction along which places (n, 3) vary as the readings do.

    Readings that hardly vary say that the places lie in the plane; those of a gauge grow along its axis.
    """
    flattest = np.linalg.svd(off_mm - off_mm.mean(axis=0), full_matrices=False)[2][-1]
    design = np.column_stack([off_mm, np.ones(len(off_mm))])
    growing = np.linalg.lstsq(design, reading_mm, rcond=1e-9)[0][:3]
    candidates = [flattest, -flattest]
    if np.linalg.norm(growing) > 0.0:
        candidates.append(growing / np.linalg.norm(growing))

    def spread(normal: FloatArray) -> float:
        left = off_mm @ normal - reading_mm
        return float(np.median(np.abs(left - np.median(left))))

    return min(candidates, key=spread)
