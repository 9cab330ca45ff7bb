"""A simulated cell with its service, ready to measure."""

import contextlib
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Final

from truepose.demo.cell.client import ServiceClient, connected
from truepose.demo.cell.processes import SimulatedService, running_service

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
    async with running_service(service, killed=killed) as url, connected(url) as client:
        await client.connect_devices()
        yield client
