"""A cell with a ballbar session running and its plant, killed at random moments: nothing lost or doubled.

    python -m tests.studies.plant_kills --kills 200 --out out/plant-kills

Each kill is a SIGKILL to the cell's service with its workers, or to the plant's, which is started again. The
person at the cell repeats what got no answer. In the end every link of the cell's chain is in the plant once,
in its order, and so is every act that was acknowledged to the person.
"""

import argparse
import asyncio
import contextlib
import json
import os
import signal
import sqlite3
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Final

import httpx
import numpy as np

from tests.helpers.ports import free_port
from tests.studies.interruptions.killed_service import KilledService, standing_cell
from tests.studies.plant_kills.compared import Compared, chain_of, compared, journal_of, keys_of
from truepose.demo.cell.person_at_tablet import PersonAtTablet
from truepose.demo.errors import ServiceFailedError

_ALIVE_S: Final = (0.02, 1.5)  # between two kills
_START_S: Final = 90.0
_ANSWER_S: Final = 900.0
_PATIENCE_S: Final = 120.0  # for the plant to have everything once nobody kills any more
_ASK_S: Final = 0.05


@dataclass(slots=True)
class Tally:
    """What was seen."""

    kills_of_cell: int = 0
    kills_of_plant: int = 0
    sessions: int = 0
    links: int = 0
    acts: int = 0
    load: tuple[float, float, float] = (0.0, 0.0, 0.0)
    took_s: float = 0.0
    found: Compared | None = None
    keys: list[str] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether something was tried, and nothing was wrong."""
        return self.found is not None and self.links > 0 and not any(asdict(self.found).values())


class KilledPlant:
    """A plant's service as `truepose plant` starts it."""

    def __init__(self, cells: Path, database: Path, log: Path) -> None:
        self._cells, self._database, self._log = cells, database, log
        self._port = free_port()
        self._process: asyncio.subprocess.Process | None = None

    async def start(self) -> None:
        """Start it; it is killed also before it is ready."""
        with self._log.open("ab") as log:
            self._process = await asyncio.create_subprocess_exec(
                *(sys.executable, "-m", "truepose", "plant", "--port", str(self._port), "--every", "0.1s"),
                *("--cells", str(self._cells), "--database", f"sqlite:///{self._database}"),
                stdout=asyncio.subprocess.DEVNULL,
                stderr=log,
                start_new_session=True,
            )

    async def kill(self) -> None:
        """End it as a power cut would."""
        if self._process is not None:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL)
            await self._process.wait()


async def kill_both(tally: Tally, kills: int, seed: int, folder: Path, scenario: str) -> None:
    """Kill cell and plant by turns that are drawn, and compare what they have in the end."""
    rng = np.random.default_rng(seed)
    began = time.monotonic()
    async with standing_cell(scenario, seed, 0, folder / "cell.log") as cell_file:
        (folder / "cell.toml").write_text(cell_file, encoding="utf-8")
        cell = KilledService(folder / "cell.toml", folder / "cell.sqlite3", folder / "service.log")
        (folder / "cells.toml").write_text(f'[[cell]]\nname = "cell"\nurl = "{cell.url}"\n', encoding="utf-8")
        plant = KilledPlant(folder / "cells.toml", folder / "plant.sqlite3", folder / "plant.log")
        await cell.start()
        await plant.start()
        try:
            async with httpx.AsyncClient(base_url=cell.url, timeout=_ANSWER_S, trust_env=False) as http:
                while tally.kills_of_cell + tally.kills_of_plant < kills:
                    await _session(tally, kills, rng, http, cell, plant)
            await _all_collected(folder)
        finally:
            await plant.kill()
            await cell.kill()
    tally.load, tally.took_s = os.getloadavg(), time.monotonic() - began
    _compare(tally, folder)


async def _session(
    tally: Tally,
    kills: int,
    rng: np.random.Generator,
    http: httpx.AsyncClient,
    cell: KilledService,
    plant: KilledPlant,
) -> None:
    wanted = {"name": "killed", "seed": tally.sessions, "poses": 8}
    created = await http.post("/api/v1/ballbar-sessions", json=wanted)
    created.raise_for_status()
    tally.sessions += 1
    person = PersonAtTablet(http, created.json()["id"], f"tablet-{tally.sessions}")
    walking = asyncio.create_task(person.walk())
    try:
        while tally.kills_of_cell + tally.kills_of_plant < kills and not walking.done():
            await asyncio.wait({walking}, timeout=float(rng.uniform(*_ALIVE_S)))
            await _kill_one(tally, rng, person, cell, plant)
    finally:
        walking.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await walking
        tally.keys += [act.key for act in person.ledger.acts if act.entry is not None]
    await person.act("abort")


async def _kill_one(
    tally: Tally,
    rng: np.random.Generator,
    person: PersonAtTablet,
    cell: KilledService,
    plant: KilledPlant,
) -> None:
    if rng.uniform() < 0.5:
        tally.kills_of_plant += 1
        await plant.kill()
        await plant.start()
        await asyncio.sleep(float(rng.uniform(0.0, 4.0)))  # it needs two seconds before it visits
        return
    tally.kills_of_cell += 1
    person.hands_free.clear()
    await cell.kill()
    await cell.start()
    person.hands_free.set()


async def _all_collected(folder: Path) -> None:
    """Return once the plant is as far as the cell; raises ServiceFailedError."""
    until_s = time.monotonic() + _PATIENCE_S
    while time.monotonic() < until_s:
        with contextlib.suppress(sqlite3.OperationalError):
            if len(journal_of(folder / "plant.sqlite3")) >= len(chain_of(folder / "cell.sqlite3")):
                return
        await asyncio.sleep(_ASK_S)
    raise ServiceFailedError("The plant did not collect everything within two minutes; see plant.log.")


def _compare(tally: Tally, folder: Path) -> None:
    chain, plant = chain_of(folder / "cell.sqlite3"), folder / "plant.sqlite3"
    tally.links, tally.acts = len(chain), len(tally.keys)
    tally.found = compared(chain, journal_of(plant), tally.keys, keys_of(plant))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--scenario", default="lrmate-tilted")
    parser.add_argument("--out", type=Path, required=True)
    wanted = parser.parse_args(arguments)
    wanted.out.mkdir(parents=True, exist_ok=True)
    tally = Tally()
    with tempfile.TemporaryDirectory(dir=wanted.out) as folder:
        asyncio.run(kill_both(tally, wanted.kills, wanted.seed, Path(folder), wanted.scenario))
    told = {name: value for name, value in asdict(tally).items() if name != "keys"} | {"pass": tally.passed}
    (wanted.out / "plant_kills.json").write_text(json.dumps(told, indent=1))
    sys.stdout.write(json.dumps(told, indent=1) + "\n")
    return 0 if tally.passed else 1


if __name__ == "__main__":
    sys.exit(main())
