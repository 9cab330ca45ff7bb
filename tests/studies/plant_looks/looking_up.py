"""Asks for everything that a page of a plant asks for, in this process and with nothing else beside it."""

import statistics
import time
from collections.abc import Awaitable, Callable
from datetime import UTC, datetime
from typing import Any, Final

from truepose.storage.database import Database
from truepose.storage.plant.cells import VisitRepository
from truepose.storage.plant.overview import PlantOverview
from truepose.storage.plant.queries import PlantQueries
from truepose.storage.records import Page

_TIMES: Final = 30


async def looked_up(url: str, robots: int) -> dict[str, tuple[float, float]]:
    """Return the milliseconds of each look-up: median and longest."""
    database = Database(url)
    try:
        asked = _asked(database, f"R-{robots // 2}")
        times = {name: [await _ms(ask) for _ in range(_TIMES)] for name, ask in asked.items()}
    finally:
        database.close()
    return {name: (statistics.median(some), max(some)) for name, some in times.items()}


def _asked(database: Database, robot: str) -> dict[str, Callable[[], Awaitable[Any]]]:
    today = datetime.now(UTC).date()
    looks, visits, overview = PlantQueries(database), VisitRepository(database), PlantOverview(database)
    return {
        "all robots with their last day": lambda: overview.robots(today),
        "500 robots": lambda: looks.robots(Page(limit=500), today),
        "one robot": lambda: looks.robot(robot, today),
        "life of a robot": lambda: looks.life_of_robot(robot),
        "days of a robot": lambda: looks.days_of_robot(robot),
        "instruments": lambda: looks.instruments(Page(), today),
        "newest of an instrument": lambda: looks.life_of_instrument("T-1"),
        "days of an instrument": lambda: looks.days_of_instrument("T-1"),
        "100 campaigns": lambda: looks.results("campaign", Page()),
        "cells and visits": visits.newest,
    }


async def _ms(ask: Callable[[], Awaitable[Any]]) -> float:
    begun_s = time.perf_counter()
    await ask()
    return (time.perf_counter() - begun_s) * 1e3
