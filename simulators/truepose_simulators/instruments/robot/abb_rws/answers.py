"""What each resource answers, as states or as what it does."""

import math
from collections.abc import Callable, Mapping

import numpy as np

from truepose_drivers.abb_rws.protocol import resources
from truepose_drivers.abb_rws.protocol.http import HttpRequest
from truepose_drivers.abb_rws.protocol.panel import ControllerState
from truepose_drivers.abb_rws.protocol.rapid import NO_AXIS, number, number_text
from truepose_drivers.abb_rws.protocol.resources import State
from truepose_simulators.cell.robot import nominal_flange
from truepose_simulators.instruments.robot.abb_rws.controller import (
    ROBOTWARE,
    AbbController,
    Event,
    RefusedError,
)
from truepose_simulators.physics.rigid import to_quaternion

_SIGNALS = "/rw/iosystem/signals/"
_TASK = f"{resources.TASKS}/T_ROB1"
_EXTERNAL_AXES = "abcdef"
_STAMP = "2026-01-01 T  00:00:00"
_GRANTED = {"_type": "user-rmmp-poll", "status": "GRANTED"}


class NotFoundError(RefusedError):
    """There is no such resource."""


class Answers:
    """The resources of one controller."""

    def __init__(self, controller: AbbController) -> None:
        self._controller = controller
        self._tell: Mapping[str, Callable[[], list[State]]] = {
            resources.IDENTITY: self._identity,
            resources.SYSTEM: lambda: [_state("sys-system-li", rwversion=ROBOTWARE, name="Simulated")],
            resources.ROBOT_TYPE: lambda: [
                _state("sys-robottype", **{"robot-type": controller.cell.plant.arm.model})
            ],
            resources.CONTROLLER_STATE: lambda: [_state("pnl-ctrlstate", ctrlstate=controller.state.value)],
            resources.OPERATION_MODE: lambda: [_state("pnl-opmode", opmode=controller.mode.value)],
            resources.SPEED_RATIO: lambda: [
                _state("pnl-speedratio", speedratio=number_text(controller.speed_percent))
            ],
            resources.EXECUTION: self._execution,
            resources.TASKS: self._tasks,
            resources.JOINT_TARGET: self._joint_target,
            resources.ROBOT_TARGET: self._robot_target,
            resources.EVENT_LOG: lambda: [_entry(event) for event in controller.events],
            "/ctrl/$RAMDISK": lambda: [{"_type": "ctrl-env", "_value": "/RAMDISK"}],
            "/users/rmmp/poll": lambda: [_GRANTED],
            resources.LOGOUT: lambda: [],
        }
        self._do: Mapping[tuple[str, str], Callable[[dict[str, str]], None]] = {
            (resources.CONTROLLER_STATE, "setctrlstate"): self._switch,
            (resources.SPEED_RATIO, "setspeedratio"): self._set_speed,
            (resources.EXECUTION, "start"): lambda form: controller.start(form.get("cycle", "asis")),
            (resources.EXECUTION, "stop"): lambda form: controller.stop(),
            (resources.EXECUTION, "resetpp"): lambda form: controller.reset_pointer(),
            (_TASK, "activate"): lambda form: None,
            (_TASK, "deactivate"): lambda form: None,
            ("/users/rmmp", ""): lambda form: None,
        }

    def told(self, path: str) -> list[State]:
        """Return the states of a resource; raises NotFoundError."""
        if path.startswith(resources.SYMBOL_DATA):
            return [self._variable(path.removeprefix(resources.SYMBOL_DATA))]
        if path.startswith(_SIGNALS):
            value = self._controller.signals.get(path, "0")
            return [_state("ios-signal", name=path.rpartition("/")[2], lvalue=value)]
        if path not in self._tell:
            raise NotFoundError(f"{path} is no resource here")
        return self._tell[path]()

    def done(self, request: HttpRequest) -> list[State] | None:
        """Do what a request asks, and return what is told of it; raises RefusedError, RwsProtocolError."""
        path, action = request.path, request.query.get("action", "")
        if (path, action) == (resources.SYMBOLS, "search-symbols"):
            return [self._symbol(name) for name in self._controller.task.variables]
        if path.startswith(resources.SYMBOL_DATA) and action == "set":
            self._controller.write(path.removeprefix(resources.SYMBOL_DATA), request.form.get("value", ""))
        elif path.startswith(_SIGNALS) and action == "set":
            self._controller.signals[path] = request.form.get("lvalue", "0")
        elif (path, action) in self._do:
            self._do[path, action](request.form)
        else:
            raise NotFoundError(f"{path} knows no action {action!r}")
        return None

    def _identity(self) -> list[State]:
        own = {
            "ctrl-id": self._controller.serial,
            "ctrl-name": "simulated",
            "ctrl-type": "Virtual Controller",
        }
        return [_state("ctrl-identity-info", **own)]

    def _execution(self) -> list[State]:
        controller = self._controller
        return [_state("rap-execution", ctrlexecstate=controller.execution.value, cycle=controller.cycle)]

    def _tasks(self) -> list[State]:
        runs = "started" if self._controller.runs else "stopped"
        task = {"name": "T_ROB1", "type": "norm", "taskstate": "linked", "excstate": runs}
        return [_state("rap-task-li", active="On", motiontask="TRUE", **task)]

    def _joints_deg(self) -> list[float]:
        cell = self._controller.cell
        joints_deg: list[float] = np.degrees(cell.robot.motion.joints_at(cell.clock.now_s)).tolist()
        return joints_deg

    def _joint_target(self) -> list[State]:
        robot = {
            f"rax_{joint}": number_text(angle) for joint, angle in enumerate(self._joints_deg(), start=1)
        }
        external = {f"eax_{axis}": number_text(NO_AXIS) for axis in _EXTERNAL_AXES}
        return [_state("ms-jointtarget", **robot, **external)]

    def _robot_target(self) -> list[State]:
        """Return the pose of the flange: tool0 in wobj0, whatever was asked for."""
        joints = np.radians(self._joints_deg())
        frame = nominal_flange(self._controller.cell.plant.arm, joints[np.newaxis])[0]
        place = zip("xyz", frame[:3, 3].tolist(), strict=True)
        turn = zip(("q1", "q2", "q3", "q4"), to_quaternion(frame[:3, :3]).tolist(), strict=True)
        quarters = {f"cf{joint}": str(math.floor(joints[joint - 1] / (math.pi / 2))) for joint in (1, 4, 6)}
        numbers = {name: number_text(value) for name, value in (*place, *turn)}
        external = {f"eax{axis}": number_text(NO_AXIS) for axis in _EXTERNAL_AXES}
        return [_state("ms-robtargets", **numbers, **quarters, cfx="0", **external)]

    def _variable(self, name: str) -> State:
        variables = self._controller.task.variables
        if name not in variables:
            raise NotFoundError(f"Symbol {name} not found")
        return _state("rap-data", value=variables[name])

    def _symbol(self, name: str) -> State:
        return _state("rap-sympropper-li", symburl=f"RAPID/T_ROB1/{name}", name=name, symtyp="per")

    def _switch(self, form: dict[str, str]) -> None:
        wanted = form.get("ctrl-state")
        if wanted not in {"motoron", "motoroff"}:
            raise RefusedError(f"{wanted} is no state that can be set")
        if self._controller.state not in {ControllerState.MOTORS_ON, ControllerState.MOTORS_OFF}:
            raise RefusedError(f"Operation is not allowed in {self._controller.state.value}")
        self._controller.switch(ControllerState(wanted))

    def _set_speed(self, form: dict[str, str]) -> None:
        percent = number(form.get("speed-ratio"))
        if not 0.0 <= percent <= 100.0:
            raise RefusedError(f"{percent:g} % is no speed ratio")
        self._controller.speed_percent = percent


def _state(kind: str, **told: str) -> State:
    return {"_type": kind, **told}


def _entry(event: Event) -> State:
    told = {"msgtype": str(event.kind), "code": str(event.code), "tstamp": _STAMP, "argc": "0"}
    told |= {"title": event.title, "desc": event.description, "conseqs": "", "causes": "", "actions": ""}
    return {"_type": "elog-message-li", "_title": f"/rw/elog/0/{event.number}", **told}
