"""A FANUC robot that runs a MAPPDK server: moves to joint targets, at rest at every one.

A fault aborts the server's task on the controller and its socket just dies; then the link is closed, and so
it is after silence and nonsense, because replies carry no number. Where the motion ended is read after it.
"""

import asyncio
from dataclasses import dataclass

from truepose_drivers import arm_options
from truepose_drivers.api import (
    Clock,
    DeviceIdentity,
    DriverPlugin,
    MotionGuard,
    Options,
)
from truepose_drivers.arm import CountedArm
from truepose_drivers.arm_motion import (
    ARRIVED_DEG,
    CommandedMotion,
    answered_unless_it_stands,
    motion_awaited,
    target_refused,
)
from truepose_drivers.arm_options import Angles, JointCounting, Pace
from truepose_drivers.errors import (
    DeviceRefusedError,
    DriverError,
    LinkError,
)
from truepose_drivers.fanuc_mappdk import protocol
from truepose_drivers.fanuc_mappdk.conversation import Dialogue
from truepose_drivers.transports.link import Link, open_patiently
from truepose_drivers.transports.tcp import tcp_link

_UNKNOWN = "unknown"
_LONGEST_PIECE_S = 1.0  # of a motion to a stock server, which cannot be stopped once it was sent
_SHORTEST_MOTION_S = 0.1
_STILL_DEG = 0.002  # stock servers tell thousandths
_LONGER_BY_OVERRIDE = 20.0  # of a motion while the speed override on the pendant stands at 5 %
_LOOK_AT_PENDANT = (
    "check the pendant for a fault, clear it, start the server program again, then connect again"
)


@dataclass(frozen=True, slots=True)
class TimeOuts:
    """How long the controller may take, in wall time."""

    connect_s: float = 1.5  # it closes its socket before it listens again
    retry_s: float = 0.25
    greeting_s: float = 3.0
    reply_s: float = 1.8  # a robot that is gone is told within two seconds
    motion_s: float = 20.0  # in addition to the motion at a low speed override
    rest_of_reply_s: float = 0.25  # how long the end of an error in unknown words may lag behind


class MappdkRobot(CountedArm):
    """A MAPPDK server on a link; with the logger's link, joints are read while the arm moves too."""

    can_stop_motion = False  # the server reads no request while the arm moves

    def __init__(
        self,
        link: Link,
        clock: Clock,
        *,
        logger: Link | None = None,
        counting: JointCounting | None = None,
        pace: Pace | None = None,
        time_outs: TimeOuts | None = None,
    ) -> None:
        self._time_outs = time_outs or TimeOuts()
        self._motion = self._dialogue(link)
        self._logger = None if logger is None else self._dialogue(logger)
        self._logger_opens = asyncio.Lock()
        super().__init__(self._motion, clock, counting or JointCounting(), pace or Pace())
        self._watches: bool | None = None  # our own server runs there; None: it has not been asked
        self._watching = False  # it was asked to watch the motions of this connection

    @property
    def motion_guard(self) -> MotionGuard:
        """Our own server stops a motion when it hears nothing; a stock one goes on with what was sent."""
        if self._watches:
            return MotionGuard(stops_unheard_s=protocol.STOPS_WITHIN_S)
        return MotionGuard(longest_piece_s=_LONGEST_PIECE_S, takes_s=self._takes_s)

    def _takes_s(self, start_rad: Angles, target_rad: Angles) -> float:
        return self._request(self._counted_deg(start_rad), self._counted_deg(target_rad))[1]

    async def connect(self) -> None:
        """Open the link, trying again while the server may still be between two clients."""
        self._watching, self._watches = False, None
        if self._logger is not None:
            await self._logger.close()
        await open_patiently(
            self._motion.open,
            within_s=self._time_outs.connect_s,
            every_s=self._time_outs.retry_s,
            advice="also check on the pendant that the server program runs",
        )

    async def close(self) -> None:
        """Close the links; never raises. The server listens for the next client then."""
        await self._motion.close()
        if self._logger is not None:
            await self._logger.close()

    async def identify(self) -> DeviceIdentity:
        """Ask our own server for model, F number and version; a stock server tells nothing of them."""
        reply = await self._motion.ask(
            protocol.encode_request(protocol.Command.IDENTITY), "identity", self._time_outs.reply_s
        )
        stated = protocol.decode_identity(reply)
        self._watches = stated is not None
        model, serial, version = stated or (_UNKNOWN, _UNKNOWN, "MAPPDK")
        return DeviceIdentity(
            manufacturer="FANUC",
            model=model or _UNKNOWN,
            serial=serial or _UNKNOWN,
            firmware=version or _UNKNOWN,
        )

    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        """Move all joints to `target_rad`; return when the arm rests there.

        Raises TargetRefusedError when the target is none or the controller says no, ConnectionLostError
        when a fault ends its program.
        """
        target_deg = self._target_deg(target_rad)
        async with self._one_motion:
            # Whose server it is decides how a motion is sent, and what ends it when nobody waits any more.
            if self._watches is None:
                await self.identify()
            await self._have_watched()
            await self._carry_out(target_deg)
            await self._require_arrival(await self._joints_deg(), target_deg)

    async def _carry_out(self, target_deg: Angles) -> None:
        start_deg = await self._joints_deg()
        request, expected_s = self._request(start_deg, target_deg)
        timeout_s = self._time_outs.motion_s + _LONGER_BY_OVERRIDE * expected_s
        course = CommandedMotion(start_deg, target_deg, ARRIVED_DEG, _STILL_DEG)
        reply = await answered_unless_it_stands(
            self._moved(request, timeout_s), self._joints_under_way, course, _LOOK_AT_PENDANT
        )
        if reply.code != protocol.ReplyCode.OK:
            raise target_refused(target_deg, f", as its pendant counts them: {reply.message}")

    def _dialogue(self, link: Link) -> Dialogue:
        times = self._time_outs
        return Dialogue(link, greeting_s=times.greeting_s, rest_of_reply_s=times.rest_of_reply_s)

    async def _joints_deg(self) -> Angles:
        return protocol.joint_angles_deg(await self._ask_joints(self._motion))

    async def _shown(self) -> tuple[Angles, float]:
        """Ask where the joints are, the logger while the arm moves."""
        reply = await self._ask_joints(await self._free_port())
        return protocol.joint_angles_deg(reply), protocol.joint_resolution_deg(reply)

    async def _free_port(self) -> Dialogue:
        """Return the port that replies now, the motion port where there is no logger."""
        if not (self._motion.is_open and self._motion.taken):
            return self._motion
        # Without a logger the joints are told at the motion's end.
        return await self._opened_logger() or self._motion

    async def _opened_logger(self) -> Dialogue | None:
        if self._logger is None:
            return None
        async with self._logger_opens:
            if not self._logger.is_open:
                try:
                    await self._logger.open()
                except LinkError:  # its program does not run there
                    return None
        return self._logger

    async def _joints_under_way(self) -> Angles | None:
        try:
            logger = await self._opened_logger()
            # Not being able to look ends no motion: its own reply says how it went.
            return None if logger is None else protocol.joint_angles_deg(await self._ask_joints(logger))
        except DriverError:
            return None

    async def _ask_joints(self, port: Dialogue) -> protocol.Reply:
        reply = await port.ask(
            protocol.encode_request(protocol.Command.JOINTS), "joints", self._time_outs.reply_s
        )
        if reply.code != protocol.ReplyCode.OK:
            raise DeviceRefusedError(f"the robot does not report its joints: {reply.message}")
        return reply

    async def _have_watched(self) -> None:
        if not self._watches or self._watching:
            return
        reply = await self._motion.ask(
            protocol.encode_watch(protocol.SILENCE_S), "success", self._time_outs.reply_s
        )
        if reply.code != protocol.ReplyCode.OK:
            raise DeviceRefusedError(f"the robot does not monitor its motions: {reply.message}")
        self._watching = True

    async def _moved(self, request: bytes, timeout_s: float) -> protocol.Reply:
        unheard = f" or after {protocol.SILENCE_S:g} s without a message" if self._watching else ""
        with motion_awaited(_LOOK_AT_PENDANT, f", as it does at a fault{unheard}"):
            return await self._motion.ask(request, "success", timeout_s, beats=self._watching)

    def _request(self, start_deg: Angles, target_deg: Angles) -> tuple[bytes, float]:
        """Return the request of a motion within the limits, and how long it takes without override [s]."""
        before, after = self._counting.inclined(start_deg), self._counting.inclined(target_deg)
        steps_deg = [to - origin for origin, to in zip(before, after, strict=True)]
        least_s = max(self._pace.least_s(steps_deg, self._limits), _SHORTEST_MOTION_S)
        if self._watches and least_s <= protocol.LONGEST_TIMED_MOTION_S:
            return protocol.encode_timed_motion(protocol.TimedMotion(target_deg, least_s)), least_s
        percent = self._pace.share_percent(steps_deg, self._limits)
        if percent < 1:
            raise DeviceRefusedError(
                "MAPPDK has no speed below 1 % of the joints' maximum, which is above the limits:"
                f" this motion must take {least_s:.0f} s or more; raise the speed limits, or load truepose's"
                " own server program"
            )
        return (
            protocol.encode_motion(protocol.Command.MOVE_TO_JOINTS, protocol.Motion(target_deg, percent)),
            100.0 * self._pace.at_full_speed_s(steps_deg) / percent,
        )

    def _encode_target(self, target_deg: Angles) -> object:
        return protocol.encode_motion(protocol.Command.MOVE_TO_JOINTS, protocol.Motion(target_deg, 1))


def _open(options: Options, clock: Clock) -> MappdkRobot:
    logger = tcp_link(options, protocol.LOGGER_PORT, port="logger_port")
    return MappdkRobot(
        tcp_link(options, protocol.MOTION_PORT),
        clock,
        logger=logger,
        counting=arm_options.counting(options),
        pace=arm_options.pace(options),
    )


_OPTIONS = {
    "host": "address of the controller",
    "port": f"TCP port of the motion server, default {protocol.MOTION_PORT}",
    "logger_port": f"TCP port of the logger, default {protocol.LOGGER_PORT}; reports joints during motions",
    **arm_options.COUNTING_OPTIONS,
    **arm_options.PACE_OPTIONS,
}
PLUGIN = DriverPlugin("fanuc_mappdk", "robot", "mappdk", _OPTIONS, _open)
