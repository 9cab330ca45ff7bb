"""What drivers of arms have in common, and those more whose controllers count joints in their own way."""

import asyncio
import math
import sys
from abc import ABC, abstractmethod
from typing import ClassVar

from truepose_drivers.api import Clock, JointReading, MotionLimits
from truepose_drivers.arm_motion import ARRIVED_DEG, farthest_off, require_speeds, require_target
from truepose_drivers.arm_options import Angles, JointCounting, Pace
from truepose_drivers.errors import RemoteProtocolError, TargetRefusedError
from truepose_drivers.transports.link import OnePortDevice, Port

_JOINTS = 6


class Arm(OnePortDevice):
    """The arm at the far end of a port, on which its driver keeps the conversation."""

    fastest: ClassVar[float] = sys.float_info.max  # speed that its controller can be told [mm/s, rad/s]

    def __init__(self, port: Port, clock: Clock) -> None:
        super().__init__(port)
        self._clock = clock
        self._limits = MotionLimits()
        self._one_motion = asyncio.Lock()

    async def set_limits(self, limits: MotionLimits) -> None:
        """Set the limits of the following motions, whose speed goes out with each of them."""
        require_speeds(limits, self.fastest)
        self._limits = limits

    async def _reading(self, joints_rad: Angles, step_deg: float) -> JointReading:
        """Return joints that were told just now, in steps of `step_deg`."""
        return JointReading(joints_rad, math.radians(step_deg), await self._clock.now_s())


class CountedArm(Arm, ABC):
    """An arm whose controller counts joints in a way of its own, and knows speeds of joints only."""

    def __init__(self, port: Port, clock: Clock, counting: JointCounting, pace: Pace) -> None:
        super().__init__(port, clock)
        self._counting = counting
        self._pace = pace

    @abstractmethod
    async def _shown(self) -> tuple[Angles, float]:
        """Ask where the joints are, as the controller counts them, and in which steps it tells that [deg]."""

    @abstractmethod
    def _encode_target(self, target_deg: Angles) -> object:
        """Write a target as the controller counts it; raises ValueError where a frame has no room for it."""

    async def read_joints(self) -> JointReading:
        """Ask where the joints are."""
        shown_deg, step_deg = await self._shown()
        joints_rad = self._counting.of_robot(tuple(map(math.radians, shown_deg)))
        return await self._reading(joints_rad, step_deg)

    def _counted_deg(self, joints_rad: Angles) -> Angles:
        return self._counting.of_controller(tuple(map(math.degrees, joints_rad)))

    def _target_deg(self, target_rad: Angles) -> Angles:
        """Return a target as the controller counts it; raises TargetRefusedError where it cannot be sent."""
        require_target(target_rad, _JOINTS)
        target_deg = self._counted_deg(target_rad)
        try:
            # Tried before anything of the motion is sent, so that a target which cannot be written leaves the
            # arm and its speeds as they were.
            self._encode_target(target_deg)
        except ValueError as error:
            raise TargetRefusedError(str(error)) from error
        return target_deg

    async def _require_arrival(self, stands_deg: Angles, target_deg: Angles) -> None:
        """See that the arm is where it was sent; a late reply to something else may have said so."""
        off_deg = farthest_off(stands_deg, target_deg)
        if off_deg > ARRIVED_DEG:
            await self.close()
            raise RemoteProtocolError(
                f"the robot reported the end of its motion but is {off_deg:.3f} deg off its target:"
                " check the pendant for a fault, clear it, then connect again"
            )
