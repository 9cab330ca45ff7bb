"""How long a length takes from the instrument to a page: over the live stream of a session, on loopback.

    python -m tests.studies.interruptions.live_latency --seconds 60 --tablets 2

A simulated cell in real time, a service as `truepose serve` starts it, a session whose ballbar is on its
calibrator, and tablets that follow it. Each sample carries when the driver had it; what is told is the time
until a tablet had read and parsed it.
"""

import asyncio
import json
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import httpx
import numpy as np

from tests.studies.interruptions.killed_service import KilledService, standing_cell
from tests.studies.running import study_options
from truepose.demo.simulated_operator import SimulatedOperator

LIMIT_MS: Final = 150.0  # at the 95th percentile
_ANSWER_S: Final = 120.0
_REAL_TIME: Final = 1


async def measure(seconds: float, tablets: int, folder: Path, scenario: str) -> dict[str, Any]:
    """Return the latencies of a session that is followed by some tablets."""
    async with standing_cell(scenario, 0, _REAL_TIME, folder / "cell.log") as cell_file:
        (folder / "cell.toml").write_text(cell_file, encoding="utf-8")
        service = KilledService(folder / "cell.toml", folder / "sessions.sqlite3", folder / "service.log")
        await service.start()
        try:
            async with httpx.AsyncClient(base_url=service.url, timeout=_ANSWER_S, trust_env=False) as http:
                person = await _begun(http)
                following = [_follow(http, person.path, f"tablet-{n}", seconds) for n in range(tablets)]
                return _figures(await asyncio.gather(*following), seconds)
        finally:
            await service.kill()


async def _begun(http: httpx.AsyncClient) -> SimulatedOperator:
    """Return a session that has begun, its ballbar on the calibrator."""
    wanted = {"name": "latency", "poses": 1}
    created = await http.post("/api/v1/sessions", json={"kind": "ballbar", **wanted})
    created.raise_for_status()
    person = SimulatedOperator(http, created.json()["id"])
    await person.act("start")
    await person.hands("calibrator", bars="tool")
    return person


async def _follow(http: httpx.AsyncClient, path: str, tablet: str, seconds: float) -> list[float]:
    """Return how old each sample was when it had arrived [ms]."""
    ages_ms: list[float] = []
    kind = ""
    wanted: dict[str, str | float] = {"tablet": tablet, "stop_after_s": seconds}
    async with http.stream("GET", f"{path}/live", params=wanted) as stream:
        async for line in stream.aiter_lines():
            field, _, value = line.partition(": ")
            if field == "event":
                kind = value
            elif field == "data" and kind == "sample":
                sampled_at_ms = json.loads(value)["sampled_at_ms"]
                ages_ms.append(time.time_ns() / 1e6 - sampled_at_ms)
    return ages_ms


def _figures(of_tablets: Sequence[Sequence[float]], seconds: float) -> dict[str, Any]:
    ages = np.concatenate([np.array(ages) for ages in of_tablets])
    p95 = float(np.quantile(ages, 0.95))
    return {
        "tablets": len(of_tablets),
        "samples": len(ages),
        "samples_per_s": len(ages) / len(of_tablets) / seconds,
        "median_ms": float(np.median(ages)),
        "p95_ms": p95,
        "max_ms": float(ages.max()),
        "limit_ms": LIMIT_MS,
        "pass": p95 <= LIMIT_MS,
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; exit status 1 where the lengths come too late."""
    wanted = study_options(__doc__, arguments, seconds=30.0, tablets=2, scenario="irb120-tilted")
    with tempfile.TemporaryDirectory(prefix="truepose-") as folder:
        figures = asyncio.run(measure(wanted.seconds, wanted.tablets, Path(folder), wanted.scenario))
    sys.stdout.write(json.dumps(figures, indent=1) + "\n")
    return 0 if figures["pass"] else 1


if __name__ == "__main__":
    sys.exit(main())
