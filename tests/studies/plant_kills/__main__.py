"""Cells, their plant, the database server and workers are killed at random moments: nothing lost or doubled.

    python -m tests.studies.plant_kills --kills 1000 --out out/plant-kills

One cell is on SQLite, the other and the plant are on a PostgreSQL server of the study's own. Programs deliver
readings to both cells, a planner hands plans down through the plant, and two workers of Dask compute. Cells,
plant, server (kill -9 of its first process, an immediate stop, kill -9 of the process behind a connection)
and workers are killed and started again, each in its own time. Whoever got no answer sends the same again.
After every two hundred kills nobody is killed until the plant has everything. Then each link of the cells'
chains is in the plant once, in its order, under the branch that there was; each reading and each plan that
was acknowledged is in cell and plant once and says what was sent; and `truepose verify` finds nothing in any
database. With `--sessions` a person at a tablet walks through ballbar sessions at the first cell as well.

What was killed is in kills.jsonl of the folder, a line each, what was found in checks.jsonl: the same command
goes on there, with the same databases, until so many kills are made.
"""

import asyncio
import contextlib
import json
import os
import sys
import time
from collections import Counter
from collections.abc import AsyncIterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

import httpx
import numpy as np

from tests.helpers.postgresql.bare import BareServer
from tests.studies.interruptions.killed_service import standing_cell
from tests.studies.plant_kills.compared import (
    Compared,
    chain_of,
    compared,
    journal_of,
    read_acknowledged,
    waiting_hand_downs,
)
from tests.studies.plant_kills.delivering import Acknowledged, Sender, deliver, hand_down
from tests.studies.plant_kills.killing import Kills, kill_server, kill_service, kill_workers
from tests.studies.plant_kills.services import KilledService, ServedCell, ServedPlant
from tests.studies.plant_kills.walking import walk_sessions
from tests.studies.plant_kills.workers import Workers, two_workers
from tests.studies.running import leave, study_options
from truepose.demo.errors import ServiceFailedError

_CELLS: Final = ("on a file", "on a server")
_DATABASES: Final = ("cell", "plant")
_PROGRAMS: Final = 2  # that deliver to a cell
_CHECK_EVERY: Final = 200
_PATIENCE_S: Final = 300.0  # for the plant to have everything once nobody kills any more
_SCENARIO: Final = "lrmate-tilted"
WITHOUT_INSTRUMENTS: Final = """
robot = "fanuc-lr-mate-200ic"
[[device]]
name = "clock"
driver = "monotonic_clock"
"""


class _Site:
    """Everything that stands: databases, services, workers, and what is known of them."""

    def __init__(self, folder: Path, workers: Workers, cell_file: Path, *, sessions: bool) -> None:
        self.folder, self.workers, self.sessions = folder, workers, sessions
        self.server = BareServer(folder / "server")
        self.server.make(*_DATABASES)
        self.databases = {
            "on a file": f"sqlite:///{folder / 'cell.sqlite3'}",
            "on a server": self.server.url("cell"),
        }
        self.plant_database = self.server.url("plant")
        self.cells = {
            name: KilledService(
                f"cell {name}",
                ServedCell(cell_file, url, folder / f"cell-{number}.log"),
                folder / f"cell-{number}.said",
            )
            for number, (name, url) in enumerate(self.databases.items(), start=1)
        }
        cells_file = folder / "cells.toml"
        cells_file.write_text(
            "".join(f'[[cell]]\nname = "{name}"\nurl = "{cell.url}"\n' for name, cell in self.cells.items())
        )
        self.plant = KilledService(
            "plant",
            ServedPlant(cells_file, self.plant_database, folder / "plant.log"),
            folder / "plant.said",
        )

    @property
    def services(self) -> list[KilledService]:
        """Cells and plant."""
        return [*self.cells.values(), self.plant]

    async def end(self) -> None:
        """Kill whatever runs."""
        for service in self.services:
            await service.kill()
        await self.server.stop_at_once()


async def study(folder: Path, kills: int, seed: int, *, sessions: bool) -> bool:
    """Kill until so many kills stand in the folder; returns whether nothing was found wrong."""
    with two_workers(folder / "campaigns") as workers:
        async with _cell_file(folder, seed, sessions=sessions) as cell_file:
            site = _Site(folder, workers, cell_file, sessions=sessions)
            try:
                await site.server.start()
                while (made := len(_lines(folder / "kills.jsonl"))) < kills:
                    await _killed(site, min(_CHECK_EVERY, kills - made), made, seed)
                    if not await _checked(site):
                        return False
            finally:
                await site.end()
    return True


@contextlib.asynccontextmanager
async def _cell_file(folder: Path, seed: int, *, sessions: bool) -> AsyncIterator[Path]:
    """Offer a cell: with instruments that stay as they are where sessions are wanted, else with none."""
    file = folder / "cell.toml"
    if not sessions:
        file.write_text(WITHOUT_INSTRUMENTS)
        yield file
        return
    async with standing_cell(_SCENARIO, seed, 0, folder / "standing.log") as text:
        file.write_text(text)
        yield file


async def _killed(site: _Site, count: int, before: int, seed: int) -> None:
    """Let people work and kill so many times."""
    kills = Kills(site.folder / "kills.jsonl", count, before)
    acknowledged = Acknowledged(site.folder / "acknowledged.jsonl")
    rngs = iter(np.random.default_rng([seed, before]).spawn(20))
    senders = {service.name: Sender(service.url) for service in site.services}
    ended, unharmed = asyncio.Event(), {service.name: asyncio.Lock() for service in site.services}

    async def killing() -> None:
        async with asyncio.TaskGroup() as killers:
            for service in site.services:
                sender, lock = senders[service.name], unharmed[service.name]
                killers.create_task(kill_service(service, sender, acknowledged, kills, next(rngs), lock))
            killers.create_task(kill_server(site.server, _DATABASES, kills, next(rngs)))
            killers.create_task(kill_workers(site.workers, kills, next(rngs)))
        for service in site.services:
            await service.up()
        ended.set()

    try:
        async with asyncio.TaskGroup() as people:
            for name, cell in site.cells.items():
                for _ in range(_PROGRAMS):
                    people.create_task(deliver(name, senders[cell.name], acknowledged, next(rngs), ended))
            people.create_task(
                hand_down(list(site.cells), senders[site.plant.name], acknowledged, next(rngs), ended)
            )
            if site.sessions:
                first = _CELLS[0]
                people.create_task(
                    walk_sessions(
                        first,
                        site.cells[first].url,
                        acknowledged,
                        int(next(rngs).integers(1 << 31)),
                        ended,
                        unharmed[site.cells[first].name],
                    )
                )
            people.create_task(killing())
    finally:
        for sender in senders.values():
            await sender.close()


async def _checked(site: _Site) -> bool:
    """Compare everything once the plant has it; returns whether nothing is wrong."""
    await _all_collected(site)
    acknowledged = read_acknowledged(site.folder / "acknowledged.jsonl")
    found, there = await asyncio.to_thread(compared, site.databases, site.plant_database, acknowledged)
    found.unwell = await _unwell(site)
    workers = {"parts": site.workers.computed, "parts_lost": site.workers.lost}
    workers["parts_with_other_bits"] = site.workers.other_bits
    made = len(_lines(site.folder / "kills.jsonl"))
    line = {"kills": made, **there, **workers, "found": asdict(found), "load": os.getloadavg()}
    with (site.folder / "checks.jsonl").open("a", encoding="utf-8") as checks:
        checks.write(json.dumps(line) + "\n")
    sys.stderr.write(json.dumps(line) + "\n")
    return _is_clean(line)


def _is_clean(check: dict[str, Any]) -> bool:
    return Compared(**check["found"]).clean and not check["parts_lost"] + check["parts_with_other_bits"]


async def _unwell(site: _Site) -> int:
    async with httpx.AsyncClient(trust_env=False, timeout=60) as http:
        answers = [await http.get(f"{service.url}/health") for service in site.services]
    return sum(answer.json()["status"] != "ok" for answer in answers)


async def _all_collected(site: _Site) -> None:
    """Return once the plant is as far as the cells; raises ServiceFailedError."""
    until_s = time.monotonic() + _PATIENCE_S
    async with httpx.AsyncClient(base_url=site.plant.url, trust_env=False, timeout=60) as http:
        while await asyncio.to_thread(_behind, site):
            if time.monotonic() > until_s:
                raise ServiceFailedError("The plant did not collect everything in five minutes.")
            for name in site.cells:
                with contextlib.suppress(httpx.TransportError):
                    await http.post(f"/api/v1/plant/cells/{name}/visits", json={})
            await asyncio.sleep(0.5)


def _behind(site: _Site) -> bool:
    missing = (
        len(chain_of(url)) - len(journal_of(site.plant_database, name))
        for name, url in site.databases.items()
    )
    return any(one > 0 for one in missing) or waiting_hand_downs(site.plant_database) > 0


def _lines(file: Path) -> list[dict[str, Any]]:
    return (
        [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()] if file.exists() else []
    )


def summary(folder: Path) -> dict[str, Any]:
    """Return what all runs in a folder came to."""
    kills, checks = _lines(folder / "kills.jsonl"), _lines(folder / "checks.jsonl")
    loads = [kill["load"] for kill in kills]
    ready_s = [kill["ready_s"] for kill in kills if kill.get("ready_s")]
    return {
        "kills": dict(Counter(kill["victim"] for kill in kills)),
        "all": len(kills),
        "with_requests_under_way": sum(kill.get("under_way", 0) > 0 for kill in kills),
        "load": [min(loads, default=0.0), max(loads, default=0.0)],
        "ready_s": float(np.median(ready_s)) if ready_s else None,
        "last_check": checks[-1] if checks else None,
        "pass": bool(checks) and all(map(_is_clean, checks)),
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; exit status 1 where anything was found wrong."""
    wanted = study_options(
        __doc__,
        arguments,
        out=Path,
        kills=(1000, "in the folder, with those of earlier runs"),
        seed=0,
        sessions=(False, "ballbar sessions at the first cell as well"),
    )
    folder = wanted.out.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    os.environ["XDG_DATA_HOME"] = str(folder / "beside")  # notes beside databases of a server
    clean = asyncio.run(study(folder, wanted.kills, wanted.seed, sessions=wanted.sessions))
    told = summary(folder)
    leave(folder, "plant_kills", told)
    sys.stdout.write(json.dumps(told, indent=1) + "\n")
    return 0 if clean and told["pass"] else 1


if __name__ == "__main__":
    sys.exit(main())
