"""An ABB IRC5 robot that runs an open_abb server: moves to joint targets, at rest at every one.

The protocol has no error texts: a motion that the controller cannot make is silence, or a dropped
connection once somebody resets the program. After either the link is closed, because a late reply must
never be taken for the reply to a later request.
"""

import contextlib
import math
from dataclasses import dataclass

from truepose_drivers import options as option
from truepose_drivers.abb_egm.reader import EGM_OPTION, read_by_egm
from truepose_drivers.abb_open_abb import protocol
from truepose_drivers.abb_open_abb.joint_log import JointLog
from truepose_drivers.abb_rws.companion import LOGIN_OPTIONS, watched_by_rws
from truepose_drivers.api import (
    Clock,
    DeviceIdentity,
    DriverPlugin,
    FullRobot,
    JointReading,
    MotionGuard,
    MotionLimits,
    Options,
    Vector,
)
from truepose_drivers.arm import Arm
from truepose_drivers.arm_motion import (
    CommandedMotion,
    answered_unless_it_stands,
    motion_awaited,
    require_speeds,
    require_target,
    target_refused,
)
from truepose_drivers.errors import (
    ConnectionLostError,
    DeviceRefusedError,
    DriverError,
    NoReplyError,
    TargetRefusedError,
)
from truepose_drivers.transports.conversation import Turns
from truepose_drivers.transports.link import Link, drain, now_s, open_patiently
from truepose_drivers.transports.tcp import tcp_link

_JOINTS = 6
_INFO_FIELDS = ("serial number", "RobotWare version", "robot type")
_UNKNOWN = "unknown"
# Longest motion between two configurations: a wrist joint by two turns, or the tool along 20 m.
_LONGEST_TURN_RAD = 4.0 * math.pi
_LONGEST_PATH_MM = 20_000.0
_LONGEST_PIECE_S = 1.0  # of a motion to a stock server, which cannot be stopped once it was sent
_ARRIVED_DEG = 0.05  # a joint at rest is nearer to its target, as stock servers round
_STILL_DEG = 0.015  # the logger tells hundredths
_ORIGIN = ("0", "0", "0")
_UPRIGHT = ("1", "0", "0", "0")  # quaternion of no turn
_SPEED_ROUNDING = 0.06  # mm/s and deg/s: sent with one decimal and two

_LOOK_AT_PENDANT = (
    "check the pendant for a stopped program, a joint out of range, an emergency stop or motors off,"
    " clear it, restart the program, then connect again"
)


@dataclass(frozen=True, slots=True)
class TimeOuts:
    """How long the controller may take, in wall time."""

    connect_s: float = 1.5  # it looks for a new client every 0.5 s
    retry_s: float = 0.25
    reply_s: float = 1.8
    motion_s: float = 20.0  # in addition to the longest motion at the speed set
    rest_of_reply_s: float = 0.02  # how long the end of a reply without text may lag behind its status


class OpenAbbRobot(Arm):
    """An open_abb server on a link. Keeps the conversation; computes nothing."""

    can_stop_motion = False  # the server reads nothing while the arm moves

    def __init__(
        self,
        link: Link,
        clock: Clock,
        *,
        time_outs: TimeOuts | None = None,
        tool_mm: Vector = (0.0, 0.0, 0.0),
        log: JointLog | None = None,
    ) -> None:
        """Take the link to a controller; speeds hold at `tool_mm`, in the flange's frame."""
        super().__init__(link, clock)
        self._link = link
        self._log = log
        self._time_outs = time_outs or TimeOuts()
        self._turns = Turns(link)
        self._tool_mm = tool_mm
        self._limits_sent = False
        self._finest_decimals = 0  # of the angles that this server has given
        self._watches: bool | None = None  # our own server runs there; None: it has not been asked
        self._watching = False  # it was asked to watch the motions of this connection

    @property
    def motion_guard(self) -> MotionGuard:
        """Our own server stops a motion when it hears nothing; a stock one goes on with what was sent."""
        if self._watches:
            return MotionGuard(stops_unheard_s=protocol.STOPS_WITHIN_S, speed_read_back=True)
        return MotionGuard(longest_piece_s=_LONGEST_PIECE_S, speed_point_mm=self._tool_mm)

    async def connect(self) -> None:
        """Open the link, trying again while the server may still be between two clients."""
        self._limits_sent = self._watching = False
        self._watches = None
        await open_patiently(
            self._open_and_meet,
            within_s=self._time_outs.connect_s,
            every_s=self._time_outs.retry_s,
            advice="also check on the pendant that the server program runs",
        )

    async def _open_and_meet(self) -> None:
        """Open the link and see that a server answers, not merely the system that will pass us to one."""
        await self._link.open()
        try:
            await self.identify()
        except DriverError:
            await self._link.close()
            raise

    async def close(self) -> None:
        """Let the server listen for the next client, then close the link; never raises."""
        if self._link.is_open and not self._turns.taken:
            with contextlib.suppress(ConnectionLostError):
                # No reply comes to this one: the server closes its sockets and listens again.
                await self._link.send(protocol.encode_request(protocol.Code.CLOSE))
        await self._link.close()

    async def identify(self) -> DeviceIdentity:
        """Ask for serial number, RobotWare version and robot type."""
        reply = await self._ask(
            protocol.encode_request(protocol.Code.CONTROLLER_INFO), protocol.Code.CONTROLLER_INFO, words=1
        )
        fields = [field.strip() or _UNKNOWN for field in reply.text.split("*")]
        self._watches = protocol.is_our_server(fields)
        serial, firmware, model = [*fields, *[_UNKNOWN] * len(_INFO_FIELDS)][: len(_INFO_FIELDS)]
        return DeviceIdentity(manufacturer="ABB", model=model, serial=serial, firmware=firmware)

    async def set_limits(self, limits: MotionLimits) -> None:
        """Set the speed limits of the following motions, and stop exactly at every target."""
        require_speeds(limits)
        speed = [
            protocol.decimal(limits.tool_speed_mm_s, 1),
            protocol.decimal(math.degrees(limits.orientation_speed_rad_s), 2),
        ]
        # The server keeps the tool of whoever was here before, and holds the speed at its point.
        await self._ask(
            protocol.encode_request(
                protocol.Code.SET_TOOL, [*(protocol.decimal(mm, 1) for mm in self._tool_mm), *_UPRIGHT]
            ),
            protocol.Code.SET_TOOL,
        )
        await self._ask(
            protocol.encode_request(protocol.Code.SET_WORK_OBJECT, [*_ORIGIN, *_UPRIGHT]),
            protocol.Code.SET_WORK_OBJECT,
        )
        await self._ask(protocol.encode_request(protocol.Code.SET_SPEED, speed), protocol.Code.SET_SPEED)
        # A fly-by zone would answer before the arm is at rest; with "fine" the three zone sizes are moot.
        await self._ask(
            protocol.encode_request(protocol.Code.SET_ZONE, ["1", "0", "0", "0"]), protocol.Code.SET_ZONE
        )
        if self._watches:
            await self._require_speed([float(value) for value in speed])
        self._limits = limits
        self._limits_sent = True

    async def _require_speed(self, told: list[float]) -> None:
        """Read the speed back; raises DeviceRefusedError where the controller has another one."""
        reply = await self._ask(
            protocol.encode_request(protocol.Code.GET_SPEED), protocol.Code.GET_SPEED, words=2
        )
        stated = protocol.reply_numbers(reply, 2)
        if not all(abs(has - should) <= _SPEED_ROUNDING for has, should in zip(stated, told, strict=True)):
            await self._link.close()
            raise DeviceRefusedError(
                f"the robot was set to {told[0]:g} mm/s and {told[1]:g} deg/s but reports {stated[0]:g} mm/s "
                f"and {stated[1]:g} deg/s: check the program on the pendant, then connect again"
            )

    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        """Move all joints to `target_rad`; return when the arm rests there.

        Raises TargetRefusedError when the target is none or the controller says no, NoReplyError when
        it says nothing, as it does when it cannot make the motion.
        """
        request = _encode_target(target_rad)
        if not self._limits_sent:
            # The server starts with a fly-by zone, so a first motion without limits would not end at rest.
            await self.set_limits(self._limits)
        if self._watches and not self._watching:
            await self._ask(
                protocol.encode_request(protocol.Code.WATCH, [protocol.decimal(protocol.SILENCE_S, 2)]),
                protocol.Code.WATCH,
            )
            self._watching = True
        if self._log is None:
            await self._moved(request, target_rad)
        else:
            await self._moved_under_watch(request, target_rad, self._log)

    async def _moved_under_watch(self, request: bytes, target_rad: tuple[float, ...], log: JointLog) -> None:
        start_rad = (await self.read_joints()).joints_rad
        course = CommandedMotion(_in_degrees(start_rad), _in_degrees(target_rad), _ARRIVED_DEG, _STILL_DEG)
        moved = self._moved(request, target_rad)
        try:
            await answered_unless_it_stands(moved, log.joints_deg, course, _LOOK_AT_PENDANT)
        finally:
            await log.close()

    async def _moved(self, request: bytes, target_rad: tuple[float, ...]) -> None:
        unheard = f", as it does after {protocol.SILENCE_S:g} s without a message"
        try:
            with motion_awaited(_LOOK_AT_PENDANT, unheard if self._watching else ""):
                await self._ask(request, protocol.Code.MOVE_JOINTS, timeout_s=self._motion_timeout_s())
        except DeviceRefusedError as error:
            raise target_refused(_in_degrees(target_rad)) from error

    async def read_joints(self) -> JointReading:
        """Ask where the joints are; stock servers round to 0.01 deg."""
        reply = await self._ask_joints()
        if not protocol.ends_for_certain(reply) or protocol.joint_decimals(reply) > self._finest_decimals:
            reply = await self._confirmed(reply)
        joints_deg = protocol.joint_angles_deg(reply, _JOINTS)
        joints_rad = tuple(map(math.radians, joints_deg))
        return await self._reading(joints_rad, protocol.joint_resolution_deg(reply))

    async def _confirmed(self, reply: protocol.Reply) -> protocol.Reply:
        """Ask again where a digit may have been lost or come twice; raises OpenAbbProtocolError.

        A last number with fewer decimals may be a whole one, or one cut short. More decimals than the
        server ever gave come from an arm that stood at whole degrees until now, or from a bad line.
        """
        again = await self._ask_joints()
        finest = min(protocol.joint_decimals(reply), protocol.joint_decimals(again))
        self._finest_decimals = max(self._finest_decimals, finest)
        ends = protocol.ends_for_certain(again) or again.text == reply.text
        if not ends or protocol.joint_decimals(again) > self._finest_decimals:
            await self._link.close()
            raise protocol.OpenAbbProtocolError(
                f"the robot reported {reply.text!r}, then {again.text!r}: digits were lost or duplicated;"
                " connect again"
            )
        return again

    async def _ask_joints(self) -> protocol.Reply:
        return await self._ask(
            protocol.encode_request(protocol.Code.GET_JOINTS), protocol.Code.GET_JOINTS, words=_JOINTS
        )

    def _motion_timeout_s(self) -> float:
        turning_s = _LONGEST_TURN_RAD / self._limits.orientation_speed_rad_s
        path_s = _LONGEST_PATH_MM / self._limits.tool_speed_mm_s
        return self._time_outs.motion_s + max(turning_s, path_s)

    async def _ask(
        self, request: bytes, code: protocol.Code, *, words: int = 0, timeout_s: float | None = None
    ) -> protocol.Reply:
        """Send a request and return its reply, whose text has at least `words` words."""
        async with self._turns.turn():
            await drain(self._link)  # a line end or the like behind the last reply
            await self._link.send(request)
            beats = self._watching and code is protocol.Code.MOVE_JOINTS
            data = await self._receive_reply(code, words, timeout_s or self._time_outs.reply_s, beats=beats)
            reply = protocol.decode_reply(data)
            if reply.code != code:
                raise protocol.OpenAbbProtocolError(
                    f"the robot replied to request {reply.code}, not to {int(code)}: connect again"
                )
            _require_text(reply, words)
            behind = await self._link.receive(0.0)
            if behind is not None and behind.strip():
                raise protocol.OpenAbbProtocolError(
                    f"the robot sent more data than requested ({behind[:40]!r}): connect again"
                )
        if reply.status != protocol.ReplyStatus.OK:
            raise DeviceRefusedError(f"the robot refused request {int(code)} ({code.name}) as malformed")
        return reply

    async def _receive_reply(
        self, code: protocol.Code, words: int, timeout_s: float, *, beats: bool
    ) -> bytes:
        """Return a reply; with `beats` the controller hears meanwhile that somebody waits for it."""
        deadline_s = now_s() + timeout_s
        data = b""
        # The space that ends a reply without text may come as late as this one.
        while (extent := protocol.reply_extent(data := data.lstrip(b" \r\n"), code, words)) != "whole":
            if extent == "maybe whole" and words:
                return data + await self._rest(deadline_s)
            left_s = deadline_s - now_s()
            patience_s = self._time_outs.rest_of_reply_s if extent == "maybe whole" else left_s
            more = await self._link.receive(
                max(min(patience_s, protocol.BEAT_S) if beats else patience_s, 0.0)
            )
            if more is None and extent == "maybe whole":
                return data
            if more is None and beats and left_s > protocol.BEAT_S:
                await self._link.send(protocol.BEAT)
                continue
            if more is None:
                raise NoReplyError(
                    f"the robot at {self._link.address} is connected but does not respond: {_LOOK_AT_PENDANT}"
                )
            data += more
        return data

    async def _rest(self, deadline_s: float) -> bytes:
        """Return what still belongs to a reply whose end cannot be told: what comes before that to a ping."""
        await self._link.send(protocol.encode_request(protocol.Code.PING))
        data = b""
        while (rest := protocol.rest_before_ping(data)) is None:
            more = await self._link.receive(max(0.0, deadline_s - now_s()))
            if more is None or len(data) > protocol.LONGEST_MESSAGE_CHARS:
                raise NoReplyError(
                    f"the robot at {self._link.address} did not complete its reply: {_LOOK_AT_PENDANT}"
                )
            data += more
        return rest


def _require_text(reply: protocol.Reply, words: int) -> None:
    """See that a reply has the text that belongs there; raises OpenAbbProtocolError."""
    if reply.status != protocol.ReplyStatus.OK:
        return
    if reply.code == protocol.Code.GET_JOINTS:
        protocol.joint_angles_deg(reply, words)
    elif words == 0 and reply.text:
        raise protocol.OpenAbbProtocolError(
            f"the robot's reply to request {reply.code} continues with {reply.text[:40]!r}: connect again"
        )


def _encode_target(target_rad: tuple[float, ...]) -> bytes:
    require_target(target_rad, _JOINTS)
    try:
        return protocol.encode_joint_target([math.degrees(angle) for angle in target_rad])
    except ValueError as error:
        raise TargetRefusedError(str(error)) from error


def _in_degrees(angles_rad: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(map(math.degrees, angles_rad))


def _open(options: Options, clock: Clock) -> FullRobot:
    tool_mm = option.vector(options, "tool_mm")
    log = JointLog(tcp_link(options, port="log_port")) if "log_port" in options else None
    robot = OpenAbbRobot(tcp_link(options, protocol.MOTION_PORT), clock, tool_mm=tool_mm, log=log)
    return read_by_egm(watched_by_rws(robot, options, clock), options, clock)


_OPTIONS = {
    "host": "address of the controller, often 192.168.125.1",
    "port": f"TCP port of the motion server, default {protocol.MOTION_PORT}",
    "tool_mm": 'point to which speed limits apply, in flange coordinates: "0 0 125"; default: the flange',
    "log_port": f"TCP port of the logger, often {protocol.LOGGER_PORT}, to monitor the motion; not used"
    " by default",
    "rws_port": "TCP port of Robot Web Services, often 80, to monitor state and joints; not used by default",
    **LOGIN_OPTIONS,
    "egm_port": EGM_OPTION,
}
PLUGIN = DriverPlugin("abb_open_abb", "robot", "open_abb", _OPTIONS, _open)
