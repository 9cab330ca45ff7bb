"""Distances between round bars: every body of the cell is looked at as capsules, segments with a radius.

A capsule set holds m capsules at n configurations; those that do not move have n = 1.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray

_TINY_MM2: Final = 1e-12  # squared length below which a segment is a point


@dataclass(frozen=True, slots=True)
class Capsules:
    """Segments with radii."""

    start_mm: FloatArray  # (m, n, 3)
    end_mm: FloatArray  # (m, n, 3)
    radius_mm: FloatArray  # (m,)

    def __len__(self) -> int:
        return len(self.radius_mm)

    def at(self, rows: IntArray | slice) -> "Capsules":
        """Return the capsules at some of the configurations."""
        return Capsules(self.start_mm[:, rows], self.end_mm[:, rows], self.radius_mm)

    def some(self, members: Sequence[int]) -> "Capsules":
        """Return some of the capsules."""
        chosen = list(members)
        return Capsules(self.start_mm[chosen], self.end_mm[chosen], self.radius_mm[chosen])


def joined(sets: Sequence[Capsules]) -> Capsules:
    """Return the capsules of several sets at the same configurations."""
    (n,) = np.broadcast_shapes(*((each.start_mm.shape[1],) for each in sets))

    def spread(points: FloatArray) -> FloatArray:
        return np.broadcast_to(points, (len(points), n, 3))

    return Capsules(
        np.concatenate([spread(each.start_mm) for each in sets]),
        np.concatenate([spread(each.end_mm) for each in sets]),
        np.concatenate([each.radius_mm for each in sets]),
    )


def still(segments: Sequence[tuple[FloatArray, FloatArray]], radius_mm: float) -> Capsules:
    """Return capsules that do not move, from pairs of points (3,)."""
    start = np.array([first for first, _ in segments]).reshape(-1, 1, 3)
    end = np.array([second for _, second in segments]).reshape(-1, 1, 3)
    return Capsules(start, end, np.full(len(segments), radius_mm))


def gaps(first: Capsules, second: Capsules) -> FloatArray:
    """Return the gap between every two capsules [mm], shape (m1, m2, n); negative where they overlap."""
    distance = segment_distances(
        first.start_mm[:, None], first.end_mm[:, None], second.start_mm[None], second.end_mm[None]
    )
    return np.asarray(distance - first.radius_mm[:, None, None] - second.radius_mm[None, :, None])


def smallest_gap(first: Capsules, second: Capsules) -> FloatArray:
    """Return the smallest free space between two sets [mm], shape (n,); inf where one is empty."""
    if not len(first) or not len(second):
        (n,) = np.broadcast_shapes(first.start_mm.shape[1:2], second.start_mm.shape[1:2])
        return np.full(n, np.inf)
    return np.asarray(gaps(first, second).min(axis=(0, 1)))


def smallest_gap_of_pairs(first: Capsules, second: Capsules) -> FloatArray:
    """Return the smallest free space between each capsule and its partner [mm], shape (n,)."""
    distance = segment_distances(first.start_mm, first.end_mm, second.start_mm, second.end_mm)
    return np.asarray((distance - first.radius_mm[:, None] - second.radius_mm[:, None]).min(axis=0))


def lowest_mm(capsules: Capsules) -> FloatArray:
    """Return the height of the lowest point of the set [mm], shape (n,)."""
    ends = np.minimum(capsules.start_mm[..., 2], capsules.end_mm[..., 2])
    return np.asarray((ends - capsules.radius_mm[:, None]).min(axis=0))


def segment_distances(p1: FloatArray, q1: FloatArray, p2: FloatArray, q2: FloatArray) -> FloatArray:
    """Return the distances of segments p1 q1 and p2 q2 [mm], broadcast, without the last axis.

    The nearest points of the two lines, each clamped to its segment (C. Ericson, Real-Time Collision
    Detection, 2005, section 5.1.9); points and parallel segments included.
    """
    way1, way2, between = q1 - p1, q2 - p2, p1 - p2
    a, e, b = _dot(way1, way1), _dot(way2, way2), _dot(way1, way2)
    c, f = _dot(way1, between), _dot(way2, between)
    safe_a, safe_e = np.maximum(a, _TINY_MM2), np.maximum(e, _TINY_MM2)
    denominator = a * e - b * b
    s = np.where(denominator > _TINY_MM2, (b * f - c * e) / np.maximum(denominator, _TINY_MM2), 0.0)
    s = np.clip(s, 0.0, 1.0)
    t = np.clip((b * s + f) / safe_e, 0.0, 1.0)
    s = np.clip((b * t - c) / safe_a, 0.0, 1.0)
    nearest = between + s[..., None] * way1 - t[..., None] * way2
    return np.asarray(np.sqrt(_dot(nearest, nearest)))


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    return np.asarray(np.einsum("...i,...i->...", first, second))
