"""How long a plant takes to answer with 1,000 robots and a million readings in its journal.

    python -m tests.studies.plant_looks --out out/plant-looks --robots 1000 --readings 1000000

Rows are laid into the database without their chain, which no look-up reads: collecting them takes long.
"""

import os
import statistics
import time
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from sqlalchemy import Connection, Table, insert

from tests.studies.running import from_command_line
from truepose.storage.database import Database
from truepose.storage.plant.looking import PlantLooks
from truepose.storage.plant.visits import VisitRepository
from truepose.storage.records import Page
from truepose.storage.tables.of_plants import (
    plant_branches,
    plant_cells,
    plant_days,
    plant_instruments,
    plant_journal,
    plant_results,
    plant_robots,
)

_CELLS: Final = 40
_INSTRUMENTS: Final = 3
_MONTHS: Final = 24
_KINDS: Final = ("campaign", "identification", "model", "diagnosis", "report")
_TIMES: Final = 30
_TOGETHER: Final = 10_000
_STAMP: Final = "2026-05-04T09:12:33.125+00:00"


@dataclass(frozen=True)
class Found:
    """Milliseconds by what was asked for: median and longest."""

    robots: int
    readings: int
    load: tuple[float, float, float]
    looks_ms: dict[str, tuple[float, float]]


async def look(folder: Path, robots: int, readings: int) -> Found:
    """Lay the rows and ask for everything that a page asks for."""
    database = Database(f"sqlite:///{folder / 'plant.sqlite3'}")
    try:
        await database.write(lambda connection: _lay(connection, robots, readings))
        looks, visits = PlantLooks(database), VisitRepository(database)
        asked: dict[str, Callable[[], Awaitable[Any]]] = {
            "500 robots": lambda: looks.robots(Page(limit=500)),
            "one robot": lambda: looks.robot(f"R-{robots // 2}"),
            "life of a robot": lambda: looks.life_of_robot(f"R-{robots // 2}"),
            "days of a robot": lambda: looks.days_of_robot(f"R-{robots // 2}"),
            "instruments": lambda: looks.instruments(Page()),
            "newest of an instrument": lambda: looks.life_of_instrument("T-1"),
            "days of an instrument": lambda: looks.days_of_instrument("T-1"),
            "100 campaigns": lambda: looks.results("campaign", Page()),
            "cells and visits": visits.newest,
        }
        times = {name: [await _ms(ask) for _ in range(_TIMES)] for name, ask in asked.items()}
    finally:
        database.close()
    looks_ms = {name: (statistics.median(some), max(some)) for name, some in times.items()}
    return Found(robots, readings, os.getloadavg(), looks_ms)


async def _ms(ask: Callable[[], Awaitable[Any]]) -> float:
    began = time.perf_counter()
    await ask()
    return (time.perf_counter() - began) * 1e3


def _lay(connection: Connection, robots: int, readings: int) -> None:
    _add(connection, plant_cells, ({"name": f"cell {n}"} for n in range(_CELLS)))
    branch = {"parent_id": None, "after_link": 0, "person": "", "reason": ""}
    _add(connection, plant_branches, ({"cell_id": n + 1, **branch} for n in range(_CELLS)))
    _add(connection, plant_instruments, ({"serial_number": f"T-{n}"} for n in range(_INSTRUMENTS)))
    _add(connection, plant_robots, ({"serial_number": f"R-{n}", "robot": "IRB 120"} for n in range(robots)))
    _add(connection, plant_results, _results(robots))
    _add(connection, plant_days, _days(robots, readings))
    _add(connection, plant_journal, _journal(readings))


def _of(robot: int, month: int) -> dict[str, Any]:
    return {
        "branch_id": robot % _CELLS + 1,
        "robot_serial_number": f"R-{robot}",
        "instrument_serial_number": f"T-{robot % _INSTRUMENTS}",
        "measured_on": f"20{24 + month // 12}-{month % 12 + 1:02}-{robot % 28 + 1:02}",
    }


def _results(robots: int) -> Iterator[dict[str, Any]]:
    for number in range(robots * _MONTHS * len(_KINDS)):
        rest, kind = divmod(number, len(_KINDS))
        month, robot = divmod(rest, robots)
        told = {"kind": _KINDS[kind], "link": number, "record_id": number, "name": "", "robot": "IRB 120"}
        yield {**_of(robot, month), **told, "clock_offset_s": 0.5}


def _days(robots: int, readings: int) -> Iterator[dict[str, Any]]:
    for month in range(_MONTHS):
        for robot in range(robots):
            each = {"session_id": month * robots + robot, "readings": readings // (robots * _MONTHS)}
            yield {**_of(robot, month), **each}


def _journal(readings: int) -> Iterator[dict[str, Any]]:
    for number in range(readings):
        yield {
            "branch_id": number % _CELLS + 1,
            "link": number,
            "stream": number // 50,
            "record": "readings",
            "record_id": number,
            "hash": bytes(32),
            "content": '{"id":1,"kind":"point","document":"{}"}',
            "verified": 1,
        }


def _add(connection: Connection, table: Table, rows: Iterator[dict[str, Any]]) -> None:
    some: list[dict[str, Any]] = []
    for row in rows:
        some.append({"recorded_at": _STAMP, **row})
        if len(some) == _TOGETHER:
            connection.execute(insert(table), some)
            some = []
    if some:
        connection.execute(insert(table), some)


def told(found: Found) -> str:
    """Return the figures in words."""
    lines = [
        f"{name}: {median:.1f} ms, longest {most:.1f} ms" for name, (median, most) in found.looks_ms.items()
    ]
    head = f"{found.robots} robots, {found.readings} readings, load {found.load[0]:.1f}"
    return "\n".join([head, *lines]) + "\n"


if __name__ == "__main__":
    from_command_line(__doc__, "plant_looks", look, told, robots=1000, readings=1_000_000)
