"""A FANUC robot with the Remote Motion Interface: moves to joint targets, at rest at every one.

The controller goes on with what it was sent when nobody is there any more. So it is sent short motions only,
and each when the one before has ended: whatever dies, the arm rests within a second.
"""

import asyncio
from collections.abc import Callable
from typing import Final, TypeVar

from truepose_drivers import arm_options
from truepose_drivers import options as option
from truepose_drivers.api import (
    Clock,
    DeviceIdentity,
    DriverPlugin,
    MotionGuard,
    Options,
)
from truepose_drivers.arm import CountedArm
from truepose_drivers.arm_motion import target_refused
from truepose_drivers.arm_options import Angles, JointCounting, Pace
from truepose_drivers.errors import (
    DeviceRefusedError,
    NoReplyError,
    NotInitialisedError,
)
from truepose_drivers.fanuc_rmi import protocol
from truepose_drivers.fanuc_rmi.conversation import Exchanges, Handover
from truepose_drivers.fanuc_rmi.motion_segments import LONGEST_PIECE_S, PieceMaker
from truepose_drivers.transports.link import Link, introduction, now_s
from truepose_drivers.transports.tcp import TcpLink

_UNKNOWN: Final = "unknown"
# What the controller may take, in wall time.
_SECOND_PORT_OPENS_WITHIN_S: Final = 2.0  # it is not opened to a second client
_REPLY_S: Final = 1.5
_INITIALISE_S: Final = 20.0  # to reset faults, to end its program and to begin it
_ALIVE_S: Final = 0.5  # of silence during a motion, after which it is asked whether it is there
_MOTION_S: Final = 20.0  # of each piece, in addition to its motion: somebody holds it at the pendant
_NEWER_S: Final = 0.5  # for joints that are newer than the last ones
# About 2.7 s were measured on a controller between a clean goodbye and the next session.
_NEXT_CLIENT_S: Final = 3.0  # after the last client has left

Answer = TypeVar("Answer")


class RmiRobot(CountedArm):
    """A controller behind a handed-over link. Keeps the conversation."""

    can_stop_motion = True  # a motion given up ends the session, and with it the program
    # Without a heartbeat the piece of a motion that was sent goes on to its end.

    def __init__(
        self,
        to_port: Callable[[int], Link],
        clock: Clock,
        *,
        first_port: int = protocol.CONNECT_PORT,
        counting: JointCounting | None = None,
        pace: Pace | None = None,
    ) -> None:
        self._link = Handover(to_port, first_port, reply_s=_REPLY_S, patience_s=_NEXT_CLIENT_S)
        super().__init__(self._link, clock, counting or JointCounting(), pace or Pace())
        self._exchanges = Exchanges(self._link, alive_s=_ALIVE_S, answer_s=_REPLY_S - 0.5)
        self._sequence = 0  # number of the next instruction
        self._override_percent = protocol.FASTEST_PERCENT  # that somebody set, as stated last
        self._stated: protocol.StatedAxes | None = None  # last in this session

    @property
    def motion_guard(self) -> MotionGuard:
        """What is sent at once is short at this driver's own speed, which may be far below the limits."""
        return MotionGuard(
            longest_piece_s=LONGEST_PIECE_S,
            speed_share=self._override_percent / protocol.FASTEST_PERCENT,
            takes_s=self._takes_s,
        )

    def _takes_s(self, start_rad: Angles, target_rad: Angles) -> float:
        maker = PieceMaker(self._counting, self._pace, self._limits)
        return maker.duration_s(self._counted_deg(start_rad), self._counted_deg(target_rad))

    async def connect(self) -> None:
        """Begin a session; raises ConnectFailedError. The motion group stays free before the first motion."""
        self._stated, self._exchanges.holds = None, True
        await self._exchanges.open()
        async with introduction(self._link, "check that no other program is connected to the robot"):
            # Joints are told before FRC_Initialize, which would lock the motion group against hand guiding.
            await self._newest_axes()  # those of the first reading must be newer

    async def identify(self) -> DeviceIdentity:
        """Return the interface's version, which is all that it tells of itself."""
        await self._status()
        return DeviceIdentity("FANUC", _UNKNOWN, _UNKNOWN, self._link.version)

    async def move_joints(self, target_rad: tuple[float, ...]) -> None:
        """Move all joints to `target_rad`; return when the arm rests there.

        Raises TargetRefusedError when the target is none or the controller says no, NotInitialisedError where
        the arm may not move or was stopped, with what to do.
        """
        target_deg = self._target_deg(target_rad)
        async with self._one_motion:
            await self._make_ready()
            while not await self._move_on(target_deg, self._override_percent):
                await self._status()
            await self._require_arrival((await self._shown())[0], target_deg)

    async def _shown(self) -> tuple[Angles, float]:  # between two pieces while the arm moves
        return (await self._newest_axes()).axes_deg[: protocol.JOINTS], protocol.RESOLUTION_DEG

    def _encode_target(self, target_deg: Angles) -> object:
        return protocol.encode_motion(protocol.JointMotion(0, target_deg, 1))

    async def _asked(self, name: protocol.Command, decode: Callable[[protocol.Packet], Answer]) -> Answer:
        async with self._exchanges.turn():
            return await self._answer(name, decode)

    async def _answer(self, name: protocol.Command, decode: Callable[[protocol.Packet], Answer]) -> Answer:
        answer = await self._exchanges.reply_to(protocol.command(name), _REPLY_S)
        if (error := protocol.error_of(answer)) != 0:
            raise DeviceRefusedError(f"the robot does not answer {name}: {protocol.in_words(error)}")
        return decode(answer)

    async def _newest_axes(self) -> protocol.StatedAxes:
        """Return axes that were stated later than any before in this session."""
        give_up_s = now_s() + _NEWER_S
        async with self._exchanges.turn():
            while not self._is_news(
                stated := await self._answer(protocol.Command.JOINTS, protocol.decode_axes)
            ):
                if now_s() > give_up_s:
                    raise NoReplyError(
                        "the robot repeats old data, or its clock has stopped: check the controller, then"
                        " connect again"
                    )
                await asyncio.sleep(0.002)
            self._stated = stated
        return stated

    def _is_news(self, stated: protocol.StatedAxes) -> bool:
        before = self._stated
        if before is None or stated.is_newer_than(before):
            return True
        if stated.time_ms != before.time_ms:
            raise protocol.RmiProtocolError(
                "the robot reports joints older than the last ones: connect again"
            )
        return False

    async def _status(self) -> protocol.Status:
        """Ask for the status between two motions, when no speed override but somebody else's holds."""
        status = await self._asked(protocol.Command.STATUS, protocol.decode_status)
        self._override_percent = status.override_percent
        return status

    async def _make_ready(self) -> None:
        """Have the controller take motions; raises NotInitialisedError."""
        status = await self._status()
        if status.pendant_on or status.single_step:
            what = (
                "switch its pendant off" if status.pendant_on else "turn off single-step mode on its pendant"
            )
            raise NotInitialisedError(
                f"the robot cannot move: {what}, set it to automatic mode, then confirm"
            )
        if self._exchanges.holds or not status.running:
            await self._initialise(status)
            # Read back, not begun at 1: on some controllers the count outlives FRC_Initialize, and a number
            # out of turn is refused or silently dropped.
            self._sequence = (await self._status()).next_sequence
            self._exchanges.holds = False

    async def _initialise(self, status: protocol.Status) -> None:
        """Begin the controller's program anew; its faults are reset where that is refused."""
        if status.running:
            # A program that an earlier session left running would keep the controller from being initialised.
            await self._told(protocol.Command.ABORT)
        if await self._told(protocol.Command.INITIALIZE) != 0:
            await self._told(protocol.Command.RESET)
            if (error := await self._told(protocol.Command.INITIALIZE)) != 0:
                raise NotInitialisedError(
                    f"the robot accepts no motions: {protocol.in_words(error)}{await self._shown_errors()};"
                    " correct this on the pendant, then confirm"
                )

    async def _told(self, name: protocol.Command) -> int:
        """Give a command that takes its time, and return with which error."""
        async with self._exchanges.turn():
            return protocol.error_of(await self._exchanges.reply_to(protocol.command(name), _INITIALISE_S))

    async def _shown_errors(self) -> str:
        texts = await self._asked(protocol.Command.ERROR_TEXTS, protocol.error_texts)
        return f' (it shows "{"; ".join(texts)[:200]}")' if texts else ""

    async def _move_on(self, target_deg: Angles, override_percent: int) -> bool:
        """Move to a target in pieces; return whether it was reached, before somebody set the override."""
        axes_deg = (await self._newest_axes()).axes_deg
        maker = PieceMaker(self._counting, self._pace, self._limits)
        pieces = maker.pieces(axes_deg, target_deg, override_percent)
        if pieces.override_percent != override_percent:
            await self._lower_override(pieces.override_percent)
        holds = True
        try:
            for end_deg in pieces.ends_deg:
                # Before each piece: the speed of the pieces keeps the limits at this override alone, and a
                # hand on the pendant may have turned it up.
                holds = await self._override_is(pieces.override_percent)
                if not holds:
                    return False
                await self._move(
                    protocol.JointMotion(self._sequence, end_deg, pieces.speed_percent), target_deg
                )
        finally:
            # An override that somebody set meanwhile is theirs, and stays.
            if holds and self.connected and pieces.override_percent != override_percent:
                await self._set_override(override_percent)
        return True

    async def _override_is(self, percent: int) -> bool:
        """Whether a speed override holds; raises NotInitialisedError where a fault holds the robot."""
        status = await self._asked(protocol.Command.STATUS, protocol.decode_status)
        if self._exchanges.holds or not status.running:
            raise NotInitialisedError(
                "the robot was stopped during the motion: check the pendant, then confirm"
            )
        return status.override_percent == percent

    async def _lower_override(self, percent: int) -> None:
        await self._set_override(percent)
        if not await self._override_is(percent):
            raise DeviceRefusedError(
                f"the robot does not keep a speed override of {percent} %: make sure that nobody else sets it"
            )

    async def _set_override(self, percent: int) -> None:
        async with self._exchanges.turn():
            request = protocol.command(protocol.Command.OVERRIDE, Value=percent)
            if (error := protocol.error_of(await self._exchanges.reply_to(request, _REPLY_S))) != 0:
                raise DeviceRefusedError(
                    f"the robot did not change its speed override: {protocol.in_words(error)}"
                )

    async def _move(self, motion: protocol.JointMotion, target_deg: Angles) -> None:
        async with self._exchanges.turn():
            end = await self._exchanges.end_of(protocol.encode_motion(motion), _MOTION_S)
            error = protocol.error_of(end)
            self._sequence += 1
            self._exchanges.holds = self._exchanges.holds or error != 0
        if error != 0:
            raise await self._refusal(error, target_deg)

    async def _refusal(self, error: int, target_deg: Angles) -> DeviceRefusedError:
        why = f"{protocol.in_words(error)}{await self._shown_errors()}"
        if protocol.is_of_target(error):
            return target_refused(target_deg, f", as its pendant counts them: {why}")
        return NotInitialisedError(f"the robot aborted its motion: {why}; check the pendant, then confirm")


def _open(options: Options, clock: Clock) -> RmiRobot:
    host = option.host(options)
    return RmiRobot(
        lambda port: TcpLink(host, port, connect_timeout_s=_SECOND_PORT_OPENS_WITHIN_S),
        clock,
        first_port=option.port(options, protocol.CONNECT_PORT),
        counting=arm_options.counting(options),
        pace=arm_options.pace(options),
    )


_OPTIONS = {
    "host": "address of the controller",
    "port": f"TCP port for new sessions, default {protocol.CONNECT_PORT}",
    **arm_options.COUNTING_OPTIONS,
    **arm_options.PACE_OPTIONS,
}
PLUGIN = DriverPlugin("fanuc_rmi", "robot", "rmi", _OPTIONS, _open)
