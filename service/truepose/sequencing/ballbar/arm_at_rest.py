"""Whether the arm stands still where the session left it, from what the robot says itself."""

import asyncio
from typing import Final

import numpy as np

from truepose.domain.measurement.ballbar import ArrivalTaken, BallbarPlan
from truepose.sequencing.ballbar.cell import BallbarCell
from truepose.sequencing.engine.motion.limits import binding_speed
from truepose_drivers.api import DeviceIdentity, JointReading

_RECENT_S: Final = 2.0  # an older statement says nothing of now


class RestMonitor:
    """Asks the robot where it is, one question at a time."""

    def __init__(self, cell: BallbarCell, plan: BallbarPlan) -> None:
        self._controller = cell.robot_controller
        self._speed_limits = cell.speed_limits
        self._plan = plan
        self._turn = asyncio.Lock()
        self._seen: tuple[JointReading, ...] = ()  # the last two

    async def open(self) -> None:
        """Open the link where it is down and set the limits of motion; raises the driver's errors."""
        if not self._controller.connected:
            await self._controller.connect()
            await self._controller.identify()  # a driver may know more of its controller from then on
        await self._controller.set_limits(binding_speed(self._plan, self._speed_limits))

    async def close(self) -> None:
        """Close the link; the next opening begins a new conversation."""
        self.forget()
        await self._controller.close()

    async def who(self) -> DeviceIdentity:
        """Ask the robot who it is; raises the driver's errors."""
        async with self._turn:
            return await self._controller.identify()

    async def look(self) -> JointReading:
        """Ask where the joints are; raises the driver's errors."""
        async with self._turn:
            reading = await self._controller.read_joints()
        self._seen = (*self._seen[-1:], reading)
        return reading

    def forget(self) -> None:
        """Forget what was seen: the arm has moved since, or may have."""
        self._seen = ()

    def is_still(self, now_s: float) -> bool:
        """Whether the last two looks agree and the last one is recent."""
        if len(self._seen) < 2 or not self._controller.connected:
            return False
        before, after = self._seen
        if abs(now_s - after.time_s) > _RECENT_S:
            return False
        off = np.abs(np.subtract(after.joints_rad, before.joints_rad))
        return bool(np.all(off <= after.resolution_rad))

    def moved_from(self, arrival: ArrivalTaken, reading: JointReading) -> str | None:
        """Return which joint is not where it came to rest, as a sentence; None where all are."""
        return joint_away(
            reading.joints_rad, arrival.reported_rad, self._plan.joint_tolerance_rad + reading.resolution_rad
        )


def joint_away(reported: tuple[float, ...], wanted: tuple[float, ...], allowed_rad: float) -> str | None:
    """Return which joint is elsewhere, as a sentence; None where all are where they should be."""
    if len(reported) != len(wanted):
        return f"The robot reports {len(reported)} joints instead of {len(wanted)}."
    off = np.abs(np.subtract(reported, wanted))
    if np.all(off <= allowed_rad):  # a NaN is not
        return None
    worst = int(np.argmax(np.nan_to_num(off, nan=np.inf)))
    return f"Joint {worst + 1} is {np.degrees(off[worst]):.2f} deg away from where it should be."
