"""Where the reflector is now against where it is expected: for whoever looks at a page, never for the record.

The tracker is asked between its measurements and only while somebody watches. Nothing follows from the
answer: a beam that is lost is found by the step itself.
"""

import asyncio
import math
import time
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, cast

import numpy as np

from truepose.domain.measurement.session import PlannedStop, SessionPlan, Vector
from truepose.sequencing.engine.logbook import Logbook
from truepose.sequencing.engine.motion.nominal_arm import nest_in_world
from truepose.sequencing.tracker.cell import SessionCell
from truepose.sequencing.tracker.execution import Execution
from truepose.sequencing.tracker.measuring.looks import Looks
from truepose.sequencing.tracker.situation import TrackerSituation
from truepose_drivers.api import FullTracker

_PERIOD_S: Final = 0.12  # wall time: about eight a second, which an eye takes for continuous
_NEAR: Final = 10.0  # tolerances

Near: TypeAlias = Literal["no_signal", "far", "near", "within"]


@dataclass(frozen=True, slots=True)
class Aim:
    """Where a reflector is expected."""

    expected_mm: Vector  # in the world
    tolerance_mm: float  # within which a reading is accepted
    config: int | None = None
    nest: int | None = None  # of the tool, 1-based
    fixed_nest: int | None = None  # 1-based


@dataclass(frozen=True, slots=True)
class Sighting:
    """One look at the reflector."""

    sampled_at_ms: int  # wall clock
    aim: Aim | None  # None: no reflector is expected anywhere now
    delta_mm: Vector | None  # seen minus expected, in the world; None: it is not seen, or the place not known
    is_seen: bool
    is_moving: bool  # the arm is on its way

    @property
    def distance_mm(self) -> float | None:
        """From where it is expected."""
        return None if self.delta_mm is None else math.hypot(*self.delta_mm)

    @property
    def state(self) -> Near:
        """How near it is."""
        distance_mm = self.distance_mm
        if distance_mm is None or self.aim is None:
            return "no_signal"
        if distance_mm <= self.aim.tolerance_mm:
            return "within"
        return "near" if distance_mm <= _NEAR * self.aim.tolerance_mm else "far"


class Watch:
    """Looks while somebody watches, and tells all of them."""

    def __init__(
        self, plan: SessionPlan, cell: SessionCell, logbook: Logbook[TrackerSituation], execution: Execution
    ) -> None:
        self._plan = plan
        self._cell = cell
        self._logbook = logbook
        self._execution = execution
        points = plan.measures == "points"  # a camera follows no reflector
        self._looks = Looks(cast(FullTracker, cell.tracker), plan.measure_s) if points else None
        self._newest: Sighting | None = None
        self._told = asyncio.Event()
        self._watchers = 0
        self._ended = False
        self._aimed: Aim | None = None  # of a stop, which stays where it is

    async def follow(self) -> AsyncIterator[Sighting]:
        """Yield every look from now on until the session ends."""
        self._watchers += 1
        try:
            while not self._ended:
                told = self._told
                await told.wait()
                if self._newest is not None and not self._ended:
                    yield self._newest
        finally:
            self._watchers -= 1

    def end(self) -> None:
        """Tell watchers that nothing more comes."""
        self._ended = True
        self._tell()

    async def run(self) -> None:
        """Look again and again while somebody watches; ends with its task."""
        try:
            while True:
                await asyncio.sleep(_PERIOD_S)
                if self._watchers:
                    self._newest = await self._looked()
                    self._tell()
        finally:
            if self._looks is not None:
                await self._looks.end()

    def _tell(self) -> None:
        self._told.set()
        self._told = asyncio.Event()

    async def _looked(self) -> Sighting:
        seen_mm = None if self._looks is None else await self._looks.seen_mm()
        aim = self._aim()
        return Sighting(
            sampled_at_ms=round(1000.0 * time.time()),
            aim=aim,
            delta_mm=None if seen_mm is None or aim is None else self._delta(seen_mm, aim),
            is_seen=seen_mm is not None,
            is_moving=self._execution.is_moving,
        )

    def _delta(self, seen_mm: Vector, aim: Aim) -> Vector | None:
        world = self._execution.in_world(seen_mm)
        if world is None:
            return None
        x, y, z = np.subtract(world, aim.expected_mm).tolist()
        return x, y, z

    def _aim(self) -> Aim | None:
        fixed_nest = self._execution.fixed_nest
        if fixed_nest is not None:
            centre = self._cell.fixed_nests[fixed_nest - 1].centre_mm
            return Aim(centre, self._plan.reference_limit_mm, fixed_nest=fixed_nest)
        step = self._logbook.situation.step
        return None if step is None or step.stop is None else self._aim_at(step.stop)

    def _aim_at(self, stop: PlannedStop) -> Aim:
        if self._aimed is None or self._aimed.config != stop.config:
            self._aimed = expected_at(stop, self._plan, self._cell)
        return self._aimed


def expected_at(stop: PlannedStop, plan: SessionPlan, cell: SessionCell) -> Aim:
    """Return where the reflector of a stop is expected by the nominal model."""
    x, y, z = nest_in_world(cell.robot, cell.base, cell.nests, stop.joints_rad, stop.nest).tolist()
    return Aim((x, y, z), plan.search_radius_mm, config=stop.config, nest=stop.nest)
