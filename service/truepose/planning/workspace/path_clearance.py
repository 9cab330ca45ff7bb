"""Room of arm and tool along straight joint paths between stops.

Of a path, from a stop to the approach of the next and to it, looked at is every second degree of the joint
that turns most; between two looks the arm then sinks by less than a millimetre. Plans that the service
chooses are mended until none of their ways touches (`tracker.path_repair`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.session import PlaceOf, PlannedStop
from truepose.messages.message import Message, Text, message, together
from truepose.planning.workspace.bodies import CellBodies, rooms

_LOOK_RAD: Final = float(np.radians(2.0))
_NAMES: Final[dict[PlaceOf, str]] = {
    "work": "room.end.work",
    "approach": "room.end.approach",
    "stop": "room.end.stop",
}
_WAYS_AT_ONCE: Final = 20_000  # configurations; keeps the arrays small


@dataclass(frozen=True, slots=True)
class Ways:
    """Straight joint motions, one after the other where they come from stops.

    Attributes
    ----------
    names : tuple of Message
        "from ... to ..."; none where nobody is told of them.
    start_rad, end_rad : ndarray, shape (n, J)
    """

    names: tuple[Message, ...]
    start_rad: FloatArray
    end_rad: FloatArray


def ways_between(
    stops: Sequence[PlannedStop], approach_offset_rad: float | None, here_rad: Sequence[float] | None = None
) -> Ways:
    """Return the motions of a session to its stops.

    Parameters
    ----------
    stops : sequence of PlannedStop
    approach_offset_rad : float or None
        Of the session.
    here_rad : sequence of float, optional
        Where the arm stands; without it the first motion is not among them.

    Returns
    -------
    Ways
        One a place of the stops (work, approach, stop), less the first where nobody knows its begin.
    """
    targets = [] if here_rad is None else [np.array(here_rad)]
    names = [] if here_rad is None else [message("room.end.here")]
    for stop in stops:
        for what, place_rad in stop.places(approach_offset_rad):
            targets.append(np.array(place_rad))
            names.append(message(_NAMES[what], config=stop.config))
    words = tuple(message("room.way", begin=a, end=b) for a, b in pairwise(names))
    joints = np.array(targets)
    return Ways(words, joints[:-1], joints[1:])


def path_obstruction(bodies: CellBodies, ways: Ways, *, floor_only: bool = False) -> Message | None:
    """Return why a plan with these ways is refused.

    Where nobody states the floor, only keep-out volumes are looked at.

    Parameters
    ----------
    bodies : CellBodies
    ways : Ways
        With names.
    floor_only : bool
        As of `rooms`.

    Returns
    -------
    Message or None
        None: it is not refused.
    """
    # An assumed floor may lie where there is none: a person is told of it (`path_warnings`), nobody is
    # refused for it.
    if not bodies.floor_is_stated:
        bodies, floor_only = replace(bodies, floor_z_mm=-np.inf), True
    blocked = touching(bodies, ways, floor_only=floor_only)
    if not blocked.size:
        return None
    what = contact_sentence(bodies, ways, blocked[0], floor_only=floor_only)
    return message("room.way_blocked", way=ways.names[blocked[0]], touches=what)


def path_warnings(bodies: CellBodies, ways: Ways) -> Text:
    """Return what whoever lets the arm go these ways has to know of them.

    Parameters
    ----------
    bodies : CellBodies
    ways : Ways
        With names.

    Returns
    -------
    Message or str
        The first way on which something would touch, and how many others; empty where all look clear.
    """
    found = touching(bodies, ways)
    if not found.size:
        return ""
    unclear = message(
        "room.way_unclear" if bodies.floor_is_stated else "room.way_unclear.assumed_floor",
        way=ways.names[found[0]],
        touches=contact_sentence(bodies, ways, found[0]),
    )
    others = message("room.other_ways", ways=len(found) - 1) if len(found) > 1 else ""
    return together(unclear, others, message("room.be_ready"))


def contact_sentence(bodies: CellBodies, ways: Ways, way: int, *, floor_only: bool = False) -> Message:
    """Return in words what touches on a way, where it has least room.

    Parameters
    ----------
    bodies : CellBodies
    ways : Ways
    way : int
        Row of a way on which something does touch.
    floor_only : bool
        As of `rooms`.

    Returns
    -------
    Message
    """
    joints = _along(ways, np.array([way]), _looks(ways)[[way]])
    found = rooms(bodies, joints, floor_only=floor_only)
    return found.what_touches(int(np.argmin(found.least_mm())))


def touching(bodies: CellBodies, ways: Ways, *, floor_only: bool = False) -> IntArray:
    """Return which ways something would touch on.

    Parameters
    ----------
    bodies : CellBodies
    ways : Ways
        n of them.
    floor_only : bool
        As of `rooms`.

    Returns
    -------
    ndarray
        Their rows, ascending.
    """
    return np.flatnonzero(least_rooms_mm(bodies, ways, floor_only=floor_only) < 0.0)


def least_rooms_mm(bodies: CellBodies, ways: Ways, *, floor_only: bool = False) -> FloatArray:
    """Return the least room on each way.

    Parameters
    ----------
    bodies : CellBodies
    ways : Ways
        n of them.
    floor_only : bool
        As of `rooms`.

    Returns
    -------
    ndarray, shape (n,)
        [mm]; negative where something would touch. Looked at is every second degree of the joint that turns
        most, and the end; where a way begins, the one before it ends.
    """
    if not len(ways.start_rad):
        return np.zeros(0)
    looks = _looks(ways)
    least = [
        np.minimum.reduceat(
            rooms(bodies, _along(ways, some, looks[some]), floor_only=floor_only).least_mm(),
            np.cumsum(looks[some]) - looks[some],
        )
        for some in _batches(looks)
    ]
    return np.concatenate(least)


def _looks(ways: Ways) -> IntArray:
    """Return how many configurations are looked at on each way."""
    turn = np.abs(ways.end_rad - ways.start_rad).max(axis=1)
    return np.asarray(np.maximum(1.0, np.ceil(turn / _LOOK_RAD)), dtype=np.int64)


def _batches(looks: IntArray) -> Iterator[IntArray]:
    """Yield the ways in batches of not many more than so many configurations."""
    # Ways are not cut: the least room of each is taken over its own looks in one piece.
    places = np.flatnonzero(np.diff(np.cumsum(looks) // _WAYS_AT_ONCE)) + 1
    yield from (some for some in np.split(np.arange(len(looks)), places) if some.size)


def _along(ways: Ways, some: IntArray, looks: IntArray) -> FloatArray:
    """Return the configurations looked at on some ways, one way after the other, their ends included.

    q = (1 - k / l) q_start + (k / l) q_end, k = 1 ... l with l looks; the begin is the end of the way before.
    """
    row = np.repeat(some, looks)
    number = np.arange(1, len(row) + 1) - np.repeat(np.cumsum(looks) - looks, looks)
    share = (number / np.repeat(looks, looks))[:, None]
    return np.asarray((1.0 - share) * ways.start_rad[row] + share * ways.end_rad[row])
