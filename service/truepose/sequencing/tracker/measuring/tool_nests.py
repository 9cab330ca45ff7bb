"""The tool nests: finding the reflector where the nominal model expects it, measuring it, storing it."""

import math
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.ledger import EntryKind
from truepose.domain.measurement.session import PlannedStop, PointTaken, SessionPlan, Vector, stop_id
from truepose.sequencing.engine.logbook import Logbook
from truepose.sequencing.engine.motion.nominal_arm import nest_in_world
from truepose.sequencing.errors import ReadingRejectedError
from truepose.sequencing.tracker.cell import SessionCell
from truepose.sequencing.tracker.measuring.tracking import (
    CheckedTracker,
    standard_uncertainty_mm,
    world_covariance_mm2,
)
from truepose.sequencing.tracker.situation import TrackerSituation
from truepose.sequencing.tracker.world_frame.fixed_nests import FixedNests
from truepose.sequencing.tracker.world_frame.registration import to_tracker, to_world
from truepose_drivers.api import JointReading, TrackerReading
from truepose_drivers.errors import BeamBrokenError

_USUAL: Final = 2.0  # times what an instrument states of itself, that is no sign of motion


class ToolNests:
    """Measures one tool nest per stop."""

    def __init__(
        self,
        plan: SessionPlan,
        cell: SessionCell,
        tracker: CheckedTracker,
        fixed_nests: FixedNests,
        logbook: Logbook[TrackerSituation],
    ) -> None:
        self._plan = plan
        self._cell = cell
        self._tracker = tracker
        self._fixed_nests = fixed_nests
        self._logbook = logbook

    async def find(self, stop: PlannedStop) -> None:
        """Point the tracker at the nest; raises ReflectorNotFoundError."""
        place = to_tracker(self._fixed_nests.registration, self._expected(stop))
        await self._tracker.find(place, self._plan.search_radius_mm)

    def _expected(self, stop: PlannedStop) -> FloatArray:
        cell = self._cell
        return nest_in_world(cell.robot, cell.base, cell.nests, stop.joints_rad, stop.nest)

    async def measure(
        self, stop: PlannedStop, joints: JointReading, direction: tuple[int, ...]
    ) -> PointTaken:
        """Measure, check and store; a beam broken once is found again, a second time it is an error."""
        try:
            reading = await self._tracker.measure(self._plan.measure_s)
        except BeamBrokenError:
            await self.find(stop)
            reading = await self._tracker.measure(self._plan.measure_s)
        world = to_world(self._fixed_nests.registration, np.array(reading.point_mm))
        self._check(stop, reading, world)
        point = self._record(stop, reading, world, joints, direction, await self._tracker.temperature_c())
        step_id = stop_id(stop.config)
        await self._logbook.write(EntryKind.MEASURED, step_id, point=point, time_s=point.time_s)
        return point

    def _check(self, stop: PlannedStop, reading: TrackerReading, world: FloatArray) -> None:
        """Raise ReadingRejectedError for another reflector than the expected one and for an arm in motion."""
        off_mm = float(np.linalg.norm(world - self._expected(stop)))
        if off_mm > self._plan.search_radius_mm:
            raise ReadingRejectedError(
                f"The reflector measured is {off_mm:.1f} mm from where nest {stop.nest} is expected, limit "
                f"{self._plan.search_radius_mm:.1f} mm: it is another one, or the nominal model is wrong."
            )
        limit_mm = scatter_limit_mm(self._plan, reading.covariance_mm2)
        if not math.isfinite(reading.rms_mm) or reading.rms_mm > limit_mm:
            raise ReadingRejectedError(
                f"The reading scatters by {reading.rms_mm:.3f} mm, limit {limit_mm:.3f} mm: "
                "the arm or the tracker is not at rest."
            )

    def _record(
        self,
        stop: PlannedStop,
        reading: TrackerReading,
        world: FloatArray,
        joints: JointReading,
        direction: tuple[int, ...],
        temperature_c: float,
    ) -> PointTaken:
        x, y, z = (float(value) for value in world)
        return PointTaken(
            config=stop.config,
            nest=stop.nest,
            commanded_rad=stop.joints_rad,
            reported_rad=joints.joints_rad,
            direction=direction,
            time_s=reading.time_s,
            temperature_c=temperature_c,
            attachment=self._cell.attachment,
            position_tracker_mm=reading.point_mm,
            position_world_mm=(x, y, z),
            standard_uncertainty_mm=standard_uncertainty_mm(reading),
            rms_mm=reading.rms_mm,
            samples=reading.samples,
            repeat_of=stop.repeat_of,
            covariance_mm2=world_covariance_mm2(reading, self._fixed_nests.registration),
            instrument_serial=self._tracker.serial,
            group=stop.group,
        )


def scatter_limit_mm(plan: SessionPlan, covariance_mm2: tuple[Vector, Vector, Vector] | None) -> float:
    """Return how much a reading may scatter: twice what the instrument states of itself is no motion."""
    stated_mm = 0.0 if covariance_mm2 is None else math.sqrt(float(np.trace(covariance_mm2)))
    return max(plan.rms_limit_mm, _USUAL * stated_mm)
