"""Clear ways from stop to stop, the ballbar off: joint motions through via points, checked all along.

A straight joint motion first; then away from the fixture, straight across, and down again; then a search by
two trees of random motions that grow towards each other (J. J. Kuffner, S. M. LaValle, RRT-Connect, Proc.
IEEE ICRA, 2000, 995-1001), whose way is shortened afterwards. At a set-up the tool leaves the cup along the
cup's axis.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.planning.ballbar.clear_ways.bodies import chain_of
from truepose.planning.ballbar.clear_ways.short_moves import (
    RETREATS_MM,
    Stop,
    Surroundings,
    between,
    is_clear_along,
    lift,
    shifted,
)
from truepose.planning.errors import NoWayError

_LONGEST_GROWTH_RAD: Final = 0.6
_GROWTHS: Final = 400
_SHORTCUTS: Final = 40


def way(
    around: Surroundings, start: Stop, end: Stop, rng: np.random.Generator
) -> tuple[tuple[float, ...], ...]:
    """Return the via points between two stops, none where the straight joint motion is clear.

    Parameters
    ----------
    around : Surroundings
    start, end : Stop
        Both clear themselves.
    rng : numpy.random.Generator
        For the search, where simple ways are not clear.

    Returns
    -------
    tuple of joint angles [rad]

    Raises
    ------
    NoWayError
        None was found; the stops are in pockets of their own, or one of them is not clear.
    """
    leaving, arriving = lift(around, start), lift(around, end)
    for ways in (_direct, _by_retreats, _by_search):
        inner = ways(around, leaving[-1], arriving[-1], rng)
        if inner is not None:
            points = [*leaving[1:], *inner, *arriving[:0:-1]]
            return tuple(tuple(float(q) for q in point) for point in points)
    raise NoWayError(
        "No clear way was found between two stops: move the base fixture away from the arm, or leave one out."
    )


def _joins(around: Surroundings, points: Sequence[FloatArray]) -> bool:
    return all(is_clear_along(around, between(a, b)) for a, b in pairwise(points))


def _direct(
    around: Surroundings, start: FloatArray, end: FloatArray, rng: np.random.Generator
) -> list[FloatArray] | None:
    return [] if _joins(around, [start, end]) else None


def _by_retreats(
    around: Surroundings, start: FloatArray, end: FloatArray, rng: np.random.Generator
) -> list[FloatArray] | None:
    """Away from the fixture, across, and down again; the shortest retreats that do."""
    starts, ends = _retreats(around, start), _retreats(around, end)
    ways = sorted(product(starts, ends), key=lambda pair: pair[0][0] + pair[1][0])
    for (_, up), (_, down) in ways:
        if is_clear_along(around, between(up, down)):
            return [point for point in (up, down) if point is not start and point is not end]
    return None


def _retreats(around: Surroundings, joints: FloatArray) -> list[tuple[float, FloatArray]]:
    """How far the tool goes back from the fixture, and where it is then; not at all is one of them."""
    found = [(0.0, joints)]
    back = chain_of(around.cell, joints[None]).points(around.cell.nests_mm.mean(axis=0))[0]
    away = back - around.fixture.hub_mm
    away /= np.linalg.norm(away)
    for distance in RETREATS_MM:
        moved = shifted(around.cell, joints, distance * away)
        if moved is not None and is_clear_along(around, between(joints, moved)):
            found.append((distance, moved))
    return found


def _by_search(
    around: Surroundings, start: FloatArray, end: FloatArray, rng: np.random.Generator
) -> list[FloatArray] | None:
    """Two trees that grow towards each other and towards random configurations in turn."""
    trees = (_Tree([start], [-1]), _Tree([end], [-1]))
    low = np.array([limit.lower_rad for limit in around.cell.ranges])
    high = np.array([limit.upper_rad for limit in around.cell.ranges])
    for growth in range(_GROWTHS):
        here, there = trees[growth % 2], trees[(growth + 1) % 2]
        reached = here.grow(around, low + (high - low) * rng.random(len(low)))
        if reached is None:
            continue
        met = there.reach(around, here.points[reached])
        if met is not None:
            first, second = here.trunk(reached), there.trunk(met)
            path = first[::-1] + second[1:] if growth % 2 == 0 else second[::-1] + first[1:]
            return _shortened(around, path, rng)[1:-1]
    return None


@dataclass(frozen=True, slots=True)
class _Tree:
    """Configurations that are joined by clear motions; grows in place."""

    points: list[FloatArray]
    parents: list[int]

    def grow(self, around: Surroundings, towards: FloatArray) -> int | None:
        """Go one step towards a configuration; the new point's index, None where the step is not clear."""
        nearest = self._nearest(towards)
        step = towards - self.points[nearest]
        longest = float(np.max(np.abs(step)))
        point = self.points[nearest] + step * min(1.0, _LONGEST_GROWTH_RAD / max(longest, 1e-12))
        if not is_clear_along(around, between(self.points[nearest], point)):
            return None
        self.points.append(point)
        self.parents.append(nearest)
        return len(self.points) - 1

    def reach(self, around: Surroundings, goal: FloatArray) -> int | None:
        """Go on towards a configuration until it is reached or the way is not clear."""
        while True:
            index = self.grow(around, goal)
            if index is None:
                return None
            if np.allclose(self.points[index], goal, atol=1e-12):
                return index

    def _nearest(self, joints: FloatArray) -> int:
        apart = np.max(np.abs(np.array(self.points) - joints), axis=1)
        return int(np.argmin(apart))

    def trunk(self, index: int) -> list[FloatArray]:
        """Return the points from one to the root."""
        found = []
        while index >= 0:
            found.append(self.points[index])
            index = self.parents[index]
        return found


def _shortened(around: Surroundings, path: list[FloatArray], rng: np.random.Generator) -> list[FloatArray]:
    """Leave out points between which the straight motion is clear."""
    for _ in range(_SHORTCUTS):
        if len(path) < 3:
            break
        first, last = sorted(rng.choice(len(path), 2, replace=False).tolist())
        if last - first > 1 and is_clear_along(around, between(path[first], path[last])):
            path = path[: first + 1] + path[last:]
    return path
