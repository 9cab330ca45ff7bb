"""A Universal Robots controller: state over RTDE, motion by a script that listens while it moves.

RTDE streams only while somebody asks: an exchange starts it and pauses it, so that nothing old waits to be
read, and takes only states whose time stamp has moved. A motion is a program of ours that reads its target
from RTDE registers and goes on only while the beat among them changes.
"""

import contextlib
import math
from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass, replace

from truepose_drivers.api import (
    Clock,
    DeviceIdentity,
    DriverPlugin,
    JointReading,
    MotionGuard,
    MotionLimits,
    Options,
)
from truepose_drivers.arm_motion import require_speeds, require_target
from truepose_drivers.errors import ConnectFailedError, DeviceRefusedError
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link, OnePortDevice, drain, introduction, now_s
from truepose_drivers.transports.tcp import tcp_link
from truepose_drivers.universal_robots import protocol
from truepose_drivers.universal_robots.progress import STANDING_RAD, Progress, require_ready
from truepose_drivers.universal_robots.script import (
    BEAT_S,
    INPUTS,
    JOINTS,
    OUTPUTS,
    PROGRAM,
    SCRIPT_PORT,
    STOPS_WITHIN_S,
    Order,
    RobotState,
    robot_state,
)

_FREQUENCY_HZ = 125.0  # which controllers of every series offer
_UNKNOWN = "unknown"
_REPLY_S = 2.0  # wall time, as the next
_STATE_S = 0.5  # for a state that is newer than the one before
_FURTHEST_RAD = 4.0 * math.pi  # beyond the range of any joint


@dataclass(frozen=True, slots=True)
class Ports:
    """The three connections to one controller."""

    rtde: Link
    script: Link
    dashboard: Link


class UniversalRobot(OnePortDevice):
    """A controller on three links. Keeps the conversation; computes nothing."""

    can_stop_motion = True  # a motion that is not waited for any more is stopped
    # Our program stops a motion when it hears nothing; the registers are read back.
    motion_guard = MotionGuard(stops_unheard_s=STOPS_WITHIN_S, speed_read_back=True)

    def __init__(self, ports: Ports, clock: Clock) -> None:
        self._link = ports.rtde
        self._rtde = Conversation[protocol.Packet](
            ports.rtde, protocol.PacketReader, harmless=(DeviceRefusedError,)
        )
        super().__init__(self._rtde)
        self._script = ports.script
        self._dashboard = Conversation[str](ports.dashboard, protocol.LineReader)
        self._clock = clock
        limits = MotionLimits()
        self._order = Order(
            tool_speed_mm_s=limits.tool_speed_mm_s, turning_speed_rad_s=limits.orientation_speed_rad_s
        )
        self._newest_s = -math.inf  # time stamp of the last state of this connection
        self._said = ""

    async def connect(self) -> None:
        """Open the link and agree on the registers; raises ConnectFailedError."""
        self._newest_s = -math.inf
        await self._rtde.open()
        async with introduction(self._rtde), self._rtde.turn():
            await self._agree()

    async def close(self) -> None:
        """Close the links; never raises."""
        await self._script.close()
        await self._dashboard.close()
        await self._rtde.close()

    async def identify(self) -> DeviceIdentity:
        """Ask RTDE for the software, the dashboard for serial number and model."""
        async with self._rtde.turn():
            firmware = protocol.stated_version(await self._asked(protocol.Packet(protocol.Kind.CONTROLLER)))
        try:
            await self._dashboard.open()
            async with self._dashboard.turn():
                serial, model = await self._names()
        finally:
            await self._dashboard.close()
        return DeviceIdentity(
            manufacturer="Universal Robots",
            model=model or _UNKNOWN,
            serial=serial or _UNKNOWN,
            firmware=firmware,
        )

    async def set_limits(self, limits: MotionLimits) -> None:
        """Write the speed limits of the following motions, and read them back."""
        require_speeds(limits)
        order = replace(
            self._order,
            tool_speed_mm_s=limits.tool_speed_mm_s,
            turning_speed_rad_s=limits.orientation_speed_rad_s,
        )
        async with self._rtde.turn(), self._streaming():
            await self._give(order)

    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        """Move all joints to `target_rad`; return when the arm rests there.

        Raises TargetRefusedError for a target that is none or that the controller does not take,
        NotInitialisedError where the arm may not move or was stopped, with what to do.
        """
        require_target(target_rad, JOINTS, _FURTHEST_RAD)
        async with self._rtde.turn(), self._streaming():
            before = await self._next_state()
            require_ready(before)
            await self._give(replace(self._order, number=before.unused_number, target_rad=target_rad))
            try:
                await self._script.open()
                await self._script.send(PROGRAM.encode())
                await self._follow(Progress(self._order, before, now_s()))
            finally:
                await self._script.close()

    async def read_joints(self) -> JointReading:
        """Return where the joints are now: of two states, whose time stamps differ, the later one."""
        async with self._rtde.turn(), self._streaming():
            await self._next_state()
            state = await self._next_state()
        return JointReading(
            joints_rad=state.joints_rad, resolution_rad=STANDING_RAD, time_s=await self._clock.now_s()
        )

    async def _agree(self) -> None:
        if not protocol.is_accepted(await self._asked(protocol.version_request())):
            raise protocol.UrProtocolError(
                "the controller uses an older RTDE version: its software must be 3.9 or 5.3, or later"
            )
        outputs = protocol.outputs_request(_FREQUENCY_HZ, OUTPUTS)
        self._outputs = _recipe(await self._asked(outputs), OUTPUTS)
        self._inputs = _recipe(await self._asked(protocol.inputs_request(INPUTS)), INPUTS)

    async def _names(self) -> tuple[str | None, str | None]:
        at = self._dashboard.address
        self._dashboard.expect(_REPLY_S, f"the dashboard at {at} sends no greeting: restart it")
        protocol.require_greeting(await self._dashboard.next())
        return await self._name(protocol.SERIAL_NUMBER), await self._name(protocol.ROBOT_MODEL)

    async def _name(self, question: str) -> str | None:
        silence = f'the dashboard at {self._dashboard.address} does not answer "{question}": connect again'
        await self._dashboard.send(protocol.encode_line(question), timeout_s=_REPLY_S, silence=silence)
        return protocol.stated_name(await self._dashboard.next())

    @contextlib.asynccontextmanager
    async def _streaming(self) -> AsyncIterator[None]:
        """Have the controller send its state, and take orders, for as long as this lasts."""
        self._said = ""
        await self._switch(protocol.Kind.START)
        try:
            yield
        # A refusal leaves the connection open, so the stream is paused; any other error closes the port.
        except DeviceRefusedError:
            await self._switch(protocol.Kind.PAUSE)
            raise
        await self._switch(protocol.Kind.PAUSE)

    async def _switch(self, kind: protocol.Kind) -> None:
        if not protocol.is_accepted(await self._asked(protocol.Packet(kind))):
            raise protocol.UrProtocolError(
                f"the robot does not {kind.name.lower()} its data stream: connect again"
            )

    async def _asked(self, request: protocol.Packet) -> bytes:
        """Send a request and return what its reply holds; states and texts may come before it."""
        await self._rtde.send(
            protocol.encode(request),
            timeout_s=_REPLY_S,
            silence=f"the robot at {self._rtde.address} is connected but does not respond: check the pendant,"
            " then connect again",
        )
        while (reply := await self._rtde.next()).kind != request.kind:
            if reply.kind not in {protocol.Kind.DATA, protocol.Kind.TEXT}:
                raise protocol.UrProtocolError(
                    f"the robot replied to {reply.kind.name}, not to {request.kind.name}: connect again"
                )
        return reply.payload

    async def _next_state(self) -> RobotState:
        """Return a state that is newer than all before; a clock that stands still is a lost connection."""
        self._rtde.expect(
            _STATE_S,
            f"the robot at {self._rtde.address} sends no new data, or its clock has stopped: check the"
            " network and the controller, then connect again",
        )
        while True:
            packet = await self._rtde.next()
            if packet.kind is protocol.Kind.TEXT:
                self._said = protocol.operator_message(packet.payload)
                continue
            state = self._state(packet)
            if state.timestamp_s > self._newest_s:
                self._newest_s = state.timestamp_s
                return state

    def _state(self, packet: protocol.Packet) -> RobotState:
        if packet.kind is not protocol.Kind.DATA:
            raise protocol.UrProtocolError(
                f"the robot sent {packet.kind.name} in its data stream: connect again"
            )
        return robot_state(self._outputs.unpack(packet.payload))

    async def _give(self, order: Order) -> None:
        """Write an order, and see it stand in the controller's registers."""
        await self._write(order)
        give_up_s = now_s() + _REPLY_S
        while (await self._next_state()).registers != order.values():
            if now_s() > give_up_s:
                raise protocol.UrProtocolError(
                    "the robot does not keep what is written to its registers 24 to 31: make sure that no"
                    " other program or URCap uses them, then connect again"
                )

    async def _write(self, order: Order) -> None:
        self._order = order
        await self._link.send(protocol.encode(self._inputs.pack(order.values())))

    async def _follow(self, progress: Progress) -> None:
        """Give beats until the arm has arrived."""
        beat_s = -math.inf
        while not progress.arrived(await self._next_state(), now_s(), self._said):
            if now_s() - beat_s >= BEAT_S:
                beat_s = now_s()
                await self._write(self._order.next_beat)
                await drain(self._script)  # this port sends states of its own, ten a second


def _recipe(payload: bytes, wanted: Mapping[str, str]) -> protocol.Recipe:
    number, types = protocol.recipe_stated(payload)
    named = dict(zip(wanted, types, strict=False))
    if protocol.IN_USE in types:
        used = next(name for name, kind in named.items() if kind == protocol.IN_USE)
        raise ConnectFailedError(
            f"another program writes {used} of the robot: stop it, so that only one program moves the arm"
        )
    if protocol.NOT_FOUND in types:
        unknown = next(name for name, kind in named.items() if kind == protocol.NOT_FOUND)
        raise protocol.UrProtocolError(
            f"the controller does not support {unknown}: its software must be 3.9 or 5.3, or later"
        )
    return protocol.agreed_recipe(number, types, wanted)


def _open(options: Options, clock: Clock) -> UniversalRobot:
    ports = Ports(
        rtde=tcp_link(options, protocol.RTDE_PORT),
        script=tcp_link(options, SCRIPT_PORT, port="script_port"),
        dashboard=tcp_link(options, protocol.DASHBOARD_PORT, port="dashboard_port"),
    )
    return UniversalRobot(ports, clock)


_OPTIONS = {
    "host": "address of the controller, as shown on the pendant",
    "port": f"TCP port of RTDE, default {protocol.RTDE_PORT}",
    "script_port": f"TCP port that takes scripts, default {SCRIPT_PORT}",
    "dashboard_port": f"TCP port of the dashboard, default {protocol.DASHBOARD_PORT}",
}
PLUGIN = DriverPlugin("universal_robots", "robot", "ur_rtde", _OPTIONS, _open)
