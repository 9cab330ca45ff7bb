"""Starts a plant as its users do and asks for its pages, from the first moment on."""

import asyncio
import json
import os
import signal
import statistics
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import httpx

from tests.helpers.ports import free_port
from tests.studies.plant_looks.rows import CELLS, name_of
from tests.studies.processes import cpu_s, memory_mb

_FIRST: Final = {
    "first page": "/",
    "first life of a robot": "/robots/R-{robot}",
    "first of REST": "/api/v1/plant/robots",
}
_PAGES: Final = {
    "the plant": "/",
    "life of a robot": "/robots/R-{robot}",
    "life of an instrument": "/instruments/T-1",
    "what changed, REST": "/api/v1/plant/changes",
    "100 robots, REST": "/api/v1/plant/robots",
    "life of a robot, REST": "/api/v1/plant/robots/R-{robot}",
    "life of an instrument, REST": "/api/v1/plant/instruments/T-1",
}
_APART_S: Final = 2.5  # between two asks


@dataclass(frozen=True)
class Started:
    """How soon a plant was there, and how it answered in its first minute."""

    ready_s: float
    ready_cpu_s: float  # of the processor, up to then
    first_ms: dict[str, float]
    then_ms: dict[str, tuple[float, float]]  # median and longest
    cells_visited: int
    links_collected: int
    memory_mb: float  # resident at the end
    load: float


def away() -> list[str]:
    """Return addresses at which nobody listens."""
    return [f"http://127.0.0.1:{free_port()}" for _ in range(CELLS)]


async def started(folder: Path, url: str, cells: Sequence[str], robots: int, asks: int) -> Started:
    """Start a plant on a database, ask for its pages so often, and end it."""
    file = folder / "cells.toml"
    file.write_text("".join(f'[[cell]]\nname = "{name_of(n)}"\nurl = "{at}"\n' for n, at in enumerate(cells)))
    begun_s = time.perf_counter()
    with folder.with_name("plant.log").open("ab") as log:
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "truepose", "plant", "--no-accounts", "--port", "0"),
            *("--cells", str(file), "--database", url, "--log-file", str(folder / "plant.jsonl")),
            stdout=asyncio.subprocess.PIPE,
            stderr=log,
            start_new_session=True,
        )
    try:
        assert process.stdout is not None
        at = json.loads(await process.stdout.readline())["url"]
        ready_s, ready_cpu_s = time.perf_counter() - begun_s, cpu_s(process.pid)
        async with httpx.AsyncClient(base_url=at, trust_env=False, timeout=120) as http:
            first_ms = {
                name: await _ms(http, path.format(robot=robots // 2)) for name, path in _FIRST.items()
            }
            then_ms = await _asked(http, f"{robots // 2}", asks)
            visited, links = await _visits(http)
        taken_mb = memory_mb(process.pid)
    finally:
        process.send_signal(signal.SIGTERM)
        await process.wait()
    return Started(ready_s, ready_cpu_s, first_ms, then_ms, visited, links, taken_mb, os.getloadavg()[0])


async def _asked(http: httpx.AsyncClient, robot: str, asks: int) -> dict[str, tuple[float, float]]:
    took: dict[str, list[float]] = {name: [] for name in _PAGES}
    begun_s = time.perf_counter()
    for ask in range(asks):
        for name, path in _PAGES.items():
            took[name].append(await _ms(http, path.format(robot=robot)))
        await asyncio.sleep(max(0.0, begun_s + (ask + 1) * _APART_S - time.perf_counter()))
    return {name: (statistics.median(some), max(some)) for name, some in took.items()}


async def _ms(http: httpx.AsyncClient, path: str) -> float:
    begun_s = time.perf_counter()
    (await http.get(path)).raise_for_status()
    return (time.perf_counter() - begun_s) * 1e3


async def _visits(http: httpx.AsyncClient) -> tuple[int, int]:
    cells: list[dict[str, Any]] = (await http.get("/api/v1/plant/cells")).raise_for_status().json()
    visits = [cell["newest_visit"] for cell in cells if cell["newest_visit"]]
    whole = [visit for visit in visits if visit["outcome"] == "whole"]
    return len(visits), sum(visit["collected"] for visit in whole)
