"""A KUKA robot behind a variable proxy: its program TRUEPOSE moves to the target that its variables say.

The proxy reads and writes variables, and knows nothing of motions. The program moves only while a variable
keeps changing: whoever gave the order and is gone has the arm stopped.
"""

from collections.abc import Sequence
from typing import Final

from truepose_drivers import arm_options
from truepose_drivers.api import (
    Clock,
    DeviceIdentity,
    DriverPlugin,
    MotionGuard,
    Options,
)
from truepose_drivers.arm import CountedArm
from truepose_drivers.arm_motion import degrees_text
from truepose_drivers.arm_options import Angles, JointCounting, Pace
from truepose_drivers.errors import DeviceRefusedError, TargetRefusedError
from truepose_drivers.kuka_variable_proxy import protocol
from truepose_drivers.kuka_variable_proxy.conversation import Order, Program, VariableProxy
from truepose_drivers.transports.link import Link, introduction
from truepose_drivers.transports.tcp import tcp_link

_UNKNOWN: Final = "unknown"
_REPLY_S: Final = 1.5  # wall time, as the next
_MOTION_S: Final = 20.0  # in addition to the motion at the speed override that holds
# KUKA, "KR AGILUS sixx" specification: axis speeds of the KR 6 R900 sixx.
_AGILUS_PACE: Final = Pace(joint_speeds_deg_s=(360.0, 300.0, 360.0, 381.0, 388.0, 615.0))
_SIGNS: Final = (1, 1, 1, 1, 1, 1)


class KukaRobot(CountedArm):
    """A controller behind its proxy. Keeps the conversation; computes nothing."""

    can_stop_motion = True  # a motion given up is heard of no more, and the program stops the arm
    # The program stops a motion when it hears nothing.
    motion_guard = MotionGuard(stops_unheard_s=protocol.STOPS_WITHIN_S)

    def __init__(
        self,
        link: Link,
        clock: Clock,
        *,
        signs: tuple[int, ...] = _SIGNS,
        pace: Pace = _AGILUS_PACE,
    ) -> None:
        self._proxy = VariableProxy(link, reply_s=_REPLY_S)
        super().__init__(self._proxy, clock, JointCounting(signs, from_horizontal=False), pace)
        self._program = Program(self._proxy)

    async def connect(self) -> None:
        """Open the link and see that a robot is behind it; raises ConnectFailedError."""
        await self._proxy.open()
        async with introduction(self._proxy, "check that this is a KUKA controller"):
            await self._axes_deg()

    async def identify(self) -> DeviceIdentity:
        """Ask for serial number, model and software."""
        serial, model, software = [
            await self._named(name)
            for name in (protocol.Variable.SERIAL, protocol.Variable.MODEL, protocol.Variable.SOFTWARE)
        ]
        return DeviceIdentity("KUKA", model, serial, software)

    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        """Move all joints to `target_rad`; return when the arm rests there.

        Raises TargetRefusedError for a target that is none, NotInitialisedError where the arm may not move,
        refuses the target or was stopped, with what to do.
        """
        target_deg = self._target_deg(target_rad)
        async with self._one_motion:
            state = await self._program.ready()
            axes_deg = await self._axes_deg()
            order, duration_s = await self._order(axes_deg, target_deg)
            await self._program.give(order)
            try:
                await self._program.carry_out(state.unused_number, _MOTION_S + duration_s)
            except TargetRefusedError as error:
                raise TargetRefusedError(
                    f"joint target ({degrees_text(target_deg)}) deg, as the pendant counts: {error}"
                ) from error
            await self._require_arrival((await self._shown())[0], target_deg)

    async def _shown(self) -> tuple[Angles, float]:
        return (await self._axes_deg())[: protocol.JOINTS], protocol.STEP_DEG

    def _encode_target(self, target_deg: Angles) -> object:
        return protocol.encode_axes(target_deg)

    async def _axes_deg(self) -> Angles:
        return await self._proxy.read(protocol.Variable.AXES, protocol.decode_axes)

    async def _named(self, name: protocol.Variable) -> str:
        try:
            return await self._proxy.read(name, protocol.decode_text) or _UNKNOWN
        except DeviceRefusedError:  # older software does not have it
            return _UNKNOWN

    async def _order(self, axes_deg: Angles, target_deg: Angles) -> tuple[Order, float]:
        """Return the order of a motion within the limits, and how long it takes [s]."""
        # At 0 nothing moves, and no motion has a duration: 1 is the least at which this one will be made.
        override = max(await self._proxy.read(protocol.Variable.OVERRIDE, protocol.decode_count), 1)
        steps_deg = _inclined([to - origin for to, origin in zip(target_deg, axes_deg, strict=False)])
        percent, override = self._pace.share_and_override(steps_deg, self._limits, override)
        duration_s = 100.0 * self._pace.at_share_s(steps_deg, percent) / override
        return Order((*target_deg, *axes_deg[protocol.JOINTS :]), percent, override), duration_s


def _inclined(steps_deg: Sequence[float]) -> Angles:
    """Return by how much joints turn, for joint 3 the forearm: axes 2 and 3 both count downwards."""
    first, second, third, *wrist = steps_deg
    return (first, second, -(second + third), *wrist)


def _open(options: Options, clock: Clock) -> KukaRobot:
    return KukaRobot(
        tcp_link(options, protocol.PROXY_PORT),
        clock,
        signs=arm_options.signs(options, _SIGNS),
        pace=arm_options.pace(options, _AGILUS_PACE),
    )


_OPTIONS = {
    "host": "address of the controller",
    "port": f"TCP port of the variable proxy, default {protocol.PROXY_PORT}",
    "signs": "-1 for each joint with the opposite sign in the robot file, default: all 1",
    **arm_options.PACE_OPTIONS,
    "joint_speeds_deg_s": "maximum speeds of the six joints; default: those of the KR 6 R900 sixx",
}
PLUGIN = DriverPlugin("kuka_variable_proxy", "robot", "kuka_variable_proxy", _OPTIONS, _open)
