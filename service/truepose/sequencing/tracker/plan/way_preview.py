"""What the next motions look like beforehand, for whoever lets the arm move: by its outline and the floor."""

import asyncio
from collections.abc import Sequence
from typing import Final

from truepose.domain.measurement.session import PlannedStop
from truepose.planning.work_volume.room_on_ways import ways_between, what_to_watch
from truepose.sequencing.tracker.cell import SessionCell
from truepose_drivers.api import RobotController
from truepose_drivers.errors import DriverError

_STATED_WITHIN_S: Final = 1.0  # of wall time; a question is not kept waiting for it


async def what_lies_ahead(
    cell: SessionCell, stops: Sequence[PlannedStop], approach_offset_rad: float | None
) -> str:
    """Return on which ways to `stops` something would touch, from where the arm stands where that is known.

    Empty where all look clear, and where the cell does not say what there is to be looked at.
    """
    bodies = cell.bodies
    if bodies is None or not stops:
        return ""
    here_rad = await _stands_at(cell.robot_controller, len(stops[0].joints_rad))
    ways = ways_between(stops, approach_offset_rad, here_rad)
    return await asyncio.to_thread(what_to_watch, bodies, ways)


async def _stands_at(robot: RobotController, joints: int) -> tuple[float, ...] | None:
    """Return where the arm is; None where its controller is not connected or does not say so."""
    if not robot.connected:
        return None
    try:
        async with asyncio.timeout(_STATED_WITHIN_S):
            stated_rad = (await robot.read_joints()).joints_rad
    except (TimeoutError, DriverError):  # whoever moves the arm asks again, and says what is wrong
        return None
    return stated_rad if len(stated_rad) == joints else None
