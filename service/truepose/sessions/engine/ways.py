"""Straight ways that were looked at, by a plan or here; the arm goes no others.

A plan is looked at from each of its places to the next. What persons leave out or want again, a refused
target, a hand or a restart has the arm go from a place to another that no plan has in that order. Such a way
is looked at before it is gone: where nothing touches, it is gone; else a person is told and confirms it.
"""

import asyncio
import math
from collections.abc import Awaitable, Callable, Iterable, Sequence
from itertools import pairwise
from typing import Final, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.messages.message import Message, Text, is_said_in, message
from truepose.planning.workspace.bodies import CellBodies
from truepose.planning.workspace.path_clearance import Ways, path_obstruction, path_warnings
from truepose.sessions.errors import PlanRefusedError, WayNotClearError

Joints: TypeAlias = tuple[float, ...]
LookAtWays: TypeAlias = Callable[[Ways], Awaitable[Text]]  # what to watch on them; empty: all look clear

_FROM_HERE: Final = message("room.way", begin=message("room.end.here"), end=message("room.end.next"))


def look_in(bodies: CellBodies) -> LookAtWays:
    """Return who looks at ways among the bodies of a cell, as `path_warnings` does."""

    async def look(ways: Ways) -> Text:
        return await asyncio.to_thread(path_warnings, bodies, ways)

    return look


def refuse_blocked(blocked: Message | None) -> None:
    """Raise PlanRefusedError where something is in the way."""
    if blocked is not None:
        raise PlanRefusedError(blocked)


def judged_ways(bodies: CellBodies, ways: Ways) -> Text:
    """Return what to watch on planned ways; raises PlanRefusedError where one cannot be."""
    refuse_blocked(path_obstruction(bodies, ways))
    return path_warnings(bodies, ways)


class KnownWays:
    """The ways that one run of a session knows: looked at and clear, or confirmed by whoever was told."""

    def __init__(self, look: LookAtWays, look_at_others: LookAtWays | None = None) -> None:
        """Look by `look`, at what is none of the plan's by `look_at_others` where it is given."""
        self._look = look
        self._look_at_others = look_at_others or look
        self._known: set[tuple[Joints, Joints]] = set()
        self._told: tuple[Text, Ways] | None = None  # what touches, on which ways

    async def what_to_watch(self, ways: Ways) -> Text:
        """Look at ways that come next; return what whoever lets the arm go them has to be told.

        They are known from now on where that is nothing, else once the question that says it is confirmed.
        """
        found = await self._look(ways)
        if found:
            self._told = found, ways
        else:
            self._known.update(_ends(ways))
        return found

    async def require_planned(self, places: Sequence[Joints], name: Message) -> None:
        """Look at planned ways from each of some places to the next, once in a run.

        Raises WayNotClearError where something touches, for one by the limits that the cell has by now.
        """
        new = [way for way in pairwise(places) if way not in self._known]
        if not new:
            return
        start_rad, end_rad = np.swapaxes(np.array(new), 0, 1)
        found = await self.what_to_watch(Ways((name,) * len(new), start_rad, end_rad))
        if found:
            raise WayNotClearError(found)

    def confirm(self, question: Text) -> None:
        """Take what a person was told in a question that they have answered; forget what was not said."""
        if self._told is not None and is_said_in(self._told[0], question):
            self._known.update(_ends(self._told[1]))
        self._told = None

    async def require(self, start_rad: Joints, end_rad: Joints, allowed_rad: float) -> bool:
        """Return whether a way is looked at only now; raises WayNotClearError where something touches.

        Parameters
        ----------
        start_rad, end_rad : tuple of float
            Joint angles [rad].
        allowed_rad : float
            By which a joint may be beside a known way [rad].
        """
        if self._is_known(start_rad, end_rad, allowed_rad):
            return False
        ways = Ways((_FROM_HERE,), np.array([start_rad]), np.array([end_rad]))
        found = await self._look_at_others(ways)
        if found:
            told = message("session.way.unplanned", warning=found)
            self._told = told, ways
            raise WayNotClearError(told)
        self._known.update(_ends(ways))
        return True

    def _is_known(self, start_rad: Joints, end_rad: Joints, allowed_rad: float) -> bool:
        """Whether both ends lie on one known way; room is the same in both directions."""
        if apart(start_rad, end_rad) <= allowed_rad:
            return True
        if not self._known:
            return False
        begins, ends = np.swapaxes(np.array([*self._known]), 0, 1)
        off = np.maximum(_off_lines(start_rad, begins, ends), _off_lines(end_rad, begins, ends))
        return bool(np.any(off <= allowed_rad))


def _ends(ways: Ways) -> Iterable[tuple[Joints, Joints]]:
    return zip(map(tuple, ways.start_rad.tolist()), map(tuple, ways.end_rad.tolist()), strict=True)


def are_comparable(start_rad: Joints, end_rad: Joints) -> bool:
    """Whether both are places of one arm, in numbers."""
    return len(start_rad) == len(end_rad) and all(map(math.isfinite, (*start_rad, *end_rad)))


def rest_of_way(way: Sequence[Joints], here: Joints, allowed_rad: float) -> tuple[Joints, ...]:
    """Return what is left of a way for an arm that stands somewhere on it, the end in any case.

    Halted between two of its points, on the straight line of the joints, the arm goes on to the later one.
    From a place beside the way, and before its first point, it is the whole way.
    """
    passed = [n for n, joints in enumerate(way) if apart(here, joints) <= allowed_rad]
    # The last one: a way that comes twice by one place is taken from where it is shorter.
    last = max(passed or _between(way, here, allowed_rad), default=None)
    return tuple(way if last is None else way[min(last + 1, len(way) - 1) :])


def _between(way: Sequence[Joints], here: Joints, allowed_rad: float) -> Sequence[int]:
    """Return after which points of a way the arm stands on its line."""
    if len(way) < 2 or len(here) != len(way[0]):
        return ()
    off = _off_lines(here, np.array(way[:-1]), np.array(way[1:]))
    return np.flatnonzero(off <= allowed_rad).tolist()


def apart(here: Joints, there: Joints) -> float:
    """Return the largest difference of a joint [rad]; of arms that are not alike, infinity."""
    return float(np.max(np.abs(np.subtract(here, there)))) if len(here) == len(there) else math.inf


def _off_lines(here: Joints, start: FloatArray, end: FloatArray) -> FloatArray:
    """Return how far the joints are off each of n straight motions [rad], shape (n,).

    max |here - start - s (end - start)| over the joints, with s the projection of `here` on that motion,
    kept between 0 and 1.
    """
    way, away = end - start, np.subtract(here, start)
    length2 = np.sum(way**2, axis=1)
    share = np.clip(np.sum(away * way, axis=1) / np.where(length2 > 0.0, length2, 1.0), 0.0, 1.0)
    return np.asarray(np.max(np.abs(away - share[:, None] * way), axis=1))
