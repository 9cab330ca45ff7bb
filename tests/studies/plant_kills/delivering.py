"""Programs that deliver readings to a cell, and a planner who hands down: both know what was acknowledged.

What got no answer, or none but that it cannot be done now, is sent again as it was.
"""

import asyncio
import itertools
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import httpx
import numpy as np

COLUMNS: Final = ["q1 [deg]", "q2 [deg]", "q3 [deg]", "q4 [deg]", "q5 [deg]", "q6 [deg]"]
COLUMNS_OF_POINT: Final = ["x [mm]", "y [mm]", "z [mm]"]
_AGAIN_S: Final = 0.05
_ANSWER_S: Final = 60.0
_PAUSE_S: Final = (0.02, 0.3)
_HANDED_DOWN_EVERY_S: Final = (0.2, 2.0)


def reading(series: int, number: int) -> list[float]:
    """Return the values of a reading, which nobody confuses with another one's."""
    return [round(0.001 * number * joint, 6) for joint in range(1, 7)] + [500.125, series, number]


class Acknowledged:
    """What was acknowledged, a line each, so that another run of the study knows it as well."""

    def __init__(self, file: Path) -> None:
        self._file = file.open("a", encoding="utf-8")
        self.count = 0

    def note(self, **told: Any) -> None:
        """Note an acknowledgement."""
        self._file.write(json.dumps(told) + "\n")
        self._file.flush()
        self.count += 1


class Sender:
    """Sends a request until it is answered."""

    def __init__(self, url: str) -> None:
        self._http = httpx.AsyncClient(base_url=f"{url}/api/v1", trust_env=False, timeout=_ANSWER_S)
        self.under_way = 0  # requests without an answer at this moment
        self.refused = 0  # answered that it cannot be done now

    async def post(self, path: str, body: Any, key: str | None = None) -> Any:
        """Return the answer; raises RuntimeError where the request is refused for good."""
        headers = {} if key is None else {"Idempotency-Key": key}
        while True:
            self.under_way += 1
            try:
                answer = await self._http.post(path, json=body, headers=headers)
            except httpx.TransportError:
                answer = None
            finally:
                self.under_way -= 1
            if answer is not None and answer.is_success:
                return answer.json()
            if answer is not None and answer.status_code != httpx.codes.SERVICE_UNAVAILABLE:
                raise RuntimeError(f"{path}: {answer.status_code} {answer.text}")
            self.refused += answer is not None
            await asyncio.sleep(_AGAIN_S)

    async def close(self) -> None:
        """Close its connections."""
        await self._http.aclose()


async def deliver(
    cell: str,
    sender: Sender,
    acknowledged: Acknowledged,
    rng: np.random.Generator,
    ended: asyncio.Event,
    most_together: int = 5,
) -> None:
    """Deliver a series of readings, a few at a time, until that is ended."""
    columns = COLUMNS + COLUMNS_OF_POINT
    series = (await sender.post("/series", {"name": "killed", "columns": columns}))["id"]
    first = 1
    while not ended.is_set():
        count = int(rng.integers(1, most_together + 1))
        readings = [reading(series, number) for number in range(first, first + count)]
        await sender.post(f"/series/{series}/readings", {"first": first, "readings": readings})
        acknowledged.note(cell=cell, series=series, first=first, count=count)
        first += count
        await asyncio.sleep(float(rng.uniform(*_PAUSE_S)))


async def hand_down(
    cells: list[str],
    sender: Sender,
    acknowledged: Acknowledged,
    rng: np.random.Generator,
    ended: asyncio.Event,
) -> None:
    """Hand plans down to cells until that is ended."""
    for name in _names(rng):
        if ended.is_set():
            return
        cell = cells[int(rng.integers(len(cells)))]
        plan = {"cell": cell, "kind": "plan", "name": name, "person": "Ada", "document": {"name": name}}
        await sender.post("/plant/hand-downs", plan, key=name)
        acknowledged.note(handed_down=name, cell=cell)
        await asyncio.sleep(float(rng.uniform(*_HANDED_DOWN_EVERY_S)))


def _names(rng: np.random.Generator) -> Iterator[str]:
    run = int(rng.integers(1 << 62))
    return (f"plan-{run:x}-{number}" for number in itertools.count(1))
