"""Distances between round bars, and from them to keep-out volumes: bodies are capsules with a radius.

A capsule set holds m capsules at n configurations; those that do not move have n = 1. All lengths are in mm.

    capsule to capsule    |segment 1, segment 2| - r_1 - r_2
    capsule to volume     min over the segment of s(x) - r,  s the signed distance of a point to the volume

Every volume is convex, so its signed distance is a convex function along a segment: the least of it is found
by narrowing an interval (golden section; J. Kiefer, Proc. American Mathematical Society 4, 1953, 502-506).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Final, assert_never

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.cell import Box, Cylinder, HalfSpace, KeepOut, KeepOuts

_TINY_MM2: Final = 1e-12  # squared length below which a segment is a point
_PARALLEL: Final = 1e-12  # squared sine between segments, below which rounding says where they are nearest


@dataclass(frozen=True, slots=True)
class Capsules:
    """Segments with radii.

    Attributes
    ----------
    start_mm, end_mm : ndarray, shape (m, n, 3)
        Ends of the segments, all of a set in the same frame.
    radius_mm : ndarray, shape (m,)
        One for all configurations.
    """

    start_mm: FloatArray
    end_mm: FloatArray
    radius_mm: FloatArray

    def __len__(self) -> int:
        return len(self.radius_mm)

    def at(self, rows: IntArray | slice) -> "Capsules":
        """Return the capsules at some of the configurations, indices or a slice."""
        return Capsules(self.start_mm[:, rows], self.end_mm[:, rows], self.radius_mm)

    def some(self, members: Sequence[int]) -> "Capsules":
        """Return some of the capsules, by their indices."""
        chosen = list(members)
        return Capsules(self.start_mm[chosen], self.end_mm[chosen], self.radius_mm[chosen])


def join_capsules(sets: Sequence[Capsules]) -> Capsules:
    """Return the capsules of several sets at the same configurations.

    Parameters
    ----------
    sets : sequence of Capsules
        Each with n configurations or with one, which then counts for all n.

    Returns
    -------
    Capsules
        In the order of the sets.

    Raises
    ------
    ValueError
        Two sets have different numbers of configurations, both above 1.
    """
    (n,) = np.broadcast_shapes(*((each.start_mm.shape[1],) for each in sets))

    def spread(points: FloatArray) -> FloatArray:
        return np.broadcast_to(points, (len(points), n, 3))

    return Capsules(
        np.concatenate([spread(each.start_mm) for each in sets]),
        np.concatenate([spread(each.end_mm) for each in sets]),
        np.concatenate([each.radius_mm for each in sets]),
    )


def still(segments: Sequence[tuple[FloatArray, FloatArray]], radius_mm: float) -> Capsules:
    """Return capsules that do not move.

    Parameters
    ----------
    segments : sequence of pairs of ndarray, shape (3,)
        Both ends of each [mm].
    radius_mm : float
        Of all of them.

    Returns
    -------
    Capsules
        At one configuration.
    """
    start = np.array([first for first, _ in segments]).reshape(-1, 1, 3)
    end = np.array([second for _, second in segments]).reshape(-1, 1, 3)
    return Capsules(start, end, np.full(len(segments), radius_mm))


def gaps(first: Capsules, second: Capsules) -> FloatArray:
    """Return the gap between every two capsules of two sets.

    Parameters
    ----------
    first, second : Capsules
        m1 and m2 capsules at n configurations, or at one.

    Returns
    -------
    ndarray, shape (m1, m2, n)
        [mm]; negative by how far they overlap.
    """
    distance = segment_distances(
        first.start_mm[:, None], first.end_mm[:, None], second.start_mm[None], second.end_mm[None]
    )
    return np.asarray(distance - first.radius_mm[:, None, None] - second.radius_mm[None, :, None])


def smallest_gap(first: Capsules, second: Capsules) -> FloatArray:
    """Return the smallest free space between two sets.

    Parameters
    ----------
    first, second : Capsules
        At n configurations, or at one.

    Returns
    -------
    ndarray, shape (n,)
        [mm]; negative where they overlap, inf where one set is empty.
    """
    if not len(first) or not len(second):
        (n,) = np.broadcast_shapes(first.start_mm.shape[1:2], second.start_mm.shape[1:2])
        return np.full(n, np.inf)
    return np.asarray(gaps(first, second).min(axis=(0, 1)))


def smallest_gap_of_pairs(first: Capsules, second: Capsules) -> FloatArray:
    """Return the smallest free space of each capsule to its partner.

    Parameters
    ----------
    first, second : Capsules
        m each, at n configurations; capsule k of the one is held against k of the other.

    Returns
    -------
    ndarray, shape (n,)
        [mm]; inf without any pair.
    """
    distance = segment_distances(first.start_mm, first.end_mm, second.start_mm, second.end_mm)
    free = distance - first.radius_mm[:, None] - second.radius_mm[:, None]
    return np.asarray(free.min(axis=0, initial=np.inf))


def lowest_mm(capsules: Capsules) -> FloatArray:
    """Return the height of the lowest point of a set.

    Parameters
    ----------
    capsules : Capsules
        At n configurations.

    Returns
    -------
    ndarray, shape (n,)
        z [mm]; inf of an empty set.
    """
    ends = np.minimum(capsules.start_mm[..., 2], capsules.end_mm[..., 2])
    return np.asarray((ends - capsules.radius_mm[:, None]).min(axis=0, initial=np.inf))


def segment_distances(p1: FloatArray, q1: FloatArray, p2: FloatArray, q2: FloatArray) -> FloatArray:
    """Return the distances of segments p1 q1 and p2 q2, points and parallel segments included.

    With d1, d2 their ways and r = p1 - p2, a = d1.d1, e = d2.d2, b = d1.d2, c = d1.r, f = d2.r, the nearest
    points p1 + s d1 and p2 + t d2 of the lines have s = (b f - c e) / (a e - b^2); then in turn, each clamped
    to [0, 1],

        t = (b s + f) / e        s = (b t - c) / a

    Parameters
    ----------
    p1, q1, p2, q2 : ndarray, shape (..., 3)
        Ends [mm], broadcast against each other.

    Returns
    -------
    ndarray, shape (...)
        [mm].

    References
    ----------
    C. Ericson, Real-Time Collision Detection, 2005, section 5.1.9.
    """
    way1, way2, between = q1 - p1, q2 - p2, p1 - p2
    a, e, b = _dot(way1, way1), _dot(way2, way2), _dot(way1, way2)
    c, f = _dot(way1, between), _dot(way2, between)
    safe_a, safe_e = np.maximum(a, _TINY_MM2), np.maximum(e, _TINY_MM2)
    # Of parallel lines any s will do: t, and s once more, are then the nearest beside it.
    denominator = a * e - b * b
    crossing = denominator > _PARALLEL * safe_a * safe_e
    s = np.where(crossing, (b * f - c * e) / np.where(crossing, denominator, 1.0), 0.0)
    s = np.clip(s, 0.0, 1.0)
    t = np.clip((b * s + f) / safe_e, 0.0, 1.0)
    s = np.clip((b * t - c) / safe_a, 0.0, 1.0)
    nearest = between + s[..., None] * way1 - t[..., None] * way2
    return np.asarray(np.sqrt(_dot(nearest, nearest)))


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("...i,...i->...", first, second))


_NARROWINGS: Final = 14  # to a thousandth of a segment: a third of a millimetre of a link
_FAR_MM: Final = 200.0
_GOLDEN: Final = (np.sqrt(5.0) - 1.0) / 2.0


def signed_mm(volume: KeepOut, points_mm: FloatArray) -> FloatArray:
    """Return the signed distances of points to a volume.

    Parameters
    ----------
    volume : Box, Cylinder or HalfSpace
        In the world.
    points_mm : ndarray, shape (..., 3)
        In the world.

    Returns
    -------
    ndarray, shape (...)
        [mm]; negative inside, there the distance to the nearest face.
    """
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
    """Return the signed distances of points (..., 3) to a round bar with flat ends.

    In the plane of its axis and the point it is a box: beyond by (beside - r, |along| - l / 2).
    """
    way = np.subtract(volume.end_mm, volume.start_mm)
    length = float(np.linalg.norm(way))
    from_middle = points_mm - volume.start_mm - way / 2.0
    along = from_middle @ (way / length)
    beside = np.sqrt(np.maximum(np.einsum("...i,...i", from_middle, from_middle) - along**2, 0.0))
    return _signed([beside - volume.radius_mm, np.abs(along) - length / 2.0])


def _signed(beyond: Sequence[FloatArray]) -> FloatArray:
    """Return the signed distance from how far points are beyond each pair of sides at right angles.

    |max(b, 0)| + min(max_k b_k, 0): outside the way to the nearest corner, edge or face, inside to the
    nearest face. Source: own derivation, the distance to a product of intervals.
    """
    outside = np.sqrt(sum(np.maximum(one, 0.0) ** 2 for one in beyond))
    return np.asarray(outside + np.minimum(reduce(np.maximum, beyond), 0.0))


def least_mm(volume: KeepOut, start_mm: FloatArray, end_mm: FloatArray) -> FloatArray:
    """Return the least signed distance on segments to a volume.

    Parameters
    ----------
    volume : Box, Cylinder or HalfSpace
    start_mm, end_mm : ndarray, shape (m, n, 3)
        In the world.

    Returns
    -------
    ndarray, shape (m, n)
        [mm]. Of segments that are farther than 0.2 m off a bound below, which says that they are: no body of
        an arm is thicker.
    """
    # Linear along a segment: one of its ends is the nearest point.
    if isinstance(volume, HalfSpace):
        return np.minimum(signed_mm(volume, start_mm), signed_mm(volume, end_mm))
    middle, half = (start_mm + end_mm) / 2.0, np.linalg.norm(end_mm - start_mm, axis=-1) / 2.0
    # A distance changes by no more than the way: what is far at the middle needs no search.
    least: FloatArray = signed_mm(volume, middle) - half
    near = least < _FAR_MM
    start, way = np.broadcast_to(start_mm, middle.shape)[near], (end_mm - start_mm)[near]
    least[near] = _least(lambda share: signed_mm(volume, start + share[:, None] * way), len(way))
    return least


def _least(at: Callable[[FloatArray], FloatArray], n: int) -> FloatArray:
    """Return the least of n convex functions on [0, 1], shape (n,), by golden section.

    `at` gives their values (n,) at places (n,). The ends are looked at too, as the least often lies there.
    """
    left, width = np.zeros(n), 1.0
    # A golden section comes near an end and never reaches it.
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
    """Return the gap of each capsule to a volume.

    Parameters
    ----------
    volume : Box, Cylinder or HalfSpace
    bodies : Capsules
        m at n configurations.

    Returns
    -------
    ndarray, shape (m, n)
        [mm]; negative where it would enter. Exact where it is below 0.2 m less the radius, else a bound
        below.
    """
    return np.asarray(least_mm(volume, bodies.start_mm, bodies.end_mm) - bodies.radius_mm[:, None])


def look_at(keep_outs: KeepOuts) -> str:
    """Return the part of a refusal that names what else to look at, empty where there are no volumes."""
    return f" Check the keep-out volumes as well: {', '.join(keep_outs.names)}." if keep_outs else ""
