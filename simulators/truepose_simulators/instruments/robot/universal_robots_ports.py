"""The ports of a Universal Robots controller: RTDE, scripts, and the dashboard."""

import asyncio
import contextlib
import math
from collections.abc import Callable, Mapping

from truepose_drivers.universal_robots import protocol
from truepose_drivers.universal_robots.script import RobotMode, RuntimeState, SafetyMode
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.robot.universal_robots import (
    READABLE,
    SOFTWARE,
    WRITABLE,
    Controller,
    Programs,
)

_CHUNK_BYTES = 4096
_FASTEST_HZ = 125.0  # of the CB series
_OUTPUTS_NUMBER = 1
_FIRST_INPUTS_NUMBER = 1
_MOST_RECIPES = 255
_EXCEPTION = 0  # level of a text


class RtdeClient:
    """One client of RTDE."""

    def __init__(self, controller: Controller, writer: asyncio.StreamWriter) -> None:
        self._controller = controller
        self._writer = writer
        self._outputs: protocol.Recipe | None = None
        self._inputs: dict[int, protocol.Recipe] = {}
        self._period_s = 1.0 / _FASTEST_HZ
        self._streaming: asyncio.Task[None] | None = None

    def tell(self, message: str) -> None:
        """Pass on what the controller says to people."""
        self._writer.write(protocol.encode(protocol.text_message(message, "truepose simulator", _EXCEPTION)))

    def answer(self, packet: protocol.Packet) -> protocol.Packet | None:
        """Do what a packet asks and return the reply; data and texts have none."""
        match packet.kind:
            case protocol.Kind.VERSION:
                accepted = protocol.requested_version(packet.payload) == protocol.PROTOCOL_VERSION
                return protocol.verdict(protocol.Kind.VERSION, accepted=accepted)
            case protocol.Kind.CONTROLLER:
                return protocol.controller_version(SOFTWARE)
            case protocol.Kind.OUTPUTS:
                return self._set_outputs(packet.payload)
            case protocol.Kind.INPUTS:
                return self._set_inputs(protocol.words(packet.payload))
            case protocol.Kind.START | protocol.Kind.PAUSE:
                return protocol.verdict(
                    packet.kind, accepted=self._switch(on=packet.kind is protocol.Kind.START)
                )
            case protocol.Kind.DATA:
                self._take(packet.payload)
        return None

    def leave(self) -> None:
        """Stop streaming and free the inputs."""
        self._switch(on=False)
        for recipe in self._inputs.values():
            self._controller.written_by_others.difference_update(recipe.fields)

    def _set_outputs(self, payload: bytes) -> protocol.Packet:
        frequency_hz, names = protocol.requested_outputs(payload)
        if not (math.isfinite(frequency_hz) and frequency_hz > 0.0):
            raise protocol.UrProtocolError(f"{frequency_hz} Hz is not a valid frequency")
        self._period_s = 1.0 / min(frequency_hz, _FASTEST_HZ)
        types = _types(names, READABLE)
        known = protocol.NOT_FOUND not in types
        self._outputs = (
            protocol.Recipe(_OUTPUTS_NUMBER, dict(zip(names, types, strict=True))) if known else None
        )
        return protocol.recipe_reply(protocol.Kind.OUTPUTS, _OUTPUTS_NUMBER if known else 0, types)

    def _set_inputs(self, names: list[str]) -> protocol.Packet:
        taken = self._controller.written_by_others
        types = [
            protocol.IN_USE if name in taken else kind
            for name, kind in zip(names, _types(names, WRITABLE), strict=True)
        ]
        number = len(self._inputs) + _FIRST_INPUTS_NUMBER
        if {protocol.IN_USE, protocol.NOT_FOUND} & set(types) or number > _MOST_RECIPES:
            return protocol.recipe_reply(protocol.Kind.INPUTS, 0, types)
        self._inputs[number] = protocol.Recipe(number, dict(zip(names, types, strict=True)))
        taken.update(names)
        return protocol.recipe_reply(protocol.Kind.INPUTS, number, types)

    def _take(self, payload: bytes) -> None:
        recipe = self._inputs.get(payload[0] if payload else 0)
        if recipe is None:
            raise protocol.UrProtocolError("data for a recipe that was not set up")
        self._controller.registers.update(recipe.unpack(payload))

    def _switch(self, *, on: bool) -> bool:
        if self._streaming is not None:
            self._streaming.cancel()
            self._streaming = None
        if on and self._outputs is not None:
            self._streaming = asyncio.create_task(self._stream(self._outputs))
        return self._outputs is not None or not on

    async def _stream(self, recipe: protocol.Recipe) -> None:
        # A stream cannot run in cell time that stands still: its period is wall time.
        while not self._writer.is_closing():
            await asyncio.sleep(self._period_s)
            values = {name: self._controller.value(name) for name in recipe.fields}
            self._writer.write(protocol.encode(recipe.pack(values)))


def rtde_endpoint(controller: Controller) -> Endpoint:
    """Build RTDE of a controller."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        client = RtdeClient(controller, writer)
        controller.listeners.append(client.tell)
        try:
            with contextlib.suppress(protocol.UrProtocolError):  # the controller hangs up
                await _converse(client, reader, writer)
        finally:
            controller.listeners.remove(client.tell)
            client.leave()

    return Endpoint("robot", "ur_rtde", serve)


async def _converse(client: RtdeClient, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    packets = protocol.PacketReader()
    while data := await reader.read(_CHUNK_BYTES):
        packets.receive_data(data)
        while (packet := packets.next_message()) is not None:
            reply = client.answer(packet)
            if reply is not None:
                writer.write(protocol.encode(reply))
        await writer.drain()


def _types(names: list[str], known: Mapping[str, str]) -> list[str]:
    return [known.get(name, protocol.NOT_FOUND) for name in names]


_LONGEST_SCRIPT_BYTES = 65_536


def script_endpoint(programs: Programs) -> Endpoint:
    """Build the port that takes scripts; it says nothing here, where the real one sends states."""

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        pending = ""
        while (data := await reader.read(_CHUNK_BYTES)) and len(pending) < _LONGEST_SCRIPT_BYTES:
            pending += data.decode(errors="replace")
            while (end := _script_end(pending)) is not None:
                programs.start(pending[:end])
                pending = pending[end:]

    return Endpoint("robot-script", "ur_script", serve)


def _script_end(text: str) -> int | None:
    """Return where the first script ends: a definition at its own `end`, anything else with its line."""
    line_end = text.find("\n")
    if line_end < 0:
        return None
    if not text.startswith("def "):
        return line_end + 1
    end = text.find("\nend\n")
    return None if end < 0 else end + len("\nend\n")


def dashboard_endpoint(controller: Controller, programs: Programs) -> Endpoint:
    """Build the dashboard of a controller."""
    dashboard = Dashboard(controller, programs)

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.write(protocol.encode_line(protocol.GREETING))
        lines = protocol.LineReader()
        with contextlib.suppress(protocol.UrProtocolError):  # the controller hangs up
            while data := await reader.read(_CHUNK_BYTES):
                lines.receive_data(data)
                while (line := lines.next_message()) is not None:
                    writer.write(protocol.encode_line(dashboard.answer(line)))
                    if line == "quit":
                        return
                await writer.drain()

    return Endpoint("robot-dashboard", "ur_dashboard", serve)


class Dashboard:
    """What the dashboard answers."""

    def __init__(self, controller: Controller, programs: Programs) -> None:
        self._controller = controller
        self._programs = programs
        self._answers: dict[str, Callable[[], str]] = {
            protocol.SERIAL_NUMBER: lambda: controller.cell.robot_serial,
            protocol.ROBOT_MODEL: lambda: controller.cell.plant.arm.model,
            "PolyscopeVersion": lambda: "URSoftware " + ".".join(map(str, SOFTWARE)),
            "robotmode": lambda: f"Robotmode: {controller.robot_mode.name}",
            "safetymode": lambda: f"Safetymode: {controller.safety().name}",
            "running": lambda: f"Program running: {str(self._plays()).lower()}",
            "power on": lambda: self._go(RobotMode.IDLE, "Powering on"),
            "brake release": lambda: self._go(RobotMode.RUNNING, "Brake releasing"),
            "power off": lambda: self._go(RobotMode.POWER_OFF, "Powering off"),
            "unlock protective stop": self._unlock,
            "play": lambda: "Failed to execute: play",  # no program is loaded: scripts come by their own port
            "stop": self._stop,
            "quit": lambda: "Disconnected",
        }

    def answer(self, line: str) -> str:
        """Return the answer to a question or command."""
        answer = self._answers.get(line)
        return f"could not understand: '{line}'" if answer is None else answer()

    def _plays(self) -> bool:
        return self._controller.runtime_state is RuntimeState.PLAYING

    def _go(self, mode: RobotMode, said: str) -> str:
        if mode is not RobotMode.RUNNING:
            self._stop()
        self._controller.robot_mode = mode
        return said

    def _unlock(self) -> str:
        if self._controller.safety_mode is SafetyMode.PROTECTIVE_STOP:
            self._controller.safety_mode = SafetyMode.NORMAL
        return "Protective stop releasing"

    def _stop(self) -> str:
        self._programs.stop()
        self._controller.cell.halt_robot()
        return "Stopped"
