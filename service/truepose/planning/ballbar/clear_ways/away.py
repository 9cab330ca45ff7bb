"""Where the arm waits once all cups are clamped: off the cups, with the ball and the base sides in reach.

Straight back from the last cup first, or up; where the arm cannot, one of the poses that follow will do:
their nests stand a ballbar's length from the cups.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.ballbar import PlannedAway
from truepose.planning.ballbar.clear_ways.clearance import bodies_at, hands_room_mm
from truepose.planning.ballbar.clear_ways.short_moves import Stop, Surroundings, is_clear_along, shifted
from truepose.planning.ballbar.clear_ways.ways import way
from truepose.planning.errors import NoWayError

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

    Raises
    ------
    NoWayError
        Wherever the arm can go from there, it leaves no room for the hands.
    """
    places = list(_candidates(around, held, poses_rad))
    rooms = [_room_mm(around, joints) for joints in places]
    for wanted in ROOMS_MM:
        for joints, room in zip(places, rooms, strict=True):
            via = _way_to(around, held, joints, rng) if room >= wanted else None
            if via is not None:
                return PlannedAway(tuple(float(q) for q in joints), via)
    raise NoWayError(
        f"From base point {held.base_point} of placement {around.fixture.number} the arm cannot back off so "
        f"far that {ROOMS_MM[-1]:g} mm are free about the cups: place the base fixture elsewhere."
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
