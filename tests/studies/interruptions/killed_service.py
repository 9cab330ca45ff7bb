"""A service that is killed and started again, on a simulated cell that stays as it stood.

The cell is a process of its own, as a real one would be: the arm, the cups and the ballbar are where they
were when the service comes back. Its endpoints stand in a cell file, like those of real instruments.
"""

import asyncio
import contextlib
import json
import os
import signal
import sys
import time
from collections.abc import AsyncIterator, Mapping
from pathlib import Path
from typing import Final

import httpx

from tests.helpers.ports import free_port
from truepose.demo.errors import ServiceFailedError

_START_S: Final = 90.0  # two seconds on an idle machine
_ASK_S: Final = 0.02
_DRIVERS: Final[Mapping[str, str]] = {
    "open_abb": "abb_open_abb",
    "nd28x": "heidenhain_nd",
    "hands": "cell_hands",
    "clock": "cell_clock",
}
_ROBOTS: Final[Mapping[str, str]] = {"irb120": "abb-irb-120", "lrmate": "fanuc-lr-mate-200ic"}


@contextlib.asynccontextmanager
async def standing_cell(scenario: str, seed: int, pace: int, log: Path) -> AsyncIterator[str]:
    """Start a simulated cell, yield the text of its cell file, and end it with the context."""
    arguments = (scenario, "--seed", str(seed), "--pace", str(pace))
    with log.open("wb") as errors:
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "truepose_simulators", *arguments),
            stdout=asyncio.subprocess.PIPE,
            stderr=errors,
            start_new_session=True,
        )
    try:
        yield await _cell_file(process, scenario, log)
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()


async def _cell_file(process: asyncio.subprocess.Process, scenario: str, log: Path) -> str:
    robot = next(name for prefix, name in _ROBOTS.items() if scenario.startswith(prefix))
    lines = [f'robot = "{robot}"', "[ballbar]", "base_points = 3"]
    device = ""
    while device != "hands":
        line = await process.stdout.readline() if process.stdout is not None else b""
        if not line:
            raise ServiceFailedError(f"The simulated cell ended before it was ready; see {log}.")
        told = json.loads(line)
        device = told["device"]
        driver = _DRIVERS.get(told["protocol"])
        if driver is not None:
            lines += ["[[device]]", f'name = "{device}"', f'driver = "{driver}"']
            lines += [f'host = "{told["host"]}"', f"port = {told['port']}"]
    return "\n".join(lines) + "\n"


class KilledService:
    """The service as `truepose serve` starts it, always at the same port."""

    def __init__(self, cell_file: Path, database: Path | str, log: Path) -> None:
        self._cell_file = cell_file
        self._url = database if isinstance(database, str) else f"sqlite:///{database}"
        self._log = log
        self._port = free_port()
        self._process: asyncio.subprocess.Process | None = None

    @property
    def url(self) -> str:
        """Where it listens."""
        return f"http://127.0.0.1:{self._port}"

    @property
    def pid(self) -> int:
        """Of the process that runs; raises ServiceFailedError where none does."""
        if self._process is None or self._process.returncode is not None:
            raise ServiceFailedError(f"The service does not run; see {self._log}.")
        return self._process.pid

    async def start(self) -> float:
        """Start it and return after how many seconds of wall time it answered; raises ServiceFailedError."""
        began = time.monotonic()
        with self._log.open("ab") as log:
            self._process = await asyncio.create_subprocess_exec(
                *(sys.executable, "-m", "truepose", "serve", "--port", str(self._port)),
                *("--cell", str(self._cell_file), "--database", self._url),
                stdout=asyncio.subprocess.DEVNULL,
                stderr=log,
                start_new_session=True,
            )
        async with httpx.AsyncClient(base_url=self.url, trust_env=False) as http:
            while not await _answers(http):
                if self._process.returncode is not None or time.monotonic() - began > _START_S:
                    raise ServiceFailedError(f"The service did not start; see {self._log}.")
                await asyncio.sleep(_ASK_S)
        return time.monotonic() - began

    async def kill(self) -> None:
        """End it as a power cut would: nothing is finished, nothing is closed."""
        if self._process is None:
            return
        with contextlib.suppress(ProcessLookupError):
            # Its whole group: a worker that computes for it goes with the machine.
            os.killpg(self._process.pid, signal.SIGKILL)
        await self._process.wait()


async def _answers(http: httpx.AsyncClient) -> bool:
    try:
        return (await http.get("/health")).is_success
    except httpx.TransportError:
        return False


@contextlib.asynccontextmanager
async def standing_service(scenario: str, seed: int, folder: Path) -> AsyncIterator[httpx.AsyncClient]:
    """Start a simulated cell at full speed and its service in `folder`; yield a client of the service."""
    async with standing_cell(scenario, seed, 0, folder / "cell.log") as cell_file:
        (folder / "cell.toml").write_text(cell_file, encoding="utf-8")
        service = KilledService(folder / "cell.toml", folder / "sessions.sqlite3", folder / "service.log")
        await service.start()
        async with httpx.AsyncClient(base_url=service.url, timeout=200.0, trust_env=False) as client:
            yield client
        await service.kill()
