"""The service, and with it the simulated cell, as child processes: started, listened to, ended.

The service starts the cell and ends it again; here is only the service's side. Its standard output holds
the one JSON line that says where it listens; everything it logs goes to a file. Its standard input is a
pipe: closed, it asks the service to end, and so a run that is killed takes its children with it.
"""

import asyncio
import contextlib
import json
import sys
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from truepose.demo.client import ServiceClient, open_client
from truepose.demo.errors import ServiceFailedError, UnusableScenarioError
from truepose.processes import in_own_group, kill_group

_START_S: Final = 60.0  # three seconds on an idle machine
_END_S: Final = 15.0  # it gives requests under way 5 s and its cell 5 s
_UNUSABLE_INPUT: Final = 2
_COMMAND: Final = ("-m", "truepose.demo.service")


@dataclass(frozen=True, slots=True)
class SimulatedService:
    """A service on a simulated cell: which cell, where it stores, and where it logs."""

    scenario: str  # shipped name or file
    seed: int
    database: Path
    log: Path


@contextlib.asynccontextmanager
async def running_service(service: SimulatedService, *, killed: bool = False) -> AsyncIterator[str]:
    """Start the service, yield its URL, and end it and its cell with the context.

    It is ended in order; `killed` ends it as a power cut would.

    Raises
    ------
    UnusableScenarioError
        It refuses the scenario.
    ServiceFailedError
        It does not start: the database is in use, a port is taken, the simulated cell did not come up.
    """
    url = f"sqlite:///{service.database.resolve()}"
    with service.log.open("wb") as log:
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, *_COMMAND, service.scenario, str(service.seed), url),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=log,
            **in_own_group(),  # ctrl-C at the terminal is for the run, which ends the service in order
        )
    try:
        yield await _address(process, service.log)
    finally:
        if not killed:
            await _end(process)
        kill_group(process)
        await process.wait()


async def _address(process: asyncio.subprocess.Process, log: Path) -> str:
    if process.stdout is None:
        raise ServiceFailedError("The service has no standard output.")
    try:
        line = await asyncio.wait_for(process.stdout.readline(), _START_S)
    except TimeoutError as error:
        raise ServiceFailedError(f"The service was not ready after {_START_S:g} s; see {log}.") from error
    if line:
        return str(json.loads(line)["url"])
    status = await process.wait()
    said = _last_words(log) or f"The service ended with status {status} before it was ready; see {log}."
    raise UnusableScenarioError(said) if status == _UNUSABLE_INPUT else ServiceFailedError(said)


def _last_words(log: Path) -> str:
    """Return what a service that did not start wrote, but for the lines of its log."""
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    return "\n".join(line for line in lines if not line.startswith(("INFO", "WARNING", "DEBUG")))


async def _end(process: asyncio.subprocess.Process) -> None:
    if process.stdin is not None:
        process.stdin.close()
    with contextlib.suppress(TimeoutError):
        await asyncio.wait_for(process.wait(), _END_S)


DATABASE: Final = "sessions.sqlite3"
SERVICE_LOG: Final = "service.log"


@contextlib.asynccontextmanager
async def opened_cell(
    scenario: str, seed: int, folder: Path, *, killed: bool = False
) -> AsyncIterator[ServiceClient]:
    """Start cell and service on the database of `folder`; yields a client whose devices are connected.

    `scenario` is a shipped name or a file; `killed` as of `running_service`. Raises DemoError.
    """
    service = SimulatedService(scenario, seed, folder / DATABASE, folder / SERVICE_LOG)
    async with running_service(service, killed=killed) as url, open_client(url) as client:
        await client.connect_devices()
        yield client
