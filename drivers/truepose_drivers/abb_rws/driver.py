"""An ABB IRC5 through Robot Web Services: state and full-precision joints, and motion by a program of ours.

Robot Web Services 1.0 move nothing themselves. A RAPID program waits for an order in a variable, says what
it understood, sets off at the first beat and stops when the beats do. Before every order the state of motors,
key switch, program and speed override is asked for anew.
"""

import math
from typing import Final

from truepose_drivers.abb_egm.reader import EGM_OPTION, read_by_egm
from truepose_drivers.abb_rws import protocol
from truepose_drivers.abb_rws.companion import LOGIN_OPTIONS, login_of
from truepose_drivers.abb_rws.conversation import RwsSession
from truepose_drivers.abb_rws.http import Login
from truepose_drivers.abb_rws.motion import Patience, RapidProgram, read_joints, read_panel
from truepose_drivers.abb_rws.protocol import STOPS_WITHIN_S, Order, Panel
from truepose_drivers.api import (
    Clock,
    DeviceIdentity,
    DriverPlugin,
    FullRobot,
    JointReading,
    MotionGuard,
    Options,
)
from truepose_drivers.arm import Arm
from truepose_drivers.arm_motion import require_target
from truepose_drivers.errors import (
    BusyError,
    DeviceRefusedError,
    DriverError,
    NotInitialisedError,
    TargetRefusedError,
)
from truepose_drivers.transports.link import Link
from truepose_drivers.transports.tcp import tcp_link

_UNKNOWN: Final = "unknown"
_FURTHEST_RAD: Final = math.radians(3600.0)  # no joint is wound up further


class RwsRobot(Arm):
    """A controller on a link. Keeps the conversation; computes nothing."""

    fastest = 1e9  # a number of RAPID, far beyond any arm
    can_stop_motion = True  # a motion that is not waited for any more is stopped
    # Our program stops a motion when it hears nothing, and says what it understood of an order.
    motion_guard = MotionGuard(stops_unheard_s=STOPS_WITHIN_S, speed_read_back=True)

    def __init__(
        self,
        link: Link,
        clock: Clock,
        login: Login | None = None,
        *,
        patience: Patience | None = None,
    ) -> None:
        known = login or Login(protocol.USER, protocol.PASSWORD)
        self._session = RwsSession(link, known)
        super().__init__(self._session, clock)
        self._program = RapidProgram(self._session, patience or Patience())

    async def connect(self) -> None:
        """Open the link and log in; raises ConnectFailedError, DeviceRefusedError."""
        await self._session.log_in()

    async def close(self) -> None:
        """End the session, then close the link; never raises."""
        await self._session.leave()

    async def identify(self) -> DeviceIdentity:
        """Ask for serial number, robot type and RobotWare version."""
        return DeviceIdentity(
            manufacturer="ABB",
            model=await self._stated(protocol.ROBOT_TYPE, "robot-type"),
            serial=await self._stated(protocol.IDENTITY, "ctrl-id"),
            firmware=await self._stated(protocol.SYSTEM, "rwversion"),
        )

    async def read_panel(self) -> Panel:
        """Ask for motors, key switch, program and speed override."""
        return await read_panel(self._session)

    async def read_joints(self) -> JointReading:
        """Ask where the joints are; also while the arm moves."""
        return await read_joints(self._session, self._clock)

    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        """Move all joints to `target_rad`; return when the arm rests there.

        Raises TargetRefusedError for a target that is none or that the controller does not take,
        NotInitialisedError where the arm may not move or was stopped, with what to do.
        """
        order = self._order(target_rad)
        async with self._one_motion:
            try:
                await self._program.carry_out(order)
            except (BusyError, NotInitialisedError, TargetRefusedError):
                raise
            except DriverError:
                await self._session.close()  # whatever it was, no later answer is taken for one to this
                raise

    def _order(self, target_rad: tuple[float, ...]) -> Order:
        require_target(target_rad, protocol.JOINTS, _FURTHEST_RAD)
        return Order(
            target_deg=tuple(map(math.degrees, target_rad)),
            tool_speed_mm_s=self._limits.tool_speed_mm_s,
            turning_speed_deg_s=math.degrees(self._limits.orientation_speed_rad_s),
        )

    async def _stated(self, target: str, name: str) -> str:
        """Return what a controller says of itself, `unknown` where it does not know the question."""
        try:
            return await self._session.get(target, lambda told: protocol.state_text(told, name)) or _UNKNOWN
        except DeviceRefusedError:
            return _UNKNOWN


def _open(options: Options, clock: Clock) -> FullRobot:
    robot = RwsRobot(tcp_link(options, protocol.PORT), clock, login_of(options))
    return read_by_egm(robot, options, clock)


_OPTIONS = {
    "host": "address of the controller, often 192.168.125.1",
    "port": f"TCP port of its web services, default {protocol.PORT}",
    **LOGIN_OPTIONS,
    "egm_port": EGM_OPTION,
}
PLUGIN = DriverPlugin("abb_rws", "robot", "rws", _OPTIONS, _open)
