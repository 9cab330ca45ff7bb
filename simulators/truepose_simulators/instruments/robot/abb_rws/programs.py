"""RAPID programs that wait for somebody to write their variables: ours, and the pattern that others use."""

import asyncio
from collections.abc import Coroutine
from typing import Any

import numpy as np

from truepose_drivers.abb_rws.protocol.errors import RwsProtocolError
from truepose_drivers.abb_rws.protocol.program import (
    BEAT,
    FIRST_BEAT_S,
    NAME,
    ORDER,
    REPORT,
    SERVER,
    SILENCE_S,
    Order,
    Progress,
    Report,
    decode_order,
)
from truepose_drivers.abb_rws.protocol.rapid import NO_AXIS, array_text, numbers
from truepose_simulators.cell.robot import SpeedLimits, TargetOutOfRangeError
from truepose_simulators.errors import ArmStoppedError
from truepose_simulators.faults.kinds import RobotHangs, RobotRefuses
from truepose_simulators.instruments.robot.abb_rws.controller import AbbController, Task
from truepose_simulators.instruments.robot.served_client import ProgramStoppedError, rest_after
from truepose_simulators.physics.rigid import FloatArray

_LOOK_S = 0.1  # between two looks of our program at the beat
_FLANGE = np.zeros(3)
_OUT_OF_RANGE = 50027
_EMERGENCY_STOP = 10013
_V100 = (100.0, 500.0)  # mm/s, deg/s
_NO_AXES = array_text((NO_AXIS,) * 6)
_JOINTS = 6


class _Motions:
    """What both programs do with the arm: one motion at a time, on a task of the event loop."""

    def __init__(self, controller: AbbController) -> None:
        self._controller = controller
        self._cell = controller.cell
        self._motion: asyncio.Task[None] | None = None

    def stop(self) -> None:
        """Stand where it is; a motion under way is not gone on with."""
        if self._motion is not None:
            self._motion.cancel()

    def _begin(self, motion: Coroutine[Any, Any, None]) -> None:
        self._motion = asyncio.create_task(motion)

    async def _move(
        self, target_deg: FloatArray, limits: SpeedLimits, silent: "_Beats", watched_s: float
    ) -> bool:
        """Move; whether the arm arrived and the program knows it. Errors stop the program."""
        fault = self._cell.faults.next_move()
        try:
            if isinstance(fault, RobotRefuses):
                raise TargetOutOfRangeError("the target was refused")
            motion = self._cell.set_off([np.radians(target_deg)], limits, _FLANGE)
            await rest_after(self._cell, motion.duration_s, silent, watched_s=watched_s, look_s=_LOOK_S)
        except TargetOutOfRangeError as error:
            self._controller.fail(_OUT_OF_RANGE, "Joint Out of Range", str(error))
            return False
        except ArmStoppedError as error:
            self._controller.fail(_EMERGENCY_STOP, "Emergency stop state", str(error))
            return False
        return not isinstance(fault, RobotHangs)


class _Beats:
    """Since when nobody wrote the beat."""

    def __init__(self, controller: AbbController) -> None:
        self._clock = controller.cell.clock
        self.heard()

    def heard(self) -> None:
        """Note that it was written."""
        self._heard_s = self._clock.now_s

    def silent_s(self) -> float:
        """How long nothing was heard [s, cell time]."""
        return self._clock.now_s - self._heard_s


class OurProgram(_Motions):
    """TruePoseRws.mod: takes an order, says what it understood, moves as long as beats come."""

    def __init__(self, controller: AbbController) -> None:
        super().__init__(controller)
        order = Order()
        self._beats = _Beats(controller)
        self._report = Report(Progress.IDLE, order.values())
        self.variables = {NAME: SERVER, ORDER: order.encode(), BEAT: "0", REPORT: self._report.encode()}

    def start(self) -> None:
        """Wait for an order; one from before counts for nothing."""
        self._tell(Progress.IDLE, decode_order(self.variables[ORDER]))

    def written(self, name: str) -> None:
        """Take an order, or set off at the first beat."""
        if not self._controller.runs:
            return
        if name == BEAT:
            self._beats.heard()
        under_way = self._report.progress in {Progress.TAKEN, Progress.MOVING}
        if name == ORDER and not under_way:
            self._take()
        elif name == BEAT and self._report.progress is Progress.TAKEN:
            self._tell(Progress.MOVING, self._order)
            self._begin(self._carry_out(self._order))

    def _take(self) -> None:
        try:
            self._order = decode_order(self.variables[ORDER])
        except RwsProtocolError:
            return  # a value that RAPID does not take stands in no variable
        if self._order.number == self._report.order[0]:
            return
        speeds = (self._order.tool_speed_mm_s, self._order.turning_speed_deg_s)
        self._tell(Progress.TAKEN if min(speeds) > 0.0 else Progress.REFUSED, self._order)
        self._begin(self._give_up_unless_heard(self._order))

    async def _give_up_unless_heard(self, order: Order) -> None:
        if self._cell.clock.waits:
            await self._cell.clock.sleep(FIRST_BEAT_S)
            if self._report == Report(Progress.TAKEN, order.values()):
                self._tell(Progress.GIVEN_UP, order)

    async def _carry_out(self, order: Order) -> None:
        limits = self._controller.limits(order.tool_speed_mm_s, order.turning_speed_deg_s)
        try:
            if await self._move(np.array(order.target_deg), limits, self._beats, SILENCE_S):
                self._tell(Progress.ARRIVED, order)
        except ProgramStoppedError:
            self._tell(Progress.GIVEN_UP, order)

    def _tell(self, progress: Progress, order: Order) -> None:
        self._report = Report(progress, order.values())
        self.variables[REPORT] = self._report.encode()


class PublicProgram(_Motions):
    """What clients of Robot Web Services usually load: a target, and a number that says go."""

    def __init__(self, controller: AbbController) -> None:
        super().__init__(controller)
        zero = array_text((0.0,) * _JOINTS)
        self.variables = {"tgt": f"[{zero},{_NO_AXES}]", "go": "0"}

    def start(self) -> None:
        """Wait until it is told to go."""
        self.written("go")

    def written(self, name: str) -> None:
        """Go, where somebody says so."""
        if self._controller.runs and name == "go" and self.variables["go"].strip() not in {"0", "0.0"}:
            self._begin(self._carry_out())

    async def _carry_out(self) -> None:
        robot_axes = self.variables["tgt"].removeprefix("[").partition("]")[0] + "]"
        target_deg = np.array(numbers(robot_axes, _JOINTS))
        if await self._move(target_deg, self._controller.limits(*_V100), _Beats(self._controller), 0.0):
            self.variables["go"] = "0"


def program_of(controller: AbbController) -> Task:
    """Return the program that a scenario has loaded: ours, or the pattern of others."""
    ours = controller.cell.scenario.arm.server == "truepose"
    return OurProgram(controller) if ours else PublicProgram(controller)
