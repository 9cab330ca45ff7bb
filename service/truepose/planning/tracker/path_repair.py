"""Collision-free paths of chosen plans: orders whose ways are clear of all bodies, and repairs.

An order that keeps off the table (`pose_order`) knows the table only. What the bodies by which given paths
are judged (`workspace.bodies`) still say touches is mended with the least change: a stop of such a way moves
elsewhere, or changes places with another; where none of that helps, another configuration takes its place. A
plan that is clear stays as it is.

A way is a pair of rows of a pool: from the one to the approach of the other and to it. The pair of a row with
itself leads to its approach and back, so it also stands for a first way that comes from nobody knows where.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice, pairwise
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.messages.message import Text, message, together
from truepose.planning.errors import NoWayError
from truepose.planning.workspace.bodies import CellBodies, bodies_in
from truepose.planning.workspace.path_clearance import Ways, contact_sentence, least_rooms_mm
from truepose.planning.workspace.space import WorkSpace

_KEPT_MM: Final = (10.0, 0.0)  # wanted on new ways, as round arm and tool in ballbar plans; else no touch
_NEXT: Final = 4  # stops that are looked at together as the next one
_NEAREST: Final = 40  # places that a stop is tried at
_SUBSTITUTES: Final = 200  # configurations that are tried in the place of one
_AT_ONCE: Final = 10  # changed orders whose ways are looked at together
_MOST_TRIED: Final = 3000  # changed orders before a cell is given up: some seconds
_Way = tuple[int, int]
Allowed = Callable[[Sequence[int]], bool]
Substitutes = Callable[[Sequence[int], int], IntArray]  # of an order and a place in it: rows, best first


@dataclass(frozen=True, slots=True)
class Pool:
    """Configurations that stops are chosen from, and what is known of the ways between them.

    Attributes
    ----------
    bodies : CellBodies
    joints_rad : ndarray, shape (N, J)
    approach_offset_rad : float
        Added to all joints where an approach begins.
    rooms_mm : dict
        Least room of the ways looked at so far, by their pair of rows; it grows in place.
    """

    bodies: CellBodies
    joints_rad: FloatArray
    approach_offset_rad: float
    rooms_mm: dict[_Way, float] = field(default_factory=dict)

    def look_at(self, ways: Iterable[_Way]) -> None:
        """Find out the room on ways, pairs of rows, each once however often it is asked."""
        new = [way for way in dict.fromkeys(ways) if way not in self.rooms_mm]
        if not new:
            return
        legs = self.legs(new)
        least = least_rooms_mm(self.bodies, legs).reshape(2, len(new)).min(axis=0)
        self.rooms_mm.update(zip(new, least.tolist(), strict=True))

    def legs(self, ways: Sequence[_Way]) -> Ways:
        """Return the motions to the approaches, and after all of them those from there.

        Parameters
        ----------
        ways : sequence of pairs of int
            k of them.

        Returns
        -------
        Ways
            2 k motions, without names.
        """
        start, end = self.joints_rad[np.array(ways).T]
        approach = end + self.approach_offset_rad
        return Ways((), np.vstack([start, approach]), np.vstack([approach, end]))

    def stand(self, rows: IntArray, kept_mm: float) -> BoolArray:
        """Return which configurations have that room themselves, and on the way from their approach.

        Parameters
        ----------
        rows : ndarray, shape (k,)
        kept_mm : float

        Returns
        -------
        ndarray of bool, shape (k,)
        """
        ways = [(int(row), int(row)) for row in rows]
        self.look_at(ways)
        return np.array([self.rooms_mm[way] >= kept_mm for way in ways], dtype=bool)


def pool_of(space: WorkSpace, joints_rad: FloatArray) -> Pool:
    """Return a pool of configurations of a work space.

    Parameters
    ----------
    space : WorkSpace
    joints_rad : ndarray, shape (N, J)

    Returns
    -------
    Pool
    """
    return Pool(bodies_in(space), joints_rad, space.approach_offset_rad or 0.0)


def is_clear(pool: Pool) -> bool:
    """Whether nothing touches on any way from each configuration to the next."""
    return not _Route(pool, [*range(len(pool.joints_rad))], None).blocked()


def clear_tour(pool: Pool, tour: IntArray) -> IntArray:
    """Return the order in which each is the nearest left on the way to which nothing touches.

    It begins as `tour` does; where no way is clear, it goes to the nearest.

    Parameters
    ----------
    pool : Pool
    tour : ndarray, shape (n,)
        Rows of the pool, one at least.

    Returns
    -------
    ndarray, shape (n,)
        The same rows.
    """
    left, order = [int(row) for row in tour[1:]], [int(tour[0])]
    while left:
        # As in `short_tour`: the joint that turns most says how far a stop is.
        away = np.abs(pool.joints_rad[left] - pool.joints_rad[order[-1]]).max(axis=1)
        nearest = [left[k] for k in np.argsort(away, kind="stable")]
        order.append(next(_reached(pool, order[-1], nearest), nearest[0]))
        left.remove(order[-1])
    return np.array(order, dtype=np.int64)


def _reached(pool: Pool, here: int, rows: Sequence[int]) -> Iterator[int]:
    """Yield the rows to which the way is clear, in their order."""
    for first in range(0, len(rows), _NEXT):
        ways = [(here, row) for row in rows[first : first + _NEXT]]
        pool.look_at(ways)
        yield from (way[1] for way in ways if pool.rooms_mm[way] >= 0.0)


def repair_order(
    pool: Pool,
    order: Iterable[int],
    substitutes: Substitutes,
    *,
    start: int | None = None,
    allowed: Allowed = lambda _: True,
) -> IntArray:
    """Return an order of rows, changed as little as it takes for nothing to touch on any of its ways.

    Parameters
    ----------
    pool : Pool
    order : iterable of int
        Rows of the pool, in the order that is wanted.
    substitutes : callable
        From an order and a place in it to the rows that may take that place, best first.
    start : int, optional
        The row that the arm comes from; None: nobody knows.
    allowed : callable, optional
        Whether an order may be at all.

    Returns
    -------
    ndarray, shape (n,)
        As it was where nothing touched.

    Raises
    ------
    NoWayError
        No such order was found.
    """
    route = _Route(pool, [int(row) for row in order], start)
    while blocked := route.blocked():
        # What is new keeps 10 mm if it can; no touch at all will do where nothing else is found. Ways
        # of the given order that just do not touch stay.
        better = (_better(route, blocked, substitutes, allowed, kept_mm) for kept_mm in _KEPT_MM)
        found = next(filter(None, better), None)
        if found is None:
            raise NoWayError(_why(route, blocked))
        route = found
    return np.array(route.order, dtype=np.int64)


def mended_or_toured(
    pool: Pool,
    order: IntArray,
    substitutes: Substitutes,
    *,
    start: int | None = None,
    allowed: Allowed = lambda _: True,
) -> IntArray:
    """Return an order as `repair_order` does, or else one that begins with the nearest of clear ways.

    The second is no longer the order that is wanted: it comes where volumes in the midst of the work space
    leave the first no chance. Raises NoWayError.

    Parameters
    ----------
    pool : Pool
    order : ndarray, shape (n,)
        As in `repair_order`.
    substitutes, start, allowed
        As in `repair_order`.

    Returns
    -------
    ndarray, shape (n,)

    Raises
    ------
    NoWayError
        Neither order could be mended.
    """
    try:
        return repair_order(pool, order, substitutes, start=start, allowed=allowed)
    except NoWayError:
        # Among a box, a wall and a post amidst the work space 9 of 12 plans are found so, 5 without.
        before = order[:0] if start is None else np.array([start], dtype=np.int64)
        tour = clear_tour(pool, np.concatenate([before, order]))[len(before) :]
        return repair_order(pool, tour, substitutes, start=start, allowed=allowed)


@dataclass(frozen=True, slots=True)
class _Route:
    """An order of rows of a pool, and where it comes from."""

    pool: Pool
    order: list[int]
    start: int | None

    def ways(self) -> list[_Way]:
        before = self.order[:1] if self.start is None else [self.start]
        return list(pairwise([*before, *self.order]))

    def blocked(self) -> list[int]:
        """Return the places in the order on the way to which something touches."""
        ways = self.ways()
        self.pool.look_at(ways)
        return [at for at, way in enumerate(ways) if self.pool.rooms_mm[way] < 0.0]

    def but(self, order: list[int]) -> "_Route":
        return _Route(self.pool, order, self.start)


def _better(
    route: _Route, blocked: Sequence[int], substitutes: Substitutes, allowed: Allowed, kept_mm: float
) -> _Route | None:
    """Return the first change after which something touches on fewer ways, with room kept on all new ones.

    None where none of the first 3,000 changed orders does.
    """
    known = set(route.ways())
    orders = (
        other for at in blocked for other in _changed(route, at, substitutes, kept_mm) if allowed(other)
    )
    # Every round takes a blocked way out, so that it ends; this bounds the last round, which finds
    # nothing.
    tried = islice(orders, _MOST_TRIED)
    while some := [route.but(order) for order in islice(tried, _AT_ONCE)]:
        route.pool.look_at(way for other in some for way in other.ways())
        for other in some:
            new = set(other.ways()) - known
            roomy = all(route.pool.rooms_mm[way] >= kept_mm for way in new)
            if roomy and len(other.blocked()) < len(blocked):
                return other
    return None


def _changed(route: _Route, at: int, substitutes: Substitutes, kept_mm: float) -> Iterator[list[int]]:
    """Yield orders without the way to a place: its ends elsewhere, then others instead of them."""
    ends = [at, at - 1] if at else [at]
    for end in ends:
        # A stop that touches by itself, or at its approach, does so wherever it comes in the order.
        if route.pool.stand(np.array(route.order[end : end + 1]), 0.0).all():
            yield from _elsewhere(route.order, end)
    for end in ends:
        others = substitutes(route.order, end)
        for row in others[route.pool.stand(others, kept_mm)][:_SUBSTITUTES]:
            yield [*route.order[:end], int(row), *route.order[end + 1 :]]


def _elsewhere(order: list[int], at: int) -> Iterator[list[int]]:
    """Yield the order with one stop at other places, then exchanged with others; the nearest come first."""
    places = sorted(set(range(len(order))) - {at}, key=lambda place: abs(place - at))[:_NEAREST]
    others = order[:at] + order[at + 1 :]
    for place in places:
        yield [*others[:place], order[at], *others[place:]]
    for place in places:
        exchanged = [*order]
        exchanged[at], exchanged[place] = order[place], order[at]
        yield exchanged


def _why(route: _Route, blocked: Sequence[int]) -> Text:
    """Return in words why an order cannot be mended."""
    at = blocked[0]
    legs = route.pool.legs([route.ways()[at]])
    leg = int(np.argmin(least_rooms_mm(route.pool.bodies, legs)))
    angles = tuple(f"{angle:.0f}" for angle in np.degrees(route.pool.joints_rad[route.order[at]]))
    keep_outs = route.pool.bodies.keep_outs
    return together(
        message(
            "room.no_clear_plan",
            blocked=len(blocked),
            planned=len(route.order),
            angles=angles,
            touches=contact_sentence(route.pool.bodies, legs, leg),
        ),
        message("room.look_at_keep_outs", volumes=keep_outs.names) if keep_outs else "",
    )
