"""The two ports of text: scripts, and the dashboard."""

import asyncio
import contextlib
from collections.abc import Callable

from truepose_drivers.universal_robots.protocol.dashboard import (
    GREETING,
    ROBOT_MODEL,
    SERIAL_NUMBER,
    LineReader,
    encode_line,
)
from truepose_drivers.universal_robots.protocol.errors import UrProtocolError
from truepose_drivers.universal_robots.protocol.modes import RobotMode, RuntimeState, SafetyMode
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.robot.universal_robots.controller import SOFTWARE, Controller
from truepose_simulators.instruments.robot.universal_robots.programs import Programs

_CHUNK_BYTES = 4096
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
        writer.write(encode_line(GREETING))
        lines = LineReader()
        with contextlib.suppress(UrProtocolError):  # the controller hangs up
            while data := await reader.read(_CHUNK_BYTES):
                lines.receive_data(data)
                while (line := lines.next_message()) is not None:
                    writer.write(encode_line(dashboard.answer(line)))
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
            SERIAL_NUMBER: self._serial,
            ROBOT_MODEL: lambda: controller.cell.plant.arm.model,
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

    def _serial(self) -> str:
        cell = self._controller.cell
        return cell.faults.serial("robot", f"SIM-{cell.seed}", cell.clock.now_s)

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
