"""Collision-free paths from stop to stop, the ballbar off, checked all along, and the order of stops.

*Between stops* joint motions through via points: a straight one first; then away from the fixture, straight
across, and down again; then a search by two trees of random motions that grow towards each other (J. J.
Kuffner, S. M. LaValle, RRT-Connect, Proc. IEEE ICRA, 2000, 995-1001), whose way is shortened afterwards.

*Where the arm waits* once all cups are clamped, off the cups, with the ball and the base sides in reach:
straight back from the last cup first, or up; where the arm cannot, one of the poses that follow will do:
their nests stand a ballbar's length from the cups.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from typing import Final, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.ballbar import PlannedAway
from truepose.planning.ballbar.bodies import chain_of
from truepose.planning.ballbar.clearance import bodies_at, hands_room_mm
from truepose.planning.ballbar.motion_clearance import (
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
    tuple of tuples of float
        Joint angles of the via points [rad], without start and end.

    Raises
    ------
    NoWayError
        None was found; the stops are in pockets of their own, or one of them is not clear.

    References
    ----------
    J. J. Kuffner, S. M. LaValle, Proc. IEEE ICRA, 2000, 995-1001 (RRT-Connect).
    """
    leaving, arriving = lift(around, start), lift(around, end)
    for ways in (_direct, _by_retreats, _by_search):
        inner = ways(around, leaving[-1], arriving[-1], rng)
        if inner is not None:
            points = [*leaving[1:], *inner, *arriving[:0:-1]]
            return tuple(tuple(float(q) for q in point) for point in points)
    raise NoWayError(
        "No collision-free path between two configurations was found. Move the base fixture away from the "
        "arm, or leave out one of the two configurations."
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
        # In turn, so that neither fills its pocket while the other stands still.
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
        """Go on towards a configuration until it is reached or the way is not clear.

        Returns the index of the point there, None where something is in the way. It ends: each step comes
        nearer by up to 0.6 rad of the joint that is farthest.
        """
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


Via: TypeAlias = tuple[tuple[float, ...], ...]


_TRIES: Final = 3  # stops to which a way is searched before they are given up


@dataclass(frozen=True, slots=True)
class Tour:
    """Stops in their order, each with the way from the one before.

    Attributes
    ----------
    order : tuple of int
        Rows, of those that a way leads to.
    vias : tuple of Via
        One a stop.
    missed : tuple of int
        Rows to which no clear way was found.
    """

    order: tuple[int, ...]
    vias: tuple[Via, ...]
    missed: tuple[int, ...]


def tour(
    around: Surroundings,
    joints_rad: FloatArray,
    groups: Sequence[Sequence[int]],
    here: Stop,
    rng: np.random.Generator,
) -> Tour:
    """Order stops by short motions, group after group, with the ways to them.

    Parameters
    ----------
    around : Surroundings
    joints_rad : ndarray, shape (n, J)
    groups : sequences of rows of `joints_rad`
        Those of one group are all visited before the next group.
    here : Stop
        Where the arm is.
    rng : numpy.random.Generator
        For the search for ways.

    Returns
    -------
    Tour
    """
    order: list[int] = []
    vias: list[Via] = []
    missed: list[int] = []
    for group in groups:
        left = list(group)
        while left:
            nearest = sorted(left, key=lambda row: _motion(joints_rad[row], here))[:_TRIES]
            found = _first_way(around, joints_rad, nearest, here, rng)
            if found is None:
                # A search that finds nothing runs through all its growths. All that were tried are given up
                # together, or each would be searched for again from every later stop.
                missed += nearest
                left = [row for row in left if row not in nearest]
                continue
            row, via = found
            left.remove(row)
            order.append(row)
            vias.append(via)
            here = Stop(joints_rad[row])
    return Tour(tuple(order), tuple(vias), tuple(missed))


def _motion(joints: FloatArray, here: Stop) -> float:
    return float(np.max(np.abs(joints - here.joints_rad)))


def _first_way(
    around: Surroundings, joints: FloatArray, rows: Sequence[int], here: Stop, rng: np.random.Generator
) -> tuple[int, Via] | None:
    for row in rows:
        try:
            return row, way(around, here, Stop(joints[row]), rng)
        except NoWayError:
            continue
    return None


# Free about cups and sides: two hands at a cup are comfortable; one gets through with the bar in it.
ROOMS_MM: Final = (100.0, 70.0)
_BACK_MM: Final = (120.0, 160.0, 200.0, 250.0, 300.0, 400.0)
_UP: Final = np.array([0.0, 0.0, 1.0])
_NEAREST_POSES: Final = 8  # that are tried


def away(around: Surroundings, held: Stop, poses_rad: FloatArray, rng: np.random.Generator) -> PlannedAway:
    """Return where the arm goes from the last set-up, and the way there.

    Parameters
    ----------
    around : Surroundings
    held : Stop
        The last set-up.
    poses_rad : ndarray, shape (n, J)
        Configurations of this placement, clear themselves.
    rng : numpy.random.Generator
        For the search for ways.

    Returns
    -------
    PlannedAway

    Raises
    ------
    NoWayError
        Wherever the arm can go from there, it leaves no room for the hands.
    """
    places = list(_candidates(around, held, poses_rad))
    rooms = [_room_mm(around, joints) for joints in places]
    # Room for two hands from any place goes before a place that is nearer and leaves room for one.
    for wanted in ROOMS_MM:
        for joints, room in zip(places, rooms, strict=True):
            via = _way_to(around, held, joints, rng) if room >= wanted else None
            if via is not None:
                return PlannedAway(tuple(float(q) for q in joints), via)
    raise NoWayError(
        f"The arm cannot retract from base point {held.base_point} of placement {around.fixture.number} far "
        f"enough to leave {ROOMS_MM[-1]:g} mm of clearance around the cups. Move the base fixture."
    )


def _candidates(around: Surroundings, held: Stop, poses_rad: FloatArray) -> Iterator[FloatArray]:
    axis = around.fixture.axes[(held.base_point or 1) - 1]
    for distance in _BACK_MM:
        for direction in (axis, _UP):
            moved = shifted(around.cell, held.joints_rad, distance * direction)
            if moved is not None:
                yield moved
    motion = np.abs(poses_rad - held.joints_rad).max(axis=1)
    yield from poses_rad[np.argsort(motion)[:_NEAREST_POSES]]


def _room_mm(around: Surroundings, joints: FloatArray) -> float:
    """Return how much room the hands have [mm]; none where the arm cannot be."""
    if not is_clear_along(around, joints[None]):
        return 0.0
    return float(hands_room_mm(bodies_at(around.cell, around.fixture, joints[None]))[0])


def _way_to(
    around: Surroundings, held: Stop, joints: FloatArray, rng: np.random.Generator
) -> tuple[tuple[float, ...], ...] | None:
    try:
        return way(around, held, Stop(joints), rng)
    except NoWayError:
        return None
