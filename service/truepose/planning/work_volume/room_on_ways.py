"""Whether the arm has room on its straight joint ways: from a stop to the approach of the next, and to it.

Looked at is every second degree of the joint that turns most; between two looks the arm then sinks by less
than a millimetre. Plans that the service chooses are mended until none of their ways touches (`mended_ways`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.session import PlaceOf, PlannedStop
from truepose.planning.work_volume.cell_bodies import CellBodies, rooms

_LOOK_RAD: Final = float(np.radians(2.0))
_NAMES: Final[dict[PlaceOf, str]] = {
    "work": "the work before ",
    "approach": "the approach to ",
    "stop": "",
}
_AT_ONCE: Final = 20_000  # configurations; keeps the arrays small


@dataclass(frozen=True, slots=True)
class Ways:
    """Straight joint motions, one after the other where they come from stops."""

    names: tuple[str, ...]  # "from ... to ..."; none where nobody is told of them
    start_rad: FloatArray  # (n, J)
    end_rad: FloatArray  # (n, J)


def ways_between(
    stops: Sequence[PlannedStop], approach_offset_rad: float | None, here_rad: Sequence[float] | None = None
) -> Ways:
    """Return the motions of a session to its stops, the first one from `here_rad` where that is known."""
    targets = [] if here_rad is None else [np.array(here_rad)]
    names = [] if here_rad is None else ["where the arm stands"]
    for stop in stops:
        for what, place_rad in stop.places(approach_offset_rad):
            targets.append(np.array(place_rad))
            names.append(f"{_NAMES[what]}configuration {stop.config}")
    words = tuple(f"from {a} to {b}" for a, b in pairwise(names))
    joints = np.array(targets)
    return Ways(words, joints[:-1], joints[1:])


def what_blocks_a_way(bodies: CellBodies, ways: Ways, *, floor_only: bool = False) -> str | None:
    """Return why a plan with these ways is refused.

    Where nobody states the floor, only keep-out volumes are looked at.
    """
    if not bodies.floor_is_stated:
        bodies, floor_only = replace(bodies, floor_z_mm=-np.inf), True
    blocked = touching(bodies, ways, floor_only=floor_only)
    if not blocked.size:
        return None
    what = what_touches(bodies, ways, blocked[0], floor_only=floor_only)
    return (
        f"The way {ways.names[blocked[0]]} cannot be: {what}. Change the order, put a configuration "
        "between them that leads the arm round it, or have others chosen with another seed."
    )


def what_to_watch(bodies: CellBodies, ways: Ways) -> str:
    """Return what whoever lets the arm go these ways has to know of them, empty where all look clear."""
    found = touching(bodies, ways)
    if not found.size:
        return ""
    floor = "the floor of the cell file" if bodies.floor_is_stated else "an assumed floor"
    others = f" Nor do {len(found) - 1} other ways." if len(found) > 1 else ""
    return (
        f"The way {ways.names[found[0]]} does not look clear, by the outline of the arm and {floor}: "
        f"{what_touches(bodies, ways, found[0])}.{others} Be ready to stop the arm, or change the order."
    )


def what_touches(bodies: CellBodies, ways: Ways, way: int, *, floor_only: bool = False) -> str:
    """Return in words what touches on a way, where it has least room."""
    joints = _along(ways, np.array([way]), _looks(ways)[[way]])
    found = rooms(bodies, joints, floor_only=floor_only)
    return found.what_touches(int(np.argmin(found.least_mm())))


def touching(bodies: CellBodies, ways: Ways, *, floor_only: bool = False) -> IntArray:
    """Return which ways something would touch on."""
    return np.flatnonzero(least_rooms_mm(bodies, ways, floor_only=floor_only) < 0.0)


def least_rooms_mm(bodies: CellBodies, ways: Ways, *, floor_only: bool = False) -> FloatArray:
    """Return the least room on each way [mm], negative where something would touch, shape (n,)."""
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
    places = np.flatnonzero(np.diff(np.cumsum(looks) // _AT_ONCE)) + 1
    yield from (some for some in np.split(np.arange(len(looks)), places) if some.size)


def _along(ways: Ways, some: IntArray, looks: IntArray) -> FloatArray:
    """Return the configurations looked at on some ways, one way after the other, their ends included."""
    row = np.repeat(some, looks)
    number = np.arange(1, len(row) + 1) - np.repeat(np.cumsum(looks) - looks, looks)
    share = (number / np.repeat(looks, looks))[:, None]
    return np.asarray((1.0 - share) * ways.start_rad[row] + share * ways.end_rad[row])
