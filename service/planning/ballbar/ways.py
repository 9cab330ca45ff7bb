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

from service.domain.arrays import FloatArray
from service.kinematics.inverse import all_branches, brought_within
from service.planning.ballbar.bodies import BallbarCell, chain_of, pose_in_base
from service.planning.ballbar.clearance import Scene, arm_room_mm, scene
from service.planning.ballbar.fixture import BaseFixture
from service.planning.ballbar.setups import without_cups
from service.planning.errors import NoWayError

_CHECK_RAD: Final = float(np.radians(2.0))  # between two checks; a nest then moves by 30 mm at most
_RETREATS_MM: Final = (60.0, 120.0, 200.0)
_SAME_BRANCH_RAD: Final = 1.0  # a retreat that turns a joint by more is another branch
_LONGEST_GROWTH_RAD: Final = 0.6
_GROWTHS: Final = 400
_SHORTCUTS: Final = 40


@dataclass(frozen=True, slots=True)
class Stop:
    """A configuration where the arm stops; at a set-up, which cup the tool touches there."""

    joints_rad: FloatArray  # (J,)
    base_point: int | None = None


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What the arm moves among."""

    cell: BallbarCell
    fixture: BaseFixture


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


def lift(around: Surroundings, stop: Stop) -> list[FloatArray]:
    """Return the stop, and at a set-up the configuration where the tool has left the cup along its axis.

    Raises
    ------
    NoWayError
        The tool cannot leave the cup.
    """
    if stop.base_point is None:
        return [stop.joints_rad]
    axis = around.fixture.axes[stop.base_point - 1]
    for distance in _RETREATS_MM:
        lifted = _shifted(around.cell, stop.joints_rad, distance * axis)
        if lifted is not None and _lifts_clear(around, stop, lifted):
            return [stop.joints_rad, lifted]
    raise NoWayError(
        f"The tool cannot leave base point {stop.base_point} of placement {around.fixture.number} along the "
        "cup's axis: place the base fixture elsewhere."
    )


def _lifts_clear(around: Surroundings, stop: Stop, lifted: FloatArray) -> bool:
    """Whether the lift is clear but for the cups that part, and its end altogether."""
    if not is_clear_along(around, lifted[None]):
        return False
    bodies = scene(around.cell, around.fixture, between(stop.joints_rad, lifted))
    return _roomy(around, without_cups(bodies, int(stop.base_point or 0)))


def is_clear_along(around: Surroundings, joints_rad: FloatArray) -> bool:
    """Whether all configurations (n, J) are clear and within the ranges."""
    _, within = brought_within(joints_rad, around.cell.ranges)
    if not within.all():
        return False
    return _roomy(around, scene(around.cell, around.fixture, joints_rad))


def _roomy(around: Surroundings, bodies: Scene) -> bool:
    return bool((arm_room_mm(bodies) >= around.cell.arm_room_mm - _ROUNDING_MM).all())


_ROUNDING_MM: Final = 1e-6  # stops that just keep their room keep it still after a turn of their joints


def between(start: FloatArray, end: FloatArray) -> FloatArray:
    """Return the configurations that are looked at along a straight joint motion, both ends included."""
    steps = max(1, int(np.ceil(np.max(np.abs(end - start)) / _CHECK_RAD)))
    share = np.linspace(0.0, 1.0, steps + 1)[:, None]
    return np.asarray((1.0 - share) * start + share * end)


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
    for distance in _RETREATS_MM:
        moved = _shifted(around.cell, joints, distance * away)
        if moved is not None and is_clear_along(around, between(joints, moved)):
            found.append((distance, moved))
    return found


def _shifted(cell: BallbarCell, joints: FloatArray, shift_mm: FloatArray) -> FloatArray | None:
    """Joints on the same branch with the tool shifted in the world; None where there are none."""
    chain = chain_of(cell, joints[None])
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = chain.end_rotation[0], chain.end_origin[0] + shift_mm
    found = all_branches(cell.robot, pose_in_base(cell, pose[None]))[0]
    turned = found - 2 * np.pi * np.round((found - joints) / (2 * np.pi))
    apart = np.where(np.isnan(turned).any(axis=1), np.inf, np.abs(turned - joints).max(axis=1))
    best = int(np.argmin(apart))
    if apart[best] > _SAME_BRANCH_RAD:
        return None
    low = np.array([limit.lower_rad for limit in cell.ranges])
    high = np.array([limit.upper_rad for limit in cell.ranges])
    return turned[best] if bool(np.all((turned[best] >= low) & (turned[best] <= high))) else None


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
