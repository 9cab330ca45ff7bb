"""What the controller knows of itself, and the RAPID programs that wait for their variables to be written."""

import asyncio
import math
from collections.abc import Coroutine
from dataclasses import dataclass
from typing import Any

import numpy as np

from truepose_drivers.abb_rws import protocol
from truepose_drivers.abb_rws.http import RwsProtocolError
from truepose_simulators.cell.robot import SpeedLimits, TargetOutOfRangeError
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ArmStoppedError, SimulatorError
from truepose_simulators.faults.kinds import EmergencyStop, ProtectiveStop, RobotHangs, RobotRefuses
from truepose_simulators.instruments.robot.clients import ProgramStoppedError, rest_after
from truepose_simulators.physics.rigid import FloatArray

ROBOTWARE = "6.08.01.00"
_FULL_PERCENT = 100.0
_INFORMATION, _ERROR = 1, 3
_MOST_EVENTS = 50


class RefusedError(SimulatorError):
    """The controller does not do what it was asked."""


@dataclass(frozen=True, slots=True)
class Event:
    """An entry of the event log."""

    number: int
    kind: int  # 1 information, 3 error
    code: int
    title: str
    description: str


class Task:
    """The RAPID program of the arm's task; this one is served elsewhere: open_abb's, with its own sockets."""

    def __init__(self) -> None:
        self.variables: dict[str, str] = {}

    def start(self) -> None:
        """Run on from where the program stands."""

    def stop(self) -> None:
        """Stand where it is."""

    def written(self, name: str) -> None:
        """Notice that somebody wrote a variable."""


class AbbController:
    """One controller; its arm is that of the cell."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self._state = protocol.ControllerState.MOTORS_ON
        self._execution = protocol.Execution.RUNNING
        self.mode = protocol.OperationMode.AUTO
        self.cycle = "forever"
        self.speed_percent = _FULL_PERCENT
        self.signals: dict[str, str] = {}
        self.files: dict[str, bytes] = {}
        self.events: list[Event] = []
        self.task = Task()

    @property
    def state(self) -> protocol.ControllerState:
        """Motors, as far as nobody and nothing holds them."""
        held_by = {
            EmergencyStop: protocol.ControllerState.EMERGENCY_STOP,
            ProtectiveStop: protocol.ControllerState.GUARD_STOP,
        }
        now_s = self.cell.clock.now_s
        stops = (state for kind, state in held_by.items() if self.cell.faults.holds(kind, now_s))
        return next(stops, self._state)

    @property
    def execution(self) -> protocol.Execution:
        """Whether the program runs; a stop ends it, and its release does not start it."""
        if (
            self._execution is protocol.Execution.RUNNING
            and self.state is not protocol.ControllerState.MOTORS_ON
        ):
            self.stop()
        return self._execution

    @property
    def runs(self) -> bool:
        """Whether the program runs."""
        return self.execution is protocol.Execution.RUNNING

    def limits(self, tool_mm_s: float, turning_deg_s: float) -> SpeedLimits:
        """Return speeds under the override."""
        share = self.speed_percent / _FULL_PERCENT
        return SpeedLimits(tool_mm_s * share, math.radians(turning_deg_s) * share, joint_share=share)

    def start(self, cycle: str) -> None:
        """Start the program; raises RefusedError."""
        if self.state is not protocol.ControllerState.MOTORS_ON:
            raise RefusedError("Operation is not allowed: motors are off")
        self.cycle = self.cycle if cycle == "asis" else cycle
        self._execution = protocol.Execution.RUNNING
        self.task.start()

    def restart(self) -> None:
        """Run the program from its beginning, as somebody does at the pendant; a stop that holds ends it."""
        self._execution = protocol.Execution.RUNNING

    def stop(self) -> None:
        """Stop the program, and the arm with it."""
        self._execution = protocol.Execution.STOPPED
        self.task.stop()
        self.cell.halt_robot()

    def fail(self, code: int, title: str, description: str) -> None:
        """Stop with an error in the event log, as RAPID does where nobody handles it."""
        self._note(_ERROR, code, title, description)
        self.stop()

    def reset_pointer(self) -> None:
        """Have the program begin at its beginning; raises RefusedError."""
        if self.runs:
            raise RefusedError("Operation is not allowed while the program is running")

    def switch(self, state: protocol.ControllerState) -> None:
        """Switch the motors, or have a stop happen to them."""
        if state is not protocol.ControllerState.MOTORS_ON and self.runs:
            self.stop()
        self._state = state
        self._note(
            _INFORMATION, 10010 if state is protocol.ControllerState.MOTORS_OFF else 10011, state.value, ""
        )

    def write(self, name: str, value: str) -> None:
        """Write a variable; raises RefusedError."""
        if name not in self.task.variables:
            raise RefusedError(f"Symbol {name} not found")
        self.task.variables[name] = value
        self.task.written(name)

    def _note(self, kind: int, code: int, title: str, description: str) -> None:
        number = self.events[-1].number + 1 if self.events else 1
        self.events = [*self.events, Event(number, kind, code, title, description)][-_MOST_EVENTS:]


_LOOK_S = 0.1  # between two looks of our program at the beat
_FLANGE = np.zeros(3)
_OUT_OF_RANGE = 50027
_EMERGENCY_STOP = 10013
_V100 = (100.0, 500.0)  # mm/s, deg/s
_NO_AXES = protocol.array_text((protocol.NO_AXIS,) * 6)
_JOINTS = 6


class _Motions(Task):
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
        if self._controller.speed_percent <= 0.0:
            return False  # it waits for a higher override, and never arrives
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
        order = protocol.Order()
        self._beats = _Beats(controller)
        self._report = protocol.Report(protocol.Progress.IDLE, order.values())
        self.variables = {
            protocol.NAME: protocol.SERVER,
            protocol.ORDER: order.encode(),
            protocol.BEAT: "0",
            protocol.REPORT: self._report.encode(),
        }

    def start(self) -> None:
        """Wait for an order; one from before counts for nothing."""
        self._tell(protocol.Progress.IDLE, protocol.decode_order(self.variables[protocol.ORDER]))

    def written(self, name: str) -> None:
        """Take an order, or set off at the first beat."""
        if not self._controller.runs:
            return
        if name == protocol.BEAT:
            self._beats.heard()
        under_way = self._report.progress in {protocol.Progress.TAKEN, protocol.Progress.MOVING}
        if name == protocol.ORDER and not under_way:
            self._take()
        elif name == protocol.BEAT and self._report.progress is protocol.Progress.TAKEN:
            self._tell(protocol.Progress.MOVING, self._order)
            self._begin(self._carry_out(self._order))

    def _take(self) -> None:
        try:
            self._order = protocol.decode_order(self.variables[protocol.ORDER])
        except RwsProtocolError:
            return  # a value that RAPID does not take stands in no variable
        if self._order.number == self._report.order[0]:
            return
        speeds = (self._order.tool_speed_mm_s, self._order.turning_speed_deg_s)
        self._tell(protocol.Progress.TAKEN if min(speeds) > 0.0 else protocol.Progress.REFUSED, self._order)
        # Else a beat of much later, of whatever client, would set the arm off.
        self._begin(self._give_up_unless_heard(self._order))

    async def _give_up_unless_heard(self, order: protocol.Order) -> None:
        if self._cell.clock.waits:
            await self._cell.clock.sleep(protocol.FIRST_BEAT_S)
            if self._report == protocol.Report(protocol.Progress.TAKEN, order.values()):
                self._tell(protocol.Progress.GIVEN_UP, order)

    async def _carry_out(self, order: protocol.Order) -> None:
        limits = self._controller.limits(order.tool_speed_mm_s, order.turning_speed_deg_s)
        try:
            if await self._move(np.array(order.target_deg), limits, self._beats, protocol.SILENCE_S):
                self._tell(protocol.Progress.ARRIVED, order)
        except ProgramStoppedError:
            self._tell(protocol.Progress.GIVEN_UP, order)

    def _tell(self, progress: protocol.Progress, order: protocol.Order) -> None:
        self._report = protocol.Report(progress, order.values())
        self.variables[protocol.REPORT] = self._report.encode()


class PublicProgram(_Motions):
    """What clients of Robot Web Services usually load: a target, and a number that says go."""

    def __init__(self, controller: AbbController) -> None:
        super().__init__(controller)
        zero = protocol.array_text((0.0,) * _JOINTS)
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
        try:
            target_deg = np.array(protocol.numbers(robot_axes, _JOINTS))
        except RwsProtocolError:
            return  # a value that RAPID does not take stands in no variable
        if await self._move(target_deg, self._controller.limits(*_V100), _Beats(self._controller), 0.0):
            self.variables["go"] = "0"


def program_of(controller: AbbController) -> Task:
    """Return the program that a scenario has loaded: ours, or the pattern of others."""
    ours = controller.cell.scenario.arm.server == "truepose"
    return OurProgram(controller) if ours else PublicProgram(controller)
