"""An ABB robot that one protocol moves and whose joints arrive by EGM."""

from typing import Protocol

from truepose_drivers import options as option
from truepose_drivers.abb_egm.protocol import EGM_PORT
from truepose_drivers.abb_egm.reader import EgmReader
from truepose_drivers.api import (
    Clock,
    DeviceIdentity,
    GuardsMotion,
    JointReading,
    MotionGuard,
    MotionLimits,
    Options,
    RobotController,
)
from truepose_drivers.errors import DriverError
from truepose_drivers.transports.udp import UdpPort

EGM_OPTION = f"UDP port at which the joints arrive by EGM, often {EGM_PORT}; without it they are asked for"


class GuardingRobot(RobotController, GuardsMotion, Protocol):
    """A robot that says more about its motions than it must."""


class RobotReadByEgm:
    """A robot whose joints are read from its stream, and which moves only while that says that it can."""

    def __init__(self, robot: GuardingRobot, feedback: EgmReader) -> None:
        self._robot = robot
        self._feedback = feedback

    @property
    def connected(self) -> bool:
        """Whether both are there as far as known."""
        return self._robot.connected and self._feedback.connected

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
            await self._feedback.connect()
        except DriverError:
            await self._robot.close()
            raise

    async def close(self) -> None:
        """Close both; never raises."""
        await self._feedback.close()
        await self._robot.close()

    async def identify(self) -> DeviceIdentity:
        """Ask the protocol that moves it."""
        return await self._robot.identify()

    async def set_limits(self, limits: MotionLimits) -> None:
        """Set the speed limits of the following motions."""
        await self._robot.set_limits(limits)

    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        """Move where motors and program are ready now; raises NotInitialisedError, TargetRefusedError."""
        await self._feedback.require_ready()
        await self._robot.move_joints(target_rad)

    async def read_joints(self) -> JointReading:
        """Return where the joints are, by the stream; also while the arm moves."""
        return await self._feedback.read_joints()


def read_by_egm(robot: GuardingRobot, options: Options, clock: Clock) -> GuardingRobot:
    """Return a robot as its options have it: read by EGM where they say at which port."""
    if "egm_port" not in options:
        return robot
    port = UdpPort(option.host(options), option.port(options, name="egm_port"))
    return RobotReadByEgm(robot, EgmReader(port, clock))
