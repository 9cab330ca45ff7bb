"""Finds the fixed nests when the tracker's place is unknown, and with them its frame to a few millimetres.

A tracker needs a guess of where a reflector is. Three sources, the best first: where the fixed nests were
a moment ago, where somebody aimed at them once, and a search: the instrument stands upright at a roughly
known place, so that only its azimuth is unknown, and nest 1 lies on a circle around it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import FixedNest
from truepose.kinematics.frames import rigid_alignment, rotation_z
from truepose_drivers.api import PointTracker
from truepose_drivers.errors import MeasurementFailedError, ReflectorNotFoundError

AIMED_RADIUS_MM: Final = 50.0  # places aimed at by hand are good to about 20 mm
SEARCH_RADIUS_MM: Final = 150.0  # covers 2 deg of tilt at 3 m and 40 mm of the tracker's own place

# The true lengths between certified nests are known to micrometres; one reading each, a warped guess of
# the scale and both faces together stay far below this, while two other reflectors never fit by chance.
_SAME_LENGTH_MM = 1.0
_LOOK_S = 0.5


@dataclass(frozen=True, slots=True)
class RoughFrame:
    """The tracker's frame in the world, good enough to aim: x_world = R x_tracker + t."""

    rotation: FloatArray  # (3, 3)
    translation_mm: FloatArray  # (3,)

    def to_tracker(self, point_mm: FloatArray) -> FloatArray:
        """Return a point of the world in the tracker's frame, shape (3,)."""
        result: FloatArray = (point_mm - self.translation_mm) @ self.rotation
        return result

    def to_world(self, point_mm: Sequence[float]) -> FloatArray:
        """Return a point of the tracker's frame in the world, shape (3,)."""
        result: FloatArray = self.rotation @ np.array(point_mm) + self.translation_mm
        return result


async def locate_tracker(
    tracker: PointTracker,
    fixed_nests: Sequence[FixedNest],
    guesses: Sequence[tuple[FloatArray, float]],
    tracker_position_mm: FloatArray | None,
) -> RoughFrame:
    """Find all fixed nests and the frame that follows from them.

    Parameters
    ----------
    tracker : PointTracker
    fixed_nests : sequence of FixedNest
        n certified nests.
    guesses : sequence of (ndarray of shape (n, 3), float)
        Where the nests may be in the tracker's frame and within which radius [mm], tried in turn.
    tracker_position_mm : ndarray of shape (3,), optional
        Nominal place of the tracker in the world; without it there is no search.

    Raises
    ------
    ReflectorNotFoundError
        No guess led to reflectors with the certified lengths between them.
    """
    certified = np.array([nest.centre_mm for nest in fixed_nests])
    for places, radius_mm in guesses:
        frame = await _try_places(tracker, certified, places, radius_mm)
        if frame is not None:
            return frame
    if tracker_position_mm is not None:
        frame = await _search_around(tracker, certified, certified - tracker_position_mm)
        if frame is not None:
            return frame
    raise ReflectorNotFoundError(
        "The tracker found no reflectors with the certified lengths of the fixed nests between them. Check "
        "that each fixed nest holds its reflector and is in sight, or aim at each once and enter the places "
        "in the cell."
    )


async def _try_places(
    tracker: PointTracker, certified: FloatArray, places: FloatArray, radius_mm: float
) -> RoughFrame | None:
    """Look at all places; None as soon as one is empty or a length does not fit."""
    found: list[FloatArray] = []
    for place in places:
        point = await _look(tracker, place, radius_mm)
        if point is None or not _fits([*found, point], certified):
            return None
        found.append(point)
    return RoughFrame(*rigid_alignment(np.array(found), certified))


async def _look(tracker: PointTracker, place: FloatArray, radius_mm: float) -> FloatArray | None:
    """Return the reflector near `place`, None where there is none."""
    x, y, z = (float(value) for value in place)
    try:
        await tracker.find_reflector((x, y, z), search_radius_mm=radius_mm)
        reading = await tracker.measure_point(duration_s=_LOOK_S)
    except MeasurementFailedError:
        return None
    return np.array(reading.point_mm)


def _fits(found: Sequence[FloatArray], certified: FloatArray) -> bool:
    """Whether the newest reflector is as far from the earlier ones as the certificate says."""
    newest = len(found) - 1
    measured = np.array([np.linalg.norm(found[newest] - point) for point in found[:-1]])
    wanted = np.linalg.norm(certified[newest] - certified[:newest], axis=1)
    return bool(np.all(np.abs(measured - wanted) < _SAME_LENGTH_MM))


async def _search_around(
    tracker: PointTracker, certified: FloatArray, from_tracker: FloatArray
) -> RoughFrame | None:
    """Turn around the vertical, look for nest 1, and try for each hit whether the others follow."""
    for azimuth in _azimuths(float(np.hypot(*from_tracker[0, :2]))):
        hit = await _look(tracker, rotation_z(azimuth) @ from_tracker[0], SEARCH_RADIUS_MM)
        if hit is None:
            continue
        turn = np.arctan2(hit[1], hit[0]) - np.arctan2(from_tracker[0, 1], from_tracker[0, 0])
        places = from_tracker @ rotation_z(turn).T
        frame = await _try_places(tracker, certified, places, SEARCH_RADIUS_MM)
        if frame is not None:
            return frame
    return None


def _azimuths(distance_mm: float) -> Iterator[float]:
    """Yield angles [rad] so dense that neighbouring searches overlap, from 0 outwards to both sides."""
    # two circles of the search radius at 1.4 radii from each other still cover a band of 1.4 radii
    step = 2.0 * np.arcsin(min(1.0, 0.7 * SEARCH_RADIUS_MM / max(distance_mm, SEARCH_RADIUS_MM)))
    count = int(np.ceil(2.0 * np.pi / step))
    yield 0.0
    for k in range(1, count // 2 + 1):
        yield k * step
        yield -k * step
