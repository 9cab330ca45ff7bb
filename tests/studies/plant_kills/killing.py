"""Who is killed when: each victim in a loop of its own, so that they also fall together."""

import asyncio
import json
import os
import time
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any, Final

import numpy as np

from tests.helpers.postgresql.bare import BareServer
from tests.studies.plant_kills.delivering import Acknowledged, Sender
from tests.studies.plant_kills.services import KilledService
from tests.studies.plant_kills.workers import Workers

_ALIVE_S: Final = (0.1, 1.6)  # between two kills of a service
_EARLY: Final = 0.15  # share of the kills that need not wait until a service is ready
_STARTING_S: Final = (0.0, 0.6)
_SERVER_ALIVE_S: Final = (1.0, 5.0)
_WORKERS_REST_S: Final = (0.0, 6.0)


class Kills:
    """The kills that are still to be made, and a line for each that was."""

    def __init__(self, file: Path, left: int, before: int) -> None:
        self._file = file.open("a", encoding="utf-8")
        self.left, self.number = left, before
        self._began_s = time.monotonic()

    def note(self, victim: str, **told: Any) -> None:
        """Note a kill."""
        self.number += 1
        self.left -= 1
        at_s = round(time.monotonic() - self._began_s, 3)
        line = {"kill": self.number, "victim": victim, "at_s": at_s, "load": os.getloadavg()[0], **told}
        self._file.write(json.dumps(line) + "\n")
        self._file.flush()


async def kill_service(
    service: KilledService,
    sender: Sender,
    acknowledged: Acknowledged,
    kills: Kills,
    rng: np.random.Generator,
    unharmed: asyncio.Lock,
) -> None:
    """Kill a service and start it again until all kills are made; not while somebody holds `unharmed`."""
    while kills.left > 0:
        before, ready_s = acknowledged.count, None
        if rng.uniform() < _EARLY:
            await asyncio.sleep(float(rng.uniform(*_STARTING_S)))
        else:
            ready_s = await service.up()
            await asyncio.sleep(float(rng.uniform(*_ALIVE_S)))
        async with unharmed:
            if kills.left <= 0:
                return
            await service.kill()
            told = {"ready_s": ready_s, "under_way": sender.under_way}
            kills.note(service.name, acknowledged=acknowledged.count - before, **told)
            service.start()


async def kill_server(
    server: BareServer, databases: tuple[str, ...], kills: Kills, rng: np.random.Generator
) -> None:
    """Kill a database server in one of three ways, and have it again, until all kills are made."""

    async def backend() -> None:
        serving = server.backends(databases)
        if serving:
            os.kill(int(rng.choice(serving)), 9)

    ways: dict[str, Callable[[], Awaitable[None]]] = {
        "postmaster": server.kill,
        "immediate": server.stop_at_once,
        "backend": backend,
    }
    while kills.left > 0:
        await asyncio.sleep(float(rng.uniform(*_SERVER_ALIVE_S)))
        way = str(rng.choice(list(ways)))
        if kills.left <= 0 or (way == "backend" and not server.backends(databases)):
            continue
        began_s = time.monotonic()
        await ways[way]()
        kills.note(f"server, {way}")
        await server.start()
        await asyncio.sleep(max(0.0, 0.2 - (time.monotonic() - began_s)))


async def kill_workers(workers: Workers, kills: Kills, rng: np.random.Generator) -> None:
    """Kill a worker while parts are computed until all kills are made."""
    while kills.left > 0:
        computing = await asyncio.to_thread(workers.round, rng)
        kills.note("worker", computing=computing)
        await asyncio.sleep(float(rng.uniform(*_WORKERS_REST_S)))
