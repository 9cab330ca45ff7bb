"""One motion by our RAPID program: state, order, what it understood, beats until the arm has arrived."""

import asyncio
import math
import random
from dataclasses import dataclass, replace
from typing import Final

from truepose_drivers.abb_rws import protocol
from truepose_drivers.abb_rws.conversation import RwsSession
from truepose_drivers.api import Clock, JointReading
from truepose_drivers.arm_motion import farthest_off, stopped_unheard, target_refused
from truepose_drivers.errors import (
    BusyError,
    DeviceRefusedError,
    NoReplyError,
    NotInitialisedError,
    TargetRefusedError,
)
from truepose_drivers.transports.link import now_s

_BETWEEN_REPORTS_S: Final = 0.05
_BETWEEN_LOOKS_S: Final = 0.3  # at program and joints, while the arm moves
_SAME_PLACE_DEG: Final = 1e-2  # an arm that has not set off is no farther from where it was
_START: Final = {
    "regain": "continue",
    "execmode": "continue",
    "cycle": "once",
    "condition": "none",
    "stopatbp": "disabled",
    "alltaskbytsp": "true",
}


@dataclass(frozen=True, slots=True)
class Patience:
    """How long the program may take, in wall time."""

    taken_s: float = 2.0  # until it has taken an order
    stands_s: float = 20.0  # under way, at a low speed override or paused by somebody


async def read_panel(session: RwsSession) -> protocol.Panel:
    """Ask for motors, key switch, program and speed override."""
    return protocol.Panel(
        state=await session.get(protocol.CONTROLLER_STATE, protocol.controller_state),
        mode=await session.get(protocol.OPERATION_MODE, protocol.operation_mode),
        execution=await session.get(protocol.EXECUTION, protocol.execution),
        speed_percent=await session.get(protocol.SPEED_RATIO, protocol.speed_percent),
    )


async def read_joints(session: RwsSession, clock: Clock) -> JointReading:
    """Ask where the joints are; also while the arm moves."""
    joints_deg = await session.get(protocol.JOINT_TARGET, protocol.joint_angles_deg)
    return JointReading(
        joints_rad=tuple(map(math.radians, joints_deg)),
        resolution_rad=math.radians(protocol.RESOLUTION_DEG),
        time_s=await clock.now_s(),
    )


class RapidProgram:
    """Our program on the controller, as seen through its variables."""

    def __init__(self, session: RwsSession, patience: Patience) -> None:
        self._session = session
        self._patience = patience
        self._beat = float(random.randrange(1_000_000))  # another one than that of a client before

    async def carry_out(self, order: protocol.Order) -> None:
        """Have an order carried out; returns when the arm rests at its target.

        Raises NotInitialisedError where the arm may not move or was stopped, TargetRefusedError, BusyError.
        """
        await self._make_ready()
        stood_deg = await self.joints_deg()
        order = await self._give(order)
        await self._require_still_ready()
        await self._follow(order, _ObservedMotion(stood_deg, stood_deg, now_s()))

    async def joints_deg(self) -> tuple[float, ...]:
        """Ask where the joints are."""
        return await self._session.get(protocol.JOINT_TARGET, protocol.joint_angles_deg)

    async def _make_ready(self) -> None:
        """See that the arm may move, and start a program that stands, at its beginning."""
        now = await read_panel(self._session)
        if now.obstacle is not None:
            raise NotInitialisedError(f"the robot cannot move: {now.obstacle}; then confirm")
        await self._require_ours()
        if now.execution is protocol.Execution.STOPPED:
            # From its beginning: a program that was stopped within a motion would first end that motion.
            await self._session.act(protocol.EXECUTION, "resetpp")
            await self._session.act(protocol.EXECUTION, "start", _START)

    async def _require_still_ready(self) -> None:
        """See once more what a stop changes: requests are slow, and the first beat sets the arm off."""
        runs = await self._session.get(protocol.EXECUTION, protocol.execution)
        state = await self._session.get(protocol.CONTROLLER_STATE, protocol.controller_state)
        if runs is protocol.Execution.STOPPED or state is not protocol.ControllerState.MOTORS_ON:
            raise NotInitialisedError(
                f"the robot was stopped before it started to move ({state.value}): check the pendant, then"
                " confirm"
            )

    async def _require_ours(self) -> None:
        try:
            name = await self._session.get(protocol.SYMBOL_DATA + protocol.NAME, protocol.value_of)
        except DeviceRefusedError:
            name = ""
        if name != protocol.SERVER:
            raise NotInitialisedError(
                "the robot does not run the truepose program: load TruePoseRws.mod into task T_ROB1 from"
                " the pendant, then confirm"
            )

    async def _give(self, order: protocol.Order) -> protocol.Order:
        """Write an order and see that the program has understood it; nothing moves before the first beat."""
        before = await self._report()
        if before.progress in {protocol.Progress.TAKEN, protocol.Progress.MOVING}:
            raise BusyError("the robot is still moving: wait until it stops, then confirm")
        order = replace(order, number=before.next_number)
        await self._set(protocol.ORDER, order.encode())
        self._require_understood(order, await self._taken(order))
        return order

    async def _taken(self, order: protocol.Order) -> protocol.Report:
        give_up_s = now_s() + self._patience.taken_s
        while int((report := await self._report()).order[0]) != order.number:
            if now_s() > give_up_s:
                raise NotInitialisedError(
                    "the robot's program does not accept commands: check on the pendant why it stopped,"
                    " then confirm"
                )
            await asyncio.sleep(_BETWEEN_REPORTS_S)
        return report

    def _require_understood(self, order: protocol.Order, report: protocol.Report) -> None:
        if report.progress is protocol.Progress.REFUSED:
            raise _refused(order, "")
        if not report.is_about(order):
            raise DeviceRefusedError(
                f"the robot was sent {order.values()} and understood {report.order}: check for another"
                " program that writes its variables, then connect again"
            )

    async def _follow(self, order: protocol.Order, course: "_ObservedMotion") -> None:
        """Give beats until the arm has arrived."""
        beat_s = look_s = now_s() - protocol.BEAT_S
        while True:
            if now_s() - beat_s >= protocol.BEAT_S:
                beat_s = now_s()
                self._beat = protocol.beat_after(self._beat)
                await self._set(protocol.BEAT, protocol.number_text(self._beat))
            if _has_arrived(await self._report(), order):
                return
            if now_s() - look_s >= _BETWEEN_LOOKS_S:
                look_s = now_s()
                course = await self._look(order, course)
            await asyncio.sleep(_BETWEEN_REPORTS_S)

    async def _look(self, order: protocol.Order, course: "_ObservedMotion") -> "_ObservedMotion":
        """See that program and arm are under way."""
        if await self._session.get(protocol.EXECUTION, protocol.execution) is protocol.Execution.STOPPED:
            await self._tell_stop(order, course)
        here_deg = await self.joints_deg()
        if farthest_off(here_deg, course.last_deg) > _SAME_PLACE_DEG:
            return _ObservedMotion(course.start_deg, here_deg, now_s())
        if now_s() - course.moved_s > self._patience.stands_s:
            raise NoReplyError(
                f"the robot has not moved for {self._patience.stands_s:g} s and has not reached its target:"
                " check the pendant, then connect again"
            )
        return course

    async def _tell_stop(self, order: protocol.Order, course: "_ObservedMotion") -> None:
        """Say why the program stopped under way."""
        now = await read_panel(self._session)
        if now.obstacle is not None:
            raise NotInitialisedError(f"the robot stopped during the motion: {now.obstacle}; then confirm")
        said = await self._session.get(f"{protocol.EVENT_LOG}?lang=en", protocol.last_event)
        if farthest_off(await self.joints_deg(), course.start_deg) <= _SAME_PLACE_DEG:
            raise _refused(order, said)
        raise NotInitialisedError(
            f"the robot's program stopped during the motion{_quoted(said)}: check the pendant, then confirm"
        )

    async def _report(self) -> protocol.Report:
        return protocol.decode_report(
            await self._session.get(protocol.SYMBOL_DATA + protocol.REPORT, protocol.value_of)
        )

    async def _set(self, variable: str, value: str) -> None:
        await self._session.act(protocol.SYMBOL_DATA + variable, "set", {"value": value})


@dataclass(frozen=True, slots=True)
class _ObservedMotion:
    """Where the arm started, where it was seen last, and since when it was seen there."""

    start_deg: tuple[float, ...]
    last_deg: tuple[float, ...]
    moved_s: float


def _has_arrived(report: protocol.Report, order: protocol.Order) -> bool:
    if int(report.order[0]) != order.number:
        raise DeviceRefusedError(
            "another client commanded the robot: make sure that only one program moves it, then connect again"
        )
    if report.progress is protocol.Progress.GIVEN_UP:
        raise stopped_unheard(protocol.SILENCE_S)
    return report.progress is protocol.Progress.ARRIVED


def _refused(order: protocol.Order, said: str) -> TargetRefusedError:
    return target_refused(order.target_deg, f"{_quoted(said)}: check the pendant")


def _quoted(said: str) -> str:
    return f' (its event log ends with "{said}")' if said else ""
