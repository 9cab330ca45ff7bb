"""The fixed nests: finding them, placing the tracker in the world with them, watching them."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Final, cast

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.ledger import EntryKind
from truepose.domain.measurement.session import FixedNestTaken, Registration, SessionPlan, Vector
from truepose.sequencing.engine.logbook import Logbook
from truepose.sequencing.errors import AttentionNeededError
from truepose.sequencing.tracker.cell import SessionCell
from truepose.sequencing.tracker.measuring.tracking import (
    CheckedTracker,
    standard_uncertainty_mm,
    stated_covariance_mm2,
)
from truepose.sequencing.tracker.plan.steps import FixedNestPhase, ReadFixedNest, StepKind
from truepose.sequencing.tracker.situation import TrackerSituation
from truepose.sequencing.tracker.world_frame.location import AIMED_RADIUS_MM, RoughFrame, locate_tracker
from truepose.sequencing.tracker.world_frame.registration import nest_mean, register, to_tracker, to_world
from truepose.sequencing.tracker.world_frame.scale import scale_sentence
from truepose_drivers.api import PointTracker, TrackerReading
from truepose_drivers.errors import MeasurementFailedError

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
            raise AttentionNeededError("The tracker's place in the world is not known.")
        return found

    def in_world(self, point_mm: Vector) -> Vector | None:
        """Return a point of the tracker's frame in the world, as far as its place is known by now."""
        situation = self._logbook.situation
        known = situation.registration or situation.last_known
        if known is None and self._rough is None:
            return None
        place = (
            to_world(known, np.array(point_mm)) if known else cast(RoughFrame, self._rough).to_world(point_mm)
        )
        x, y, z = (float(value) for value in place)
        return x, y, z

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
                f"Fixed nest {fixed_nest} was not found where it is expected: {error}"
            ) from error

    def _expected(self, fixed_nest: int) -> FloatArray:
        centre: FloatArray = self._certified[fixed_nest - 1]
        registration = self._logbook.situation.registration
        if registration is not None:
            return to_tracker(registration, centre)
        if self._rough is None:
            raise AttentionNeededError("The fixed nests have not been located yet.")
        return self._rough.to_tracker(centre)

    def _record(self, step: ReadFixedNest, reading: TrackerReading) -> FixedNestTaken:
        world = None
        registration = self._logbook.situation.registration
        if registration is not None and step.phase == "reference":
            x, y, z = (float(value) for value in to_world(registration, np.array(reading.point_mm)))
            world = (x, y, z)
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
                f"The tracker's two-face error is {self._two_face_mm:.3f} mm, limit "
                f"{self._plan.two_face_limit_mm:.3f} mm. Let it warm up and run its own check, then continue."
            )

    def _points(self, fixed_nest: int, face: int) -> FloatArray:
        return np.array([reading.point_mm for reading in self._taken[fixed_nest, face]])

    async def register(self) -> None:
        """Place the tracker in the world; raises AttentionNeededError where the certificate does not fit."""
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
                f"The fixed nests contradict their certificate: {registration.rms_mm:.3f} mm remain, "
                f"limit {limit_mm:.3f} mm. Clean the nests and reflectors and seat them anew, then continue."
            )
        await self._logbook.write(EntryKind.COMPUTED, StepKind.REGISTER, registration=registration)
        await self._logbook.write(EntryKind.NOTED, text=scale_sentence(registration))

    def _stated(self, fixed_nest: int) -> FloatArray:
        return np.array([stated_covariance_mm2(reading) for reading in self._taken[fixed_nest, 1]])

    def check_references(self) -> None:
        """Raise AttentionNeededError where a fixed nest is off by more than limit and readings explain."""
        off_mm = {nest: self._off_mm(nest) for nest, _ in self._taken}
        noise_mm = max((self._noise_mm(nest) for nest in off_mm), default=0.0)
        limit_mm = max(self._plan.reference_limit_mm, _BEYOND_NOISE * noise_mm)
        moved = [nest for nest, off in off_mm.items() if not off <= limit_mm]
        if not moved:
            return
        what = ", ".join(f"nest {nest} by {off_mm[nest]:.3f} mm" for nest in moved)
        culprit = "the tracker has" if len(moved) == len(off_mm) else "a nest or the tracker has"
        raise AttentionNeededError(
            f"Fixed nests are off ({what}; limit {limit_mm:.3f} mm): {culprit} moved. "
            "Put right what moved; continuing places the tracker in the world anew."
        )

    def _off_mm(self, fixed_nest: int) -> float:
        points = to_world(self.registration, self._points(fixed_nest, 1))
        return float(np.linalg.norm(points.mean(axis=0) - self._certified[fixed_nest - 1]))

    def _noise_mm(self, fixed_nest: int) -> float:
        """Return what the readings of a nest say of the uncertainty of their mean; 0 where nothing."""
        stated = self._stated(fixed_nest)
        noise_mm = float(np.sqrt(np.trace(stated.mean(axis=0)) / len(stated)))
        return noise_mm if math.isfinite(noise_mm) else 0.0
