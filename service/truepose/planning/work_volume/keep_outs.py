"""How far bodies of the arm are from keep-out volumes.

Every volume is convex, so its signed distance is a convex function along a segment: the least of it is found
by narrowing an interval (golden section). Capsules are segments with a radius.
"""

from collections.abc import Callable, Sequence
from functools import reduce
from typing import Final, assert_never

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.cell.keep_outs import Box, Cylinder, HalfSpace, KeepOut, KeepOuts
from truepose.planning.ballbar.clear_ways.capsules import Capsules

_NARROWINGS: Final = 14  # to a thousandth of a segment: a third of a millimetre of a link
_FAR_MM: Final = 200.0
_GOLDEN: Final = (np.sqrt(5.0) - 1.0) / 2.0


def signed_mm(volume: KeepOut, points_mm: FloatArray) -> FloatArray:
    """Return the distances of points (..., 3) to a volume, negative inside, without the last axis."""
    match volume:
        case Box():
            low, high = np.array(volume.lower_mm), np.array(volume.upper_mm)
            beyond = np.abs(points_mm - (low + high) / 2.0) - (high - low) / 2.0
            return _signed([beyond[..., axis] for axis in range(3)])
        case Cylinder():
            return _of_cylinder(volume, points_mm)
        case HalfSpace():
            outward = np.array(volume.outward) / np.linalg.norm(volume.outward)
            return np.asarray((points_mm - np.array(volume.point_mm)) @ outward)
    assert_never(volume)


def _of_cylinder(volume: Cylinder, points_mm: FloatArray) -> FloatArray:
    way = np.subtract(volume.end_mm, volume.start_mm)
    length = float(np.linalg.norm(way))
    from_middle = points_mm - volume.start_mm - way / 2.0
    along = from_middle @ (way / length)
    beside = np.sqrt(np.maximum(np.einsum("...i,...i", from_middle, from_middle) - along**2, 0.0))
    return _signed([beside - volume.radius_mm, np.abs(along) - length / 2.0])


def _signed(beyond: Sequence[FloatArray]) -> FloatArray:
    """Return the signed distance from how far points are beyond each pair of sides at right angles."""
    outside = np.sqrt(sum(np.maximum(one, 0.0) ** 2 for one in beyond))
    return np.asarray(outside + np.minimum(reduce(np.maximum, beyond), 0.0))


def least_mm(volume: KeepOut, start_mm: FloatArray, end_mm: FloatArray) -> FloatArray:
    """Return the least signed distance on segments (m, n, 3) to a volume, shape (m, n).

    Of segments that are farther than 0.2 m off, only that they are: no body of an arm is thicker.
    """
    if isinstance(volume, HalfSpace):
        return np.minimum(signed_mm(volume, start_mm), signed_mm(volume, end_mm))
    middle, half = (start_mm + end_mm) / 2.0, np.linalg.norm(end_mm - start_mm, axis=-1) / 2.0
    least: FloatArray = signed_mm(volume, middle) - half
    near = least < _FAR_MM
    start, way = np.broadcast_to(start_mm, middle.shape)[near], (end_mm - start_mm)[near]
    least[near] = _least(lambda share: signed_mm(volume, start + share[:, None] * way), len(way))
    return least


def _least(at: Callable[[FloatArray], FloatArray], n: int) -> FloatArray:
    """Return the least of n convex functions on [0, 1], by golden section."""
    left, width = np.zeros(n), 1.0
    ends = np.minimum(at(left), at(left + 1.0))
    first, second = at(left + 1.0 - _GOLDEN), at(left + _GOLDEN)
    for _ in range(_NARROWINGS):
        later = first > second
        left = np.where(later, left + (1.0 - _GOLDEN) * width, left)
        width *= _GOLDEN
        new = at(left + np.where(later, _GOLDEN, 1.0 - _GOLDEN) * width)
        first, second = np.where(later, second, new), np.where(later, new, first)
    return np.minimum(ends, np.minimum(first, second))


def gaps_mm(volume: KeepOut, bodies: Capsules) -> FloatArray:
    """Return the gap of each capsule to a volume [mm], shape (m, n); negative where it would enter."""
    return np.asarray(least_mm(volume, bodies.start_mm, bodies.end_mm) - bodies.radius_mm[:, None])


def look_at(keep_outs: KeepOuts) -> str:
    """Return the part of a refusal that names what else to look at, empty where there are no volumes."""
    return f" Look at the keep-out volumes as well: {', '.join(keep_outs.names)}." if keep_outs else ""
