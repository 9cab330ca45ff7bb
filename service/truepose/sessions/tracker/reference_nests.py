"""The fixed nests: finding them, placing the tracker in the world with them, watching them.

A tracker needs a guess of where a reflector is. Three sources, the best first: where the fixed nests were
a moment ago, where somebody aimed at them once, and a search: the instrument stands upright at a roughly
known place, so that only its azimuth is unknown, and nest 1 lies on a circle around it.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final, cast

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import text_of
from truepose.domain.ledger import EntryKind
from truepose.domain.robot import FixedNest
from truepose.domain.session import FixedNestTaken, Registration, SessionPlan, Vector
from truepose.kinematics.frames import rigid_alignment, rotation_z
from truepose.messages.message import message
from truepose.sessions.engine.ledger import Logbook
from truepose.sessions.engine.nominal_arm import as_vector
from truepose.sessions.errors import AttentionNeededError, ReadingRejectedError
from truepose.sessions.tracker.cell import SessionCell
from truepose.sessions.tracker.registration import (
    RoughFrame,
    nest_mean,
    register,
    scale_sentence,
    to_tracker,
    to_world,
)
from truepose.sessions.tracker.state import TrackerSituation
from truepose.sessions.tracker.steps import FixedNestPhase, ReadFixedNest, StepKind
from truepose.sessions.tracker.tracking import (
    CheckedTracker,
    standard_uncertainty_mm,
    stated_covariance_mm2,
)
from truepose_drivers.api import PointTracker, TrackerReading
from truepose_drivers.errors import MeasurementFailedError

AIMED_RADIUS_MM: Final = 50.0  # places aimed at by hand are good to about 20 mm
SEARCH_RADIUS_MM: Final = 150.0  # covers 2 deg of tilt at 3 m and 40 mm of the tracker's own place

# The true lengths between certified nests are known to micrometres; one reading each, a warped guess of
# the scale and both faces together stay far below this, while two other reflectors never fit by chance.
_SAME_LENGTH_MM = 1.0
_LOOK_S = 0.5


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
    ReadingRejectedError
        No guess led to reflectors with the certified lengths between them.
    """
    certified = np.array([nest.centre_mm for nest in fixed_nests])
    # The best first: a search around the instrument takes minutes.
    for places, radius_mm in guesses:
        frame = await _try_places(tracker, certified, places, radius_mm)
        if frame is not None:
            return frame
    if tracker_position_mm is not None:
        frame = await _search_around(tracker, certified, certified - tracker_position_mm)
        if frame is not None:
            return frame
    raise ReadingRejectedError(message("session.nests.none_fits"))


async def _try_places(
    tracker: PointTracker, certified: FloatArray, places: FloatArray, radius_mm: float
) -> RoughFrame | None:
    """Look at all places; None as soon as one is empty or a length does not fit."""
    found: list[FloatArray] = []
    for place in places:
        point = await _look(tracker, place, radius_mm)
        # Given up at the first place that does not fit: each look costs seconds.
        if point is None or not _fits([*found, point], certified):
            return None
        found.append(point)
    return RoughFrame(*rigid_alignment(np.array(found), certified))


async def _look(tracker: PointTracker, place: FloatArray, radius_mm: float) -> FloatArray | None:
    """Return the reflector near `place`, None where there is none."""
    try:
        await tracker.find_reflector(as_vector(place), search_radius_mm=radius_mm)
        reading = await tracker.measure_point(duration_s=_LOOK_S)
    # No reflector there. A lost link is another error, and is not taken for an empty place.
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
        # The hit says the azimuth better than the search circle did, within which the other nests have to be
        # found.
        turn = np.arctan2(hit[1], hit[0]) - np.arctan2(from_tracker[0, 1], from_tracker[0, 0])
        places = from_tracker @ rotation_z(turn).T
        frame = await _try_places(tracker, certified, places, SEARCH_RADIUS_MM)
        if frame is not None:
            return frame
    return None


def _azimuths(distance_mm: float) -> Iterator[float]:
    """Yield angles [rad] so dense that neighbouring searches overlap, from 0 outwards to both sides.

    At a horizontal distance d two circles of the search radius r whose centres are 1.4 r apart subtend
    2 asin(0.7 r / d) at the instrument. Own derivation; nearer than r it is that of d = r.
    """
    # two circles of the search radius at 1.4 radii from each other still cover a band of 1.4 radii
    step = 2.0 * np.arcsin(min(1.0, 0.7 * SEARCH_RADIUS_MM / max(distance_mm, SEARCH_RADIUS_MM)))
    count = int(np.ceil(2.0 * np.pi / step))
    yield 0.0
    for k in range(1, count // 2 + 1):
        yield k * step
        yield -k * step


# A nest that was pushed in the plane of the nests leaves about a third of it as residual: the rigid
# motion takes up the rest.
_SHARE_LEFT_IN_RESIDUALS: Final = 1.0 / 3.0
_STEPS: Final[Mapping[FixedNestPhase, StepKind]] = {
    "warm_up": StepKind.WARM,
    "registration": StepKind.REGISTER,
    "two_face": StepKind.REGISTER,
    "reference": StepKind.LOOK,
}
_BEYOND_NOISE: Final = 3.0  # times the stated uncertainty of a mean: less is no motion of a nest


class FixedNests:
    """Reads the fixed nests of a cell and keeps the tracker's place in the world that follows from them."""

    def __init__(
        self,
        plan: SessionPlan,
        cell: SessionCell,
        tracker: CheckedTracker,
        logbook: Logbook[TrackerSituation],
    ) -> None:
        self._plan = plan
        self._cell = cell
        self._tracker = tracker
        self._logbook = logbook
        self._certified = np.array([nest.centre_mm for nest in cell.fixed_nests])
        self._rough: RoughFrame | None = None
        self._two_face_mm: float | None = None
        self._taken: dict[tuple[int, int], list[TrackerReading]] = {}  # (fixed nest, face) in this step

    @property
    def registration(self) -> Registration:
        """The tracker's place in the world; raises AttentionNeededError where it is not known."""
        found = self._logbook.situation.registration
        if found is None:
            raise AttentionNeededError(message("session.tracker.no_place"))
        return found

    def in_world(self, point_mm: Vector) -> Vector | None:
        """Return a point of the tracker's frame in the world, as far as its place is known by now."""
        situation = self._logbook.situation
        # For a picture an old place is better than none.
        known = situation.registration or situation.last_known or self._rough
        return None if known is None else as_vector(to_world(known, np.array(point_mm)))

    def begin_step(self) -> None:
        """Forget the readings of an earlier step."""
        self._taken.clear()

    async def locate(self, *, anew: bool) -> None:
        """Find out roughly where the fixed nests are; where that is known, only `anew`."""
        if self._rough is not None and not anew:
            return
        position = self._cell.tracker_position_mm
        self._rough = await locate_tracker(
            cast(PointTracker, self._cell.tracker),
            self._cell.fixed_nests,
            self._guesses(),
            None if position is None else np.array(position),
        )

    def _guesses(self) -> list[tuple[FloatArray, float]]:
        guesses: list[tuple[FloatArray, float]] = []
        last_known = self._logbook.situation.last_known
        # A registration that was given up still says roughly where the nests are.
        if last_known is not None:
            guesses.append((to_tracker(last_known, self._certified), AIMED_RADIUS_MM))
        if self._cell.fixed_nests_seen_mm is not None:
            guesses.append((np.array(self._cell.fixed_nests_seen_mm), AIMED_RADIUS_MM))
        return guesses

    async def read(self, step: ReadFixedNest) -> None:
        """Measure a fixed nest as often as the step says; every reading is on disk before the next."""
        await self._find(step.fixed_nest)
        readings = self._taken.setdefault((step.fixed_nest, step.face), [])
        for _ in range(step.readings):
            reading = await self._tracker.measure(self._plan.measure_s, step.face)
            taken = self._record(step, reading)
            await self._logbook.write(
                EntryKind.READ, _STEPS[step.phase], fixed_nest=taken, time_s=taken.time_s
            )
            readings.append(reading)

    async def _find(self, fixed_nest: int) -> None:
        try:
            await self._tracker.find(self._expected(fixed_nest), self._plan.search_radius_mm)
        except MeasurementFailedError as error:
            raise AttentionNeededError(
                message("session.nest.not_found", nest=fixed_nest, why=text_of(error))
            ) from error

    def _expected(self, fixed_nest: int) -> FloatArray:
        centre: FloatArray = self._certified[fixed_nest - 1]
        known = self._logbook.situation.registration or self._rough
        if known is None:
            raise AttentionNeededError(message("session.nests.not_located"))
        return to_tracker(known, centre)

    def _record(self, step: ReadFixedNest, reading: TrackerReading) -> FixedNestTaken:
        world = None
        registration = self._logbook.situation.registration
        # Only a look is compared with the world; readings of a registration make it, and would be compared
        # with the one before.
        if registration is not None and step.phase == "reference":
            world = as_vector(to_world(registration, np.array(reading.point_mm)))
        return FixedNestTaken(
            phase=step.phase,
            fixed_nest=step.fixed_nest,
            face=step.face,
            time_s=reading.time_s,
            position_tracker_mm=reading.point_mm,
            position_world_mm=world,
            standard_uncertainty_mm=standard_uncertainty_mm(reading),
            instrument_serial=self._tracker.serial,
        )

    def check_faces(self) -> None:
        """Compare the faces; raises AttentionNeededError where they differ by more than the limit."""
        first, second = (self._points(1, face).mean(axis=0) for face in (1, 2))
        self._two_face_mm = 0.5 * float(np.linalg.norm(first - second))
        if self._two_face_mm > self._plan.two_face_limit_mm:
            raise AttentionNeededError(
                message("session.two_face", error_mm=self._two_face_mm, limit_mm=self._plan.two_face_limit_mm)
            )

    def _points(self, fixed_nest: int, face: int) -> FloatArray:
        return np.array([reading.point_mm for reading in self._taken[fixed_nest, face]])

    async def register(self) -> None:
        """Place the tracker in the world.

        Raises AttentionNeededError where the certificate does not fit, or nobody knows how good a reading is.
        """
        numbers = range(1, len(self._certified) + 1)
        means = [nest_mean(self._points(n, 1), self._stated(n)) for n in numbers]
        registration = register(
            means,
            self._cell.fixed_nests,
            two_face_mm=self._two_face_mm,
            lengths=self._cell.certified_lengths,
        )
        registration = replace(registration, instrument_serial=self._tracker.serial)
        limit_mm = _SHARE_LEFT_IN_RESIDUALS * self._plan.reference_limit_mm
        if registration.rms_mm > limit_mm:
            raise AttentionNeededError(
                message("session.nests.contradict", error_mm=registration.rms_mm, limit_mm=limit_mm)
            )
        await self._logbook.write(EntryKind.COMPUTED, StepKind.REGISTER, registration=registration)
        await self._logbook.write(EntryKind.NOTED, text=scale_sentence(registration))

    def _stated(self, fixed_nest: int) -> FloatArray:
        return np.array([stated_covariance_mm2(reading) for reading in self._taken[fixed_nest, 1]])

    def check_references(self) -> None:
        """Raise AttentionNeededError where a fixed nest is off by more than limit and readings explain."""
        off_mm = {nest: self._off_mm(nest) for nest, _ in self._taken}
        # The largest of all nests: with readings of 0.05 mm per coordinate one was off by more than the limit
        # by chance, and the session paused (commit 7d0747e8).
        noise_mm = max((self._noise_mm(nest) for nest in off_mm), default=0.0)
        limit_mm = max(self._plan.reference_limit_mm, _BEYOND_NOISE * noise_mm)
        # Not the opposite comparison: a NaN is off.
        moved = [nest for nest, off in off_mm.items() if not off <= limit_mm]
        if not moved:
            return
        off = tuple(message("session.nests.off", nest=nest, off_mm=off_mm[nest]) for nest in moved)
        either = "session.nests.moved.tracker" if len(moved) == len(off_mm) else "session.nests.moved.either"
        raise AttentionNeededError(message(either, what=off, limit_mm=limit_mm))

    def _off_mm(self, fixed_nest: int) -> float:
        points = to_world(self.registration, self._points(fixed_nest, 1))
        return float(np.linalg.norm(points.mean(axis=0) - self._certified[fixed_nest - 1]))

    def _noise_mm(self, fixed_nest: int) -> float:
        """Return the standard uncertainty of a nest's mean reading in space [mm]; 0 where none is stated.

        sqrt(trace(C) / n), with C the mean of the covariances stated of its n readings.
        """
        stated = self._stated(fixed_nest)
        noise_mm = float(np.sqrt(np.trace(stated.mean(axis=0)) / len(stated)))
        return noise_mm if math.isfinite(noise_mm) else 0.0
