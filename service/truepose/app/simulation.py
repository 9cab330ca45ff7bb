"""The simulated cell as a process of its own: started, listened to, ended with the service.

It is a program that speaks the instruments' protocols; the service reaches it through its drivers like
any cell, and shares no line of code with it. It is never started anew: a cell that vanished under a
session is for a person to look at, simulated or not.
"""

import asyncio
import contextlib
import json
import sys
import tempfile
from collections.abc import AsyncIterator, Mapping, Set
from pathlib import Path
from typing import Any, Final

from truepose.app.errors import ScenarioRefusedError, SimulationFailedError
from truepose.domain.cell import SimulatedCell
from truepose.exchange.cells.file import scenario_text
from truepose.processes import in_own_group
from truepose.web.context import Endpoint
from truepose_drivers.errors import ConnectionLostError

_NEEDED: Final = {"tracker", "robot", "clock", "truth", "ballbar", "hands", "faults"}
_ARTEFACT: Final = b"the simulated artefact"
# Runs the simulators' process, and ends it when its input closes: then the service is gone, however it ended.
_TIED: Final = """
import os, runpy, sys, threading
threading.Thread(target=lambda: (os.read(0, 1), os._exit(1)), daemon=True).start()
runpy.run_module("truepose_simulators", run_name="__main__", alter_sys=True)
"""
_START_S: Final = 30.0  # a second on an idle machine
_ANSWER_S: Final = 10.0  # of a question about faults; a thousandth of it on an idle machine
_END_S: Final = 5.0
_UNUSABLE_INPUT: Final = 2  # exit status of a cell that refuses its scenario


class Simulation:
    """A running simulated cell and where its instruments listen."""

    def __init__(
        self, process: asyncio.subprocess.Process, endpoints: tuple[Endpoint, ...], tool_file: Path
    ) -> None:
        self._process = process
        self.endpoints = endpoints
        self.tool_file = tool_file  # for the camera, which takes any definition for the artefact's

    @property
    def fault(self) -> str | None:
        """Why it does not run any more; None while it does."""
        status = self._process.returncode
        if status is None:
            return None
        return f"The simulated cell has ended with status {status}; restart the service."

    async def ask_of_faults(self, request: Mapping[str, object]) -> dict[str, Any]:
        """Put a question to the endpoint of the cell's faults; raises ConnectionLostError."""
        at = next(endpoint for endpoint in self.endpoints if endpoint.device == "faults")
        try:
            async with asyncio.timeout(_ANSWER_S):
                reader, writer = await asyncio.open_connection(at.host, at.port)
                with contextlib.closing(writer):
                    writer.write(json.dumps(dict(request)).encode() + b"\n")
                    answer: dict[str, Any] = json.loads(await reader.readline())
        except (OSError, TimeoutError, ValueError) as error:
            raise ConnectionLostError("The simulated cell does not answer; see the start page.") from error
        return answer


@contextlib.asynccontextmanager
async def running_simulation(
    simulated: SimulatedCell,
    pace: int,
    state: Path | None = None,
    faults: Path | None = None,
    *,
    with_camera: bool = False,
) -> AsyncIterator[Simulation]:
    """Start a simulated cell and end it with the context; raises SimulationFailedError.

    With a file for its state it stands where it stood when it last ended, however that was: a real cell
    does not put its robot and its fixtures back when a computer is started anew.
    """
    with tempfile.TemporaryDirectory(prefix="truepose-") as folder:
        scenario = _with_effects(simulated, Path(folder))
        tool_file = Path(folder) / "artefact.rom"
        tool_file.write_bytes(_ARTEFACT)
        needed = _NEEDED | {"camera"} if with_camera else _NEEDED
        arguments = [scenario, "--seed", str(simulated.seed), "--pace", str(pace)]
        if state is not None:
            arguments += ["--state", str(state)]
        if faults is not None:
            arguments += ["--faults", str(faults)]
        pipe = asyncio.subprocess.PIPE
        # A group of its own: ctrl-C at the terminal is for the service, which ends the cell in order.
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-c", _TIED, *arguments, stdin=pipe, stdout=pipe, **in_own_group()
        )
        try:
            yield Simulation(process, await _endpoints(process, needed), tool_file)
        finally:
            await _end(process)


async def _endpoints(process: asyncio.subprocess.Process, needed: Set[str]) -> tuple[Endpoint, ...]:
    found: list[Endpoint] = []
    try:
        async with asyncio.timeout(_START_S):
            while not {endpoint.device for endpoint in found} >= needed:
                line = await process.stdout.readline() if process.stdout is not None else b""
                if not line:
                    status = await process.wait()
                    if status == _UNUSABLE_INPUT:
                        raise ScenarioRefusedError(
                            "The simulated cell cannot be set up as requested; see above."
                        )
                    raise SimulationFailedError(
                        f"The simulated cell ended with status {status} before it was ready; see above."
                    )
                found.append(Endpoint(**json.loads(line)))
    except TimeoutError as error:
        raise SimulationFailedError(f"The simulated cell was not ready after {_START_S:g} s.") from error
    return tuple(found)


async def _end(process: asyncio.subprocess.Process) -> None:
    if process.returncode is None:
        process.terminate()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(process.wait(), _END_S)
    if process.returncode is None:
        process.kill()
    await process.wait()  # also one that has ended by itself: its pipes are closed then


def _with_effects(simulated: SimulatedCell, folder: Path) -> str:
    """Return the scenario to run: as named, or a file that extends it by the planted changes."""
    named = Path(simulated.scenario)
    scenario = str(named.resolve()) if named.suffix == ".toml" else simulated.scenario
    if not simulated.effects:
        return scenario
    effects = (
        {
            "name": effect.name,
            "subject": effect.subject,
            "amplitude": effect.amplitude,
            "from_s": effect.from_s,
            **effect.details,
        }
        for effect in simulated.effects
    )
    file = folder / f"{named.stem}.toml"
    file.write_text(scenario_text(scenario, "effect", effects), encoding="utf-8")
    return str(file)
