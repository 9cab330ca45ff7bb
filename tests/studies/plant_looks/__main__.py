"""How soon a plant is there and answers, on SQLite and on PostgreSQL, with cells that are away or answer.

    python -m tests.studies.plant_looks --out out/plant-looks --robots 1000 --readings 1000000

A database is laid, with 120 results a robot, and one of a tenth of the size, so that the growth shows. On
each of them everything is looked up that pages ask for, and the service is started as its users start it.
"""

import contextlib
import os
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from tests.helpers.postgresql.server import own_server, programs
from tests.studies.plant_looks.laying import OfPostgreSQL, OfSQLite, lay
from tests.studies.plant_looks.looking_up import looked_up
from tests.studies.plant_looks.rows import Laid
from tests.studies.plant_looks.stand_ins import answering
from tests.studies.plant_looks.starting import Started, away, started
from tests.studies.running import from_command_line

_TENTH: Final = 10
_FEW: Final = 5


@dataclass
class OnEngine:
    """What was found on one engine with one size."""

    engine: str
    robots: int
    readings: int
    looks_ms: dict[str, tuple[float, float]] = field(default_factory=dict)
    starts: dict[str, Started] = field(default_factory=dict)


@dataclass
class Found:
    """Everything that was found."""

    began_with_load: tuple[float, float, float] = field(default_factory=os.getloadavg)
    laid_s: list[float] = field(default_factory=list)
    took_s: float = 0.0
    found: list[OnEngine] = field(default_factory=list)


async def look(folder: Path, robots: int, readings: int, asks: int) -> Found:
    """Lay both sizes on both engines and measure."""
    found, begun_s = Found(), time.perf_counter()
    with _server(folder) as make:
        for tenth in (_TENTH, 1):
            few = _FEW if tenth > 1 else asks
            await _measured(found, folder, make, robots // tenth, readings // tenth, few)
    found.took_s = time.perf_counter() - begun_s
    return found


async def _measured(found, folder, make, robots, readings, asks):
    urls = {"SQLite": f"sqlite:///{folder / f'plant-{robots}.sqlite3'}", **make(f"plant_{robots}")}
    begun_s = time.perf_counter()
    targets = [OfSQLite(url) if engine == "SQLite" else OfPostgreSQL(url) for engine, url in urls.items()]
    laid = lay(targets, robots, readings, datetime.now(UTC).date())
    found.laid_s.append(time.perf_counter() - begun_s)
    for engine, url in urls.items():
        of = OnEngine(engine, robots, readings, await looked_up(url, robots))
        of.starts["away"] = await started(folder, url, away(), robots, asks)
        of.starts["answering"] = await _beside_cells(folder, url, laid, robots, asks)
        found.found.append(of)


async def _beside_cells(folder: Path, url: str, laid: Laid, robots: int, asks: int) -> Started:
    async with answering(laid.cells) as cells:
        return await started(folder, url, cells, robots, asks)


@contextlib.contextmanager
def _server(folder: Path) -> Iterator:
    """Yield what makes a database of a name on a server; none where no server is installed."""
    os.environ["XDG_DATA_HOME"] = str(folder / "beside")
    if programs() is None:
        yield lambda name: {}
        return
    with own_server() as server:
        yield lambda name: {"PostgreSQL": server.make(name, "template1")}


def told(found: Found) -> str:
    """Return the figures in words."""
    head = "laid in " + ", ".join(f"{took:.0f} s" for took in found.laid_s)
    lines = [f"{head}; all took {found.took_s:.0f} s; load at the beginning {found.began_with_load[0]:.1f}"]
    for of in found.found:
        on = f"{of.engine}, {of.robots} robots, {of.readings} readings"
        lines += ["", f"{on}: looked up, median and longest", *_times(of.looks_ms)]
        for cells, start in of.starts.items():
            lines += ["", f"{on}, cells {cells}", *_start(start)]
    return "\n".join(lines) + "\n"


def _start(start: Started) -> list[str]:
    firsts = ", ".join(f"{name} {took:.0f} ms" for name, took in start.first_ms.items())
    return [
        f"  ready after {start.ready_s:.2f} s ({start.ready_cpu_s:.2f} s of processor), {firsts}",
        *_times(start.then_ms),
        f"  {start.cells_visited} cells visited, {start.links_collected} links collected, "
        f"{start.memory_mb:.0f} MB, load {start.load:.1f}",
    ]


def _times(times: dict[str, tuple[float, float]]) -> list[str]:
    return [f"  {name}: {median:.1f} ms, longest {most:.1f} ms" for name, (median, most) in times.items()]


if __name__ == "__main__":
    from_command_line(__doc__, "plant_looks", look, told, robots=1000, readings=1_000_000, asks=20)
