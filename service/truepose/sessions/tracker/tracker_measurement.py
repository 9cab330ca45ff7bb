"""A tracker's part of a session: its place in the world by reference nests, then the tool nests."""

import math
from collections.abc import Callable
from typing import Final, cast

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.ledger import EntryKind
from truepose.domain.session import PlannedStop, PointTaken, SessionPlan, Vector, stop_id
from truepose.messages.message import Message, Text, message
from truepose.sessions.engine.ledger import Logbook
from truepose.sessions.engine.nominal_arm import as_vector, nest_in_world
from truepose.sessions.errors import PlanRefusedError, ReadingRejectedError
from truepose.sessions.tracker import steps as steps
from truepose.sessions.tracker.cell import AtRest, SessionCell
from truepose.sessions.tracker.reference_nests import FixedNests
from truepose.sessions.tracker.registration import to_tracker, to_world
from truepose.sessions.tracker.state import TrackerSituation
from truepose.sessions.tracker.tracking import (
    CheckedTracker,
    TrackerIdentityCheck,
    standard_uncertainty_mm,
    world_covariance_mm2,
)
from truepose_drivers.api import Environment, FullTracker, TrackerReading
from truepose_drivers.errors import BeamBrokenError

_USUAL: Final = 2.0  # times what an instrument states of itself, that is no sign of motion


class Points:
    """Does the operations of a tracker."""

    def __init__(
        self,
        plan: SessionPlan,
        cell: SessionCell,
        logbook: Logbook[TrackerSituation],
        identities: TrackerIdentityCheck,
    ) -> None:
        self._plan = plan
        self._cell = cell
        self._logbook = logbook
        self._device = cast(FullTracker, cell.tracker)
        self._tracker = CheckedTracker(self._device, identities)
        self._fixed_nests = FixedNests(plan, cell, self._tracker, logbook)

    def begin_step(self) -> None:
        """Forget what belongs to an earlier step."""
        self._fixed_nests.begin_step()

    def in_world(self, point_mm: Vector) -> Vector | None:
        """Return a point of the tracker's frame in the world; None before that is known."""
        return self._fixed_nests.in_world(point_mm)

    async def conditions(self) -> list[Text]:
        """Return what the tracker says that it measures with, and in which air; only what it does say."""
        settings, air = self._device.settings, await self._tracker.environment()
        told: list[Text] = [settings] if settings else []
        return told if air is None else [*told, _air_sentence(air)]

    async def perform(self, operation: steps.Operation, at_rest: Callable[[], AtRest]) -> None:
        """Do one operation; raises what the tracker and the checks raise."""
        match operation:
            case steps.LocateFixedNests(anew):
                await self._fixed_nests.locate(anew=anew)
            case steps.ReadFixedNest():
                await self._fixed_nests.read(operation)
            case steps.CheckFaces():
                self._fixed_nests.check_faces()
            case steps.Register():
                await self._fixed_nests.register()
            case steps.CheckReferences():
                self._fixed_nests.check_references()
            case steps.FindReflector(stop):
                await self._find(stop)
            case steps.MeasurePoint(stop):
                await self._measure(stop, at_rest())
            case _:
                raise PlanRefusedError(message("session.cannot.tracker", operation=str(operation)))

    async def _find(self, stop: PlannedStop) -> None:
        """Point the tracker at the nest; raises ReflectorNotFoundError."""
        place = to_tracker(self._fixed_nests.registration, self._expected(stop))
        await self._tracker.find(place, self._plan.search_radius_mm)

    def _expected(self, stop: PlannedStop) -> FloatArray:
        cell = self._cell
        return nest_in_world(cell.robot, cell.base, cell.nests, stop.joints_rad, stop.nest)

    async def _measure(self, stop: PlannedStop, here: AtRest) -> None:
        """Measure, check and store; a beam broken once is found again, a second time it is an error."""
        try:
            reading = await self._tracker.measure(self._plan.measure_s)
        except BeamBrokenError:
            await self._find(stop)
            reading = await self._tracker.measure(self._plan.measure_s)
        world = to_world(self._fixed_nests.registration, np.array(reading.point_mm))
        self._check(stop, reading, world)
        point = self._record(stop, reading, world, here, await self._tracker.temperature_c())
        step_id = stop_id(stop.config)
        await self._logbook.write(EntryKind.MEASURED, step_id, point=point, time_s=point.time_s)

    def _check(self, stop: PlannedStop, reading: TrackerReading, world: FloatArray) -> None:
        """Raise ReadingRejectedError for another reflector than the expected one and for an arm in motion."""
        off_mm = float(np.linalg.norm(world - self._expected(stop)))
        # A tracker locks on to whatever reflector it meets.
        if off_mm > self._plan.search_radius_mm:
            raise ReadingRejectedError(
                message(
                    "session.reflector.elsewhere",
                    off_mm=off_mm,
                    nest=stop.nest,
                    limit_mm=self._plan.search_radius_mm,
                )
            )
        limit_mm = scatter_limit_mm(self._plan, reading.covariance_mm2)
        if not math.isfinite(reading.rms_mm) or reading.rms_mm > limit_mm:
            raise ReadingRejectedError(
                message("session.reading.scatters", off_mm=reading.rms_mm, limit_mm=limit_mm)
            )

    def _record(
        self,
        stop: PlannedStop,
        reading: TrackerReading,
        world: FloatArray,
        here: AtRest,
        temperature_c: float,
    ) -> PointTaken:
        return PointTaken(
            config=stop.config,
            nest=stop.nest,
            commanded_rad=stop.joints_rad,
            reported_rad=here.joints.joints_rad,
            direction=here.direction,
            time_s=reading.time_s,
            temperature_c=temperature_c,
            attachment=self._cell.attachment,
            position_tracker_mm=reading.point_mm,
            position_world_mm=as_vector(world),
            standard_uncertainty_mm=standard_uncertainty_mm(reading),
            rms_mm=reading.rms_mm,
            samples=reading.samples,
            repeat_of=stop.repeat_of,
            covariance_mm2=world_covariance_mm2(reading, self._fixed_nests.registration),
            instrument_serial=self._tracker.serial,
            group=stop.group,
        )


def scatter_limit_mm(plan: SessionPlan, covariance_mm2: tuple[Vector, Vector, Vector] | None) -> float:
    """Return how much a reading may scatter [mm]: max(rms limit of the plan, 2 sqrt(trace(covariance))).

    Twice what the instrument states of itself is no sign that the arm moves. `covariance_mm2` is 3 x 3; None
    where the instrument states none.
    """
    # A reading of 0.05 mm per coordinate scatters by 0.087 mm in space: against a fixed limit of 0.1 mm a
    # sound tracker paused its session at the first configuration (commit 34fb5649).
    stated_mm = 0.0 if covariance_mm2 is None else math.sqrt(float(np.trace(covariance_mm2)))
    return max(plan.rms_limit_mm, _USUAL * stated_mm)


def _air_sentence(air: Environment) -> Message:
    """Say what a weather station states, as far as it does."""
    stated = (
        ("session.air.temperature", air.temperature_c),
        ("session.air.pressure", air.pressure_hpa),
        ("session.air.humidity", air.humidity_percent),
    )
    told = tuple(message(key, value=value) for key, value in stated if math.isfinite(value))
    return message("session.air", air=told or (message("session.air.not_stated"),))
