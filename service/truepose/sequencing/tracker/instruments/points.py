"""A tracker's part of a session: its place in the world by fixed nests, then the tool nests."""

import math
from collections.abc import Callable
from typing import cast

from truepose.domain.measurement.session import SessionPlan, Vector
from truepose.sequencing.engine.logbook import Logbook
from truepose.sequencing.errors import PlanRefusedError
from truepose.sequencing.tracker.cell import SessionCell
from truepose.sequencing.tracker.identity_check import TrackerIdentityCheck
from truepose.sequencing.tracker.instruments.at_rest import AtRest
from truepose.sequencing.tracker.measuring.tool_nests import ToolNests
from truepose.sequencing.tracker.measuring.tracking import CheckedTracker
from truepose.sequencing.tracker.plan import steps
from truepose.sequencing.tracker.situation import TrackerSituation
from truepose.sequencing.tracker.world_frame.fixed_nests import FixedNests
from truepose_drivers.api import Environment, FullTracker


class Points:
    """Does the operations of a tracker."""

    def __init__(
        self,
        plan: SessionPlan,
        cell: SessionCell,
        logbook: Logbook[TrackerSituation],
        identities: TrackerIdentityCheck,
    ) -> None:
        self._device = cast(FullTracker, cell.tracker)
        self._tracker = tracker = CheckedTracker(self._device, identities)
        self._fixed_nests = FixedNests(plan, cell, tracker, logbook)
        self._tool_nests = ToolNests(plan, cell, tracker, self._fixed_nests, logbook)

    def begin_step(self) -> None:
        """Forget what belongs to an earlier step."""
        self._fixed_nests.begin_step()

    def in_world(self, point_mm: Vector) -> Vector | None:
        """Return a point of the tracker's frame in the world; None before that is known."""
        return self._fixed_nests.in_world(point_mm)

    async def conditions(self) -> list[str]:
        """Return what the tracker says that it measures with, and in which air; only what it does say."""
        settings, air = self._device.settings, await self._tracker.environment()
        return [*filter(None, [settings, None if air is None else _air_sentence(air)])]

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
                await self._tool_nests.find(stop)
            case steps.MeasurePoint(stop):
                here = at_rest()
                await self._tool_nests.measure(stop, here.joints, here.direction)
            case _:
                raise PlanRefusedError(f"A tracker cannot do this: {operation}.")


def _air_sentence(air: Environment) -> str:
    """Say what a weather station states, as far as it does."""
    stated = (
        (air.temperature_c, ".1f", " °C"),
        (air.pressure_hpa, ".1f", " hPa"),
        (air.humidity_percent, ".0f", " % humidity"),
    )
    told = [f"{value:{digits}}{unit}" for value, digits, unit in stated if math.isfinite(value)]
    return f"The air at the tracker: {', '.join(told) or 'not stated'}."
