"""A robot that one protocol moves and another one watches: its joints, and whether it can move."""

import asyncio
from typing import Final, Protocol

from truepose_drivers.api import (
    DeviceIdentity,
    FullRobot,
    JointReading,
    MotionGuard,
    MotionLimits,
)
from truepose_drivers.errors import DriverError, LinkError, TargetRefusedError

_BETWEEN_LOOKS_S: Final = 0.3  # at whether the arm can still move, while it does


class Companion(Protocol):
    """A second connection to the controller of a robot, which moves nothing."""

    @property
    def connected(self) -> bool:
        """Whether it is there as far as known."""
        ...

    async def connect(self) -> None:
        """Open it; raises ConnectFailedError."""
        ...

    async def close(self) -> None:
        """Close it; never raises."""
        ...

    async def require_ready(self) -> None:
        """Raise NotInitialisedError where the arm cannot move, by what the controller states now."""
        ...

    async def read_joints(self) -> JointReading:
        """Ask where the joints are."""
        ...

    async def last_words(self) -> str:
        """Return what the controller said last to people, empty where that is not known."""
        ...


class AccompaniedRobot:
    """A robot whose companion reads the joints, and which moves only where that says that it can."""

    def __init__(self, robot: FullRobot, companion: Companion) -> None:
        self._robot = robot
        self._companion = companion

    @property
    def connected(self) -> bool:
        """Whether both are there as far as known."""
        return self._robot.connected and self._companion.connected

    @property
    def can_stop_motion(self) -> bool:
        """What the protocol says that moves it."""
        return self._robot.can_stop_motion

    @property
    def motion_guard(self) -> MotionGuard:
        """What the protocol says that moves it."""
        return self._robot.motion_guard

    async def connect(self) -> None:
        """Connect both; raises ConnectFailedError."""
        await self._robot.connect()
        try:
            await self._companion.connect()
        except DriverError:
            await self._robot.close()
            raise

    async def close(self) -> None:
        """Close both; never raises."""
        await self._companion.close()
        await self._robot.close()

    async def identify(self) -> DeviceIdentity:
        """Ask the protocol that moves it."""
        return await self._robot.identify()

    async def set_limits(self, limits: MotionLimits) -> None:
        """Set the speed limits of the following motions."""
        await self._robot.set_limits(limits)

    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        """Move where the controller is ready now; raises NotInitialisedError, TargetRefusedError."""
        await self._companion.require_ready()
        motion = asyncio.create_task(self._robot.move_joints(target_rad))
        try:
            while not (await asyncio.wait({motion}, timeout=_BETWEEN_LOOKS_S))[0]:
                await self._companion.require_ready()
            motion.result()
        except (LinkError, TargetRefusedError) as error:
            raise type(error)(f"{error}{await self._said()}") from error
        finally:
            motion.cancel()
            await asyncio.wait({motion})

    async def read_joints(self) -> JointReading:
        """Return where the joints are, by the companion; also while the arm moves."""
        return await self._companion.read_joints()

    async def _said(self) -> str:
        try:
            said = await self._companion.last_words()
        except DriverError:
            return ""
        return f' (its event log ends with "{said}")' if said else ""
