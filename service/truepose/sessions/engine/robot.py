"""The robot as a session hears it: what it states of its joints is taken only within its own ranges."""

import math
from typing import Final

from truepose.domain.robot import JointRange
from truepose_drivers.api import DeviceIdentity, FullRobot, JointReading, MotionGuard, MotionLimits
from truepose_drivers.errors import ImplausibleReadingError

_BEYOND_RANGE_RAD: Final = math.radians(1.0)  # pushed against its stop by hand; ranges are rounded


class WatchfulRobot:
    """A robot's controller; refuses statements that put a joint where this robot has none."""

    def __init__(self, controller: FullRobot, ranges: tuple[JointRange, ...] | None) -> None:
        """Watch `controller`; without `ranges` nothing is known that could be judged by."""
        self._controller = controller
        self._ranges = ranges

    @property
    def connected(self) -> bool:
        """Whether the link is up as far as known."""
        return self._controller.connected

    @property
    def can_stop_motion(self) -> bool:
        """Whether a motion under way can be interrupted through this protocol."""
        return self._controller.can_stop_motion

    @property
    def motion_guard(self) -> MotionGuard:
        """What the controller's driver says that becomes of a motion."""
        return self._controller.motion_guard

    async def connect(self) -> None:
        """Open the link; raises ConnectFailedError."""
        await self._controller.connect()

    async def close(self) -> None:
        """Close the link; never raises."""
        await self._controller.close()

    async def identify(self) -> DeviceIdentity:
        """Ask the controller who it is."""
        return await self._controller.identify()

    async def set_limits(self, limits: MotionLimits) -> None:
        """Set the speed limits of the following motions."""
        await self._controller.set_limits(limits)

    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        """Move all joints; raises TargetRefusedError."""
        await self._controller.move_joints(target_rad)

    async def read_joints(self) -> JointReading:
        """Ask where the joints are; raises ImplausibleReadingError where no arm of this kind can be."""
        reading = await self._controller.read_joints()
        # Here and not in the driver: only the cell file says which arm this is (decision 0021).
        if self._ranges is not None:
            _require_within(reading, self._ranges)
        return reading


def _require_within(reading: JointReading, ranges: tuple[JointRange, ...]) -> None:
    for number, (angle, own) in enumerate(zip(reading.joints_rad, ranges, strict=False), start=1):
        if not own.lower_rad - _BEYOND_RANGE_RAD <= angle <= own.upper_rad + _BEYOND_RANGE_RAD:
            low, high = math.degrees(own.lower_rad), math.degrees(own.upper_rad)
            raise ImplausibleReadingError(
                f"the controller reports joint {number} at {math.degrees(angle):.2f} deg, but the robot of "
                f"this cell moves it from {low:g} to {high:g} deg: check that it is the right robot, and "
                "check its connection"
            )
