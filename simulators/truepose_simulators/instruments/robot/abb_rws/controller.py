"""What the controller knows of itself: motors, key switch, speed override, program, variables, event log."""

import math
from dataclasses import dataclass
from typing import Protocol

from truepose_drivers.abb_rws.protocol.panel import ControllerState, Execution, OperationMode
from truepose_simulators.cell.robot import SpeedLimits
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import SimulatorError
from truepose_simulators.faults.kinds import EmergencyStop, ProtectiveStop

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


class Task(Protocol):
    """The RAPID program of the arm's task."""

    variables: dict[str, str]

    def start(self) -> None:
        """Run on from where the program stands."""

    def stop(self) -> None:
        """Stand where it is."""

    def written(self, name: str) -> None:
        """Notice that somebody wrote a variable."""


class ServedElsewhere:
    """A program that is no part of this: open_abb's, with its own sockets."""

    def __init__(self) -> None:
        self.variables: dict[str, str] = {}

    def start(self) -> None:
        """Do nothing more than stand as running."""

    def stop(self) -> None:
        """Do nothing more than stand as stopped."""

    def written(self, name: str) -> None:
        """Do nothing: it has no variables."""


class AbbController:
    """One controller; its arm is that of the cell."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self._state = ControllerState.MOTORS_ON
        self._execution = Execution.RUNNING
        self.mode = OperationMode.AUTO
        self.cycle = "forever"
        self.speed_percent = _FULL_PERCENT
        self.signals: dict[str, str] = {}
        self.files: dict[str, bytes] = {}
        self.events: list[Event] = []
        self.task: Task = ServedElsewhere()

    @property
    def state(self) -> ControllerState:
        """Motors, as far as nobody and nothing holds them."""
        held_by = {
            EmergencyStop: ControllerState.EMERGENCY_STOP,
            ProtectiveStop: ControllerState.GUARD_STOP,
        }
        now_s = self.cell.clock.now_s
        stops = (state for kind, state in held_by.items() if self.cell.faults.holds(kind, now_s))
        return next(stops, self._state)

    @property
    def execution(self) -> Execution:
        """Whether the program runs; a stop ends it, and its release does not start it."""
        if self._execution is Execution.RUNNING and self.state is not ControllerState.MOTORS_ON:
            self.stop()
        return self._execution

    @property
    def runs(self) -> bool:
        """Whether the program runs."""
        return self.execution is Execution.RUNNING

    @property
    def serial(self) -> str:
        """Serial number of the controller."""
        return self.cell.faults.serial("robot", f"SIM-{self.cell.seed}", self.cell.clock.now_s)

    def limits(self, tool_mm_s: float, turning_deg_s: float) -> SpeedLimits:
        """Return speeds under the override."""
        share = self.speed_percent / _FULL_PERCENT
        return SpeedLimits(tool_mm_s * share, math.radians(turning_deg_s) * share, joint_share=share)

    def start(self, cycle: str) -> None:
        """Start the program; raises RefusedError."""
        if self.state is not ControllerState.MOTORS_ON:
            raise RefusedError("Operation is not allowed: motors are off")
        self.cycle = self.cycle if cycle == "asis" else cycle
        self._execution = Execution.RUNNING
        self.task.start()

    def restart(self) -> None:
        """Run the program from its beginning, as somebody does at the pendant; a stop that holds ends it."""
        self._execution = Execution.RUNNING

    def stop(self) -> None:
        """Stop the program, and the arm with it."""
        self._execution = Execution.STOPPED
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

    def switch(self, state: ControllerState) -> None:
        """Switch the motors, or have a stop happen to them."""
        if state is not ControllerState.MOTORS_ON and self.runs:
            self.stop()
        self._state = state
        self._note(_INFORMATION, 10010 if state is ControllerState.MOTORS_OFF else 10011, state.value, "")

    def write(self, name: str, value: str) -> None:
        """Write a variable; raises RefusedError."""
        if name not in self.task.variables:
            raise RefusedError(f"Symbol {name} not found")
        self.task.variables[name] = value
        self.task.written(name)

    def _note(self, kind: int, code: int, title: str, description: str) -> None:
        number = self.events[-1].number + 1 if self.events else 1
        self.events = [*self.events, Event(number, kind, code, title, description)][-_MOST_EVENTS:]
