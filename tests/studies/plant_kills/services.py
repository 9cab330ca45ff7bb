"""Services as `truepose serve` and `truepose plant` run them, killed and started again at the same port.

Each is a process of its own, forked from one that has their modules loaded: to load them takes longer than
all that follows, and is the same whether somebody was killed or not.
"""

import asyncio
import contextlib
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable
from multiprocessing.context import ForkServerProcess
from pathlib import Path
from typing import Final

import httpx

from tests.helpers.ports import free_port
from truepose.demo.errors import ServiceFailedError
from truepose.settings import PlantSettings, Settings

_FORKED: Final = multiprocessing.get_context("forkserver")
_FORKED.set_forkserver_preload(["truepose.app.plants", "truepose.app.server", "psycopg", __name__])
_VISITS_S: Final = 0.1
_ASK_S: Final = 0.05
_PATIENCE_S: Final = 300.0
_RESTART_S: Final = 1.0  # from one start to the next, where one has ended by itself
_UNUSABLE_INPUT: Final = 2  # status of a service; 3 where the database server is away, which passes


class KilledService:
    """One service; `serve` is given its port in the process that becomes it."""

    def __init__(self, name: str, serve: Callable[[int], int], log: Path) -> None:
        self.name, self._serve, self._log = name, serve, log
        self._port = free_port()
        self._process: ForkServerProcess | None = None
        self._began_s = -_RESTART_S

    @property
    def url(self) -> str:
        """Where it listens."""
        return f"http://127.0.0.1:{self._port}"

    def start(self) -> None:
        """Start it; it may be killed before it is ready."""
        self._process = _FORKED.Process(target=_become, args=(self._serve, self._port, str(self._log)))
        self._process.start()
        self._began_s = time.monotonic()

    async def up(self) -> float:
        """Return once it answers and after how long, started again where it has ended by itself.

        Raises ServiceFailedError.
        """
        began_s = time.monotonic()
        async with httpx.AsyncClient(base_url=self.url, trust_env=False) as http:
            while not await _answers(http):
                if time.monotonic() - began_s > _PATIENCE_S:
                    raise ServiceFailedError(f"{self.name} did not start; see {self._log}.")
                self._again()
                await asyncio.sleep(_ASK_S)
        return time.monotonic() - began_s

    def _again(self) -> None:
        """Start it where it has ended by itself, unless it would end again for the same reason."""
        if self._process is not None and self._process.is_alive():
            return
        if self._process is not None and self._process.exitcode == _UNUSABLE_INPUT:
            raise ServiceFailedError(f"{self.name} cannot be started; see {self._log}.")
        if time.monotonic() > self._began_s + _RESTART_S:
            self.start()

    async def kill(self) -> None:
        """End it as a power cut would, with whoever computes for it: nothing is finished or closed."""
        if self._process is None or self._process.pid is None:
            return
        for end in (os.killpg, os.kill):  # where it is not yet a group of its own, it has nobody
            with contextlib.suppress(ProcessLookupError):
                end(self._process.pid, signal.SIGKILL)
        await asyncio.to_thread(self._process.join)


async def _answers(http: httpx.AsyncClient) -> bool:
    try:
        return (await http.get("/health", timeout=30)).is_success
    except httpx.TransportError:
        return False


def _become(serve: Callable[[int], int], port: int, log: str) -> None:
    os.setsid()
    target = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    for stream in (1, 2):
        os.dup2(target, stream)
    sys.exit(serve(port))


class ServedCell:
    """A cell on its database, as something that travels to the process that becomes its service."""

    def __init__(self, cell_file: Path, database_url: str, log: Path) -> None:
        self._given = {"cell_file": cell_file, "database_url": database_url, "log_file": log}

    def __call__(self, port: int) -> int:
        """Serve it."""
        from truepose.app import serve

        return serve(Settings(port=port, accounts=False, **self._given))


class ServedPlant:
    """A plant on its database, likewise."""

    def __init__(self, cells_file: Path, database_url: str, log: Path) -> None:
        self._cells_file = cells_file
        self._given = {"database_url": database_url, "log_file": log}

    def __call__(self, port: int) -> int:
        """Serve it."""
        from truepose.app.plants import serve_plant

        service = Settings(port=port, accounts=False, **self._given)
        return serve_plant(PlantSettings(service, self._cells_file, _VISITS_S))
