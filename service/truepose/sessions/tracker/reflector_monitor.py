"""Where the reflector is now against where it is expected: for whoever looks at a page, never for the record.

The tracker is asked between its measurements and only while somebody watches. Nothing follows from the
answer: a beam that is lost is found by the step itself.
"""

import asyncio
import logging
import math
import time
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, cast

import numpy as np

from truepose.domain.session import PlannedStop, SessionPlan, Vector
from truepose.sessions.engine.ledger import Logbook
from truepose.sessions.engine.nominal_arm import as_vector, nest_in_world
from truepose.sessions.tracker.cell import SessionCell
from truepose.sessions.tracker.execution import Execution
from truepose.sessions.tracker.state import TrackerSituation
from truepose_drivers.api import FullTracker
from truepose_drivers.errors import (
    ConnectionLostError,
    DeviceRefusedError,
    MeasurementFailedError,
    NotInitialisedError,
)

_LOG: Final = logging.getLogger(__name__)
_PATIENCE_S: Final = 30.0  # wall time, besides the measurement that a look waits for
_LAST_LOOK_S: Final = 2.0  # wall time that the end of a session leaves to a look
_HARMLESS: Final = (
    ConnectionLostError,  # no doing of the look
    DeviceRefusedError,
    MeasurementFailedError,
    NotInitialisedError,
)


class ReflectorMonitor:
    """Asks a tracker where its reflector is; no answer of its driver is an error here.

    A look that goes wrong costs the link, and with it the measurement's next step: after one there are no
    more of them.
    """

    def __init__(self, tracker: FullTracker, measure_s: float) -> None:
        self._tracker = tracker
        self._patience_s = measure_s + _PATIENCE_S
        self._look: asyncio.Future[Vector | None] | None = None  # under way
        self._given_up = False

    async def seen_mm(self) -> Vector | None:
        """Return where the reflector is, in the tracker's frame; None where it sees none."""
        if self._given_up or not self._tracker.connected:
            return None
        # A task of its own: one that is broken off in its middle would close the link of the measurement.
        self._look = asyncio.ensure_future(self._tracker.reflector_now())
        return await self._answer(self._look, self._patience_s)

    async def end(self) -> None:
        """Let a look under way come to its end, or break it off where it hangs."""
        if self._look is not None and not self._look.done():
            await self._answer(self._look, _LAST_LOOK_S)

    async def _answer(self, look: asyncio.Future[Vector | None], patience_s: float) -> Vector | None:
        # Waited for from outside: a time-out within the look would break it off in the middle of an answer.
        if not (await asyncio.wait({look}, timeout=patience_s))[0]:
            look.cancel()
            self._give_up(f"no answer within {patience_s:g} s")
            return None
        try:
            return look.result()
        except _HARMLESS:
            return None  # whatever it means is found by the next measurement
        except (Exception, asyncio.CancelledError) as error:  # the look's own, for nobody cancels it
            self._give_up(f"{type(error).__name__}: {error}")
            return None

    def _give_up(self, why: str) -> None:
        self._given_up = True
        _LOG.warning("the reflector position is no longer shown in this session: %s", why)


_PERIOD_S: Final = 0.12  # wall time: about eight a second, which an eye takes for continuous
_NEAR: Final = 10.0  # tolerances

Near: TypeAlias = Literal["no_signal", "far", "near", "within"]


@dataclass(frozen=True, slots=True)
class ExpectedReflector:
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
    aim: ExpectedReflector | None  # None: no reflector is expected anywhere now
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
        self._looks = ReflectorMonitor(cast(FullTracker, cell.tracker), plan.measure_s) if points else None
        self._newest: Sighting | None = None
        self._told = asyncio.Event()
        self._watchers = 0
        self._ended = False
        self._aimed: ExpectedReflector | None = None  # of a stop, which stays where it is

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
                # Wall time: people watch, also where the cell's time costs none.
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

    def _delta(self, seen_mm: Vector, aim: ExpectedReflector) -> Vector | None:
        world = self._execution.in_world(seen_mm)
        return None if world is None else as_vector(np.subtract(world, aim.expected_mm))

    def _aim(self) -> ExpectedReflector | None:
        fixed_nest = self._execution.fixed_nest
        if fixed_nest is not None:
            centre = self._cell.fixed_nests[fixed_nest - 1].centre_mm
            return ExpectedReflector(centre, self._plan.reference_limit_mm, fixed_nest=fixed_nest)
        step = self._logbook.situation.step
        return None if step is None or step.stop is None else self._aim_at(step.stop)

    def _aim_at(self, stop: PlannedStop) -> ExpectedReflector:
        # Kept for the configuration: the nominal robot need not be computed eight times a second.
        if self._aimed is None or self._aimed.config != stop.config:
            self._aimed = expected_at(stop, self._plan, self._cell)
        return self._aimed


def expected_at(stop: PlannedStop, plan: SessionPlan, cell: SessionCell) -> ExpectedReflector:
    """Return where the reflector of a stop is expected by the nominal model."""
    place = nest_in_world(cell.robot, cell.base, cell.nests, stop.joints_rad, stop.nest)
    return ExpectedReflector(as_vector(place), plan.search_radius_mm, config=stop.config, nest=stop.nest)
