"""What the controller says of itself: motors, key switch, program, speed override."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Final, TypeVar

from truepose_drivers.abb_rws.protocol.errors import RwsProtocolError
from truepose_drivers.abb_rws.protocol.http import HttpResponse
from truepose_drivers.abb_rws.protocol.rapid import number
from truepose_drivers.abb_rws.protocol.resources import state, text

_FULL_PERCENT: Final = 100.0

Known = TypeVar("Known", bound=StrEnum)


class ControllerState(StrEnum):
    """Motors and stops."""

    INIT = "init"
    MOTORS_ON = "motoron"
    MOTORS_OFF = "motoroff"
    GUARD_STOP = "guardstop"
    EMERGENCY_STOP = "emergencystop"
    EMERGENCY_STOP_RESET = "emergencystopreset"
    SYSTEM_FAILURE = "sysfail"


class OperationMode(StrEnum):
    """Position of the key switch."""

    INIT = "INIT"
    AUTO_CHANGE = "AUTO_CH"
    MANUAL_FULL_CHANGE = "MANF_CH"
    MANUAL_REDUCED = "MANR"
    MANUAL_FULL = "MANF"
    AUTO = "AUTO"
    UNDEFINED = "UNDEF"


class Execution(StrEnum):
    """Whether the RAPID program runs."""

    RUNNING = "running"
    STOPPED = "stopped"


@dataclass(frozen=True, slots=True)
class Panel:
    """All of it at one time."""

    state: ControllerState
    mode: OperationMode
    execution: Execution
    speed_percent: float

    @property
    def obstacle(self) -> str | None:
        """Why the arm may not be moved from here, with what to do; None where it may."""
        if self.halt is None and self.mode is not OperationMode.AUTO:
            return f"its key switch is at {self.mode.value}: switch it to AUTO and confirm on the pendant"
        return self.halt

    @property
    def halt(self) -> str | None:
        """Why nothing moves the arm now, with what to do; None where something may."""
        if self.state is not ControllerState.MOTORS_ON:
            return _WHY[self.state]
        return "its speed override is 0 %: raise it on the pendant" if self.speed_percent <= 0.0 else None


_WHY: Final = {
    ControllerState.INIT: "it is starting: wait until the pendant shows that it is ready",
    ControllerState.MOTORS_OFF: "its motors are off: look at the cell, then switch them on at the controller",
    ControllerState.GUARD_STOP: "a guard stopped it: close the guard, then switch the motors on",
    ControllerState.EMERGENCY_STOP: "an emergency stop holds it: look at the cell, then release the stop",
    ControllerState.EMERGENCY_STOP_RESET: "an emergency stop was released: switch the motors on",
    ControllerState.SYSTEM_FAILURE: "it has failed: look at the event log on the pendant",
}


def controller_state(response: HttpResponse) -> ControllerState:
    """Read the state of the motors; raises RwsProtocolError."""
    return _one_of(ControllerState, text(state(response, "pnl-ctrlstate"), "ctrlstate"))


def operation_mode(response: HttpResponse) -> OperationMode:
    """Read the key switch; raises RwsProtocolError."""
    return _one_of(OperationMode, text(state(response, "pnl-opmode"), "opmode"))


def execution(response: HttpResponse) -> Execution:
    """Read whether the program runs; raises RwsProtocolError."""
    return _one_of(Execution, text(state(response, "rap-execution"), "ctrlexecstate"))


def speed_percent(response: HttpResponse) -> float:
    """Read the speed override; raises RwsProtocolError."""
    percent = number(state(response, "pnl-speedratio").get("speedratio"))
    if not 0.0 <= percent <= _FULL_PERCENT:
        raise RwsProtocolError(f"the robot states a speed override of {percent:g} %: connect again")
    return percent


def _one_of(kind: type[Known], word: str) -> Known:
    try:
        return kind(word)
    except ValueError as error:
        raise RwsProtocolError(f"the robot states {word[:40]!r}, which is no {kind.__name__}") from error
