"""What each resource answers, and the subscriptions by which a WebSocket is told its changes.

RFC 6455, as far as a server needs it that speaks short texts and listens for the end only.
"""

import asyncio
import base64
import hashlib
import math
from collections.abc import Callable, Mapping
from typing import Final

import numpy as np

from truepose_drivers.abb_rws import protocol
from truepose_drivers.abb_rws.http import HttpRequest, HttpResponse
from truepose_drivers.abb_rws.protocol import NO_AXIS, ControllerState, State, number, number_text
from truepose_simulators.cell.robot import nominal_flange
from truepose_simulators.instruments.endpoint import Writer
from truepose_simulators.instruments.robot.abb_rws.controller import (
    ROBOTWARE,
    AbbController,
    Event,
    RefusedError,
)
from truepose_simulators.physics.rigid import to_quaternion

_SIGNALS = "/rw/iosystem/signals/"
_TASK = f"{protocol.TASKS}/T_ROB1"
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
            protocol.IDENTITY: self._identity,
            protocol.SYSTEM: lambda: [_state("sys-system-li", rwversion=ROBOTWARE, name="Simulated")],
            protocol.ROBOT_TYPE: lambda: [
                _state("sys-robottype", **{"robot-type": controller.cell.plant.arm.model})
            ],
            protocol.CONTROLLER_STATE: lambda: [_state("pnl-ctrlstate", ctrlstate=controller.state.value)],
            protocol.OPERATION_MODE: lambda: [_state("pnl-opmode", opmode=controller.mode.value)],
            protocol.SPEED_RATIO: lambda: [
                _state("pnl-speedratio", speedratio=number_text(controller.speed_percent))
            ],
            protocol.EXECUTION: self._execution,
            protocol.TASKS: self._tasks,
            protocol.JOINT_TARGET: self._joint_target,
            protocol.ROBOT_TARGET: self._robot_target,
            protocol.EVENT_LOG: lambda: [_entry(event) for event in controller.events],
            "/ctrl/$RAMDISK": lambda: [{"_type": "ctrl-env", "_value": "/RAMDISK"}],
            "/users/rmmp/poll": lambda: [_GRANTED],
            protocol.LOGOUT: lambda: [],
        }
        self._do: Mapping[tuple[str, str], Callable[[dict[str, str]], None]] = {
            (protocol.CONTROLLER_STATE, "setctrlstate"): self._switch,
            (protocol.SPEED_RATIO, "setspeedratio"): self._set_speed,
            (protocol.EXECUTION, "start"): lambda form: controller.start(form.get("cycle", "asis")),
            (protocol.EXECUTION, "stop"): lambda form: controller.stop(),
            (protocol.EXECUTION, "resetpp"): lambda form: controller.reset_pointer(),
            (_TASK, "activate"): lambda form: None,
            (_TASK, "deactivate"): lambda form: None,
            ("/users/rmmp", ""): lambda form: None,
        }

    def told(self, path: str) -> list[State]:
        """Return the states of a resource; raises NotFoundError."""
        if path.startswith(protocol.SYMBOL_DATA):
            return [self._variable(path.removeprefix(protocol.SYMBOL_DATA))]
        if path.startswith(_SIGNALS):
            value = self._controller.signals.get(path, "0")
            return [_state("ios-signal", name=path.rpartition("/")[2], lvalue=value)]
        if path not in self._tell:
            raise NotFoundError(f"{path} is not a resource here")
        return self._tell[path]()

    def done(self, request: HttpRequest) -> list[State] | None:
        """Do what a request asks, and return what is told of it; raises RefusedError, RwsProtocolError."""
        path, action = request.path, request.query.get("action", "")
        if (path, action) == (protocol.SYMBOLS, "search-symbols"):
            return [self._symbol(name) for name in self._controller.task.variables]
        if path.startswith(protocol.SYMBOL_DATA) and action == "set":
            self._controller.write(path.removeprefix(protocol.SYMBOL_DATA), request.form.get("value", ""))
        elif path.startswith(_SIGNALS) and action == "set":
            self._controller.signals[path] = request.form.get("lvalue", "0")
        elif (path, action) in self._do:
            self._do[path, action](request.form)
        else:
            raise NotFoundError(f"{path} has no action {action!r}")
        return None

    def _identity(self) -> list[State]:
        own = {
            "ctrl-id": self._controller.cell.robot_serial,
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
        joints_deg: list[float] = np.degrees(self._controller.cell.joints_rad).tolist()
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
            raise RefusedError(f"{wanted} is not a state that can be set")
        if self._controller.state not in {ControllerState.MOTORS_ON, ControllerState.MOTORS_OFF}:
            raise RefusedError(f"Operation is not allowed in {self._controller.state.value}")
        self._controller.switch(ControllerState(wanted))

    def _set_speed(self, form: dict[str, str]) -> None:
        percent = number(form.get("speed-ratio"))
        if not 0.0 <= percent <= 100.0:
            raise RefusedError(f"{percent:g} % is not a valid speed ratio")
        self._controller.speed_percent = percent


def _state(kind: str, **told: str) -> State:
    return {"_type": kind, **told}


def _entry(event: Event) -> State:
    told = {"msgtype": str(event.kind), "code": str(event.code), "tstamp": _STAMP, "argc": "0"}
    told |= {"title": event.title, "desc": event.description, "conseqs": "", "causes": "", "actions": ""}
    return {"_type": "elog-message-li", "_title": f"/rw/elog/0/{event.number}", **told}


POLL: Final = "/poll/"
_SUB_PROTOCOL: Final = "robapi2_subscription"
_GUID: Final = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
_LOOK_S: Final = 0.05  # wall time: who listens knows no other
_TEXT_FRAME, _SHORT, _LENGTH_16, _LENGTH_64 = 0x81, 125, 126, 127
_CHUNK_BYTES: Final = 4096

# Of a subscribed path: class of its events, and of the value in them.
_CLASSES: Final[Mapping[str, tuple[str, str]]] = {
    protocol.CONTROLLER_STATE: ("pnl-ctrlstate-ev", "ctrlstate"),
    protocol.OPERATION_MODE: ("pnl-opmode-ev", "opmode"),
    protocol.EXECUTION: ("rap-ctrlexecstate-ev", "ctrlexecstate"),
    protocol.SYMBOL_DATA: ("rap-data", "value"),
    "/rw/iosystem/signals/": ("ios-signalstate-ev", "lvalue"),
}


class Subscriptions:
    """All subscriptions of one controller's clients."""

    def __init__(self, answers: Answers) -> None:
        self._answers = answers
        self._resources: dict[str, list[str]] = {}  # by the path at which they are told

    def add(self, request: HttpRequest) -> HttpResponse:
        """Note what a client wants to be told; raises NotFoundError, RwsProtocolError."""
        wanted = [value for name, value in request.form.items() if name.isdigit()]
        for resource in wanted:
            self._value(resource)
        path = f"{POLL}{len(self._resources) + 1}"
        self._resources[path] = wanted
        at = f"ws://{request.headers.get('host', 'localhost')}{path}"  # HTTP 1.0 names none
        headers = (("location", at), ("content-type", "application/xhtml+xml"))
        return HttpResponse(201, headers, f'<a href="{at}" rel="self"></a>'.encode())

    def handshake(self, request: HttpRequest) -> HttpResponse:
        """Return the answer to a client that comes to listen; raises NotFoundError."""
        key = request.headers.get("sec-websocket-key")
        if key is None:
            raise NotFoundError("only WebSocket connections are accepted here")
        if request.path not in self._resources:
            raise NotFoundError(f"nothing was subscribed at {request.path}")
        digest = hashlib.sha1((key + _GUID).encode(), usedforsecurity=False).digest()
        headers = {
            "upgrade": "websocket",
            "connection": "Upgrade",
            "sec-websocket-accept": base64.b64encode(digest).decode(),
            "sec-websocket-protocol": _SUB_PROTOCOL,
        }
        return HttpResponse(101, tuple(headers.items()))

    async def tell(self, path: str, reader: asyncio.StreamReader, writer: Writer) -> None:
        """Tell every change of what was subscribed until the client says or does that it goes."""
        wanted = self._resources[path]
        told = {resource: self._value(resource) for resource in wanted}
        leaving = asyncio.ensure_future(reader.read(_CHUNK_BYTES))
        try:
            while not leaving.done():
                for resource in wanted:
                    value = self._value(resource)
                    if value != told[resource]:
                        told[resource] = value
                        writer.write(text_frame(_event(resource, value)))
                await writer.drain()
                await asyncio.wait({leaving}, timeout=_LOOK_S)
            await leaving
        finally:
            leaving.cancel()

    def _value(self, resource: str) -> str:
        path = resource.partition(";")[0]
        name = _classes(path)[1]
        return str(self._answers.told(path)[0].get(name, ""))


def switching(response: HttpResponse) -> bytes:
    """Return the bytes by which HTTP ends on a connection and WebSocket begins."""
    lines = ["HTTP/1.1 101 Switching Protocols", *(f"{name}: {value}" for name, value in response.headers)]
    return "\r\n".join([*lines, "", ""]).encode()


def text_frame(text: str) -> bytes:
    """Return a whole text of a server."""
    data = text.encode()
    if len(data) <= _SHORT:
        return bytes([_TEXT_FRAME, len(data)]) + data
    if len(data) < 1 << 16:
        return bytes([_TEXT_FRAME, _LENGTH_16]) + len(data).to_bytes(2, "big") + data
    return bytes([_TEXT_FRAME, _LENGTH_64]) + len(data).to_bytes(8, "big") + data


def _event(resource: str, value: str) -> str:
    event, name = _classes(resource.partition(";")[0])
    link = f'<a href="{resource}" rel="self"></a>'
    return f'<li class="{event}" title="{name}">{link}<span class="{name}">{value}</span></li>'


def _classes(path: str) -> tuple[str, str]:
    found = next((classes for begin, classes in _CLASSES.items() if path.startswith(begin)), None)
    if found is None:
        raise NotFoundError(f"{path} cannot be subscribed to")
    return found
