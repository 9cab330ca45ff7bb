"""Sessions that are under way: copies of database and cell, kept while one session goes as it should."""

import shutil
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.studies.taken_up.onlooked_cell import standing
from tests.studies.taken_up.service_here import ServiceHere
from truepose.demo.simulated_operator import SimulatedOperator
from truepose.storage.engine.sqlite_connections import LIBRARY

_STEPS_BETWEEN = 4
_ENDED = {"finished", "aborted", "failed"}


@dataclass(frozen=True, slots=True)
class Copy:
    """Database and cell at one moment of a session."""

    database: Path
    cell: Path
    precalibrated: bool


@dataclass(frozen=True, slots=True)
class Begun:
    """One robot's session, at many moments."""

    scenario: str
    seed: int
    copies: Sequence[Copy]


async def begin(
    scenario: str, seed: int, wanted: Mapping[str, Any], folder: Path, most: int | None = None
) -> Begun:
    """Plan the session that is `wanted`, walk through it rightly, and keep a copy every few steps.

    `most` is how many copies are kept; None: as many as the session has.
    """
    folder.mkdir(parents=True)
    copies: list[Copy] = []
    async with standing(scenario, seed, folder / "cell.json") as (_, addresses):
        service = ServiceHere(folder, scenario, addresses)
        await service.start()
        try:
            created = await service.http.post(
                "/api/v1/sessions", json={"kind": "ballbar", "name": "six legs", **wanted}
            )
            created.raise_for_status()
            person = SimulatedOperator(service.http, created.json()["id"])
            for step in (await _every_few_steps(service, person.path))[:most]:
                session = await person.walk(until=step)
                if session["state"] in _ENDED:
                    break
                copies.append(_copy(service, folder, len(copies)))
        finally:
            await service.stop()
    return Begun(scenario, seed, copies)


async def _every_few_steps(service: ServiceHere, path: str) -> list[str]:
    steps = (await service.http.get(f"{path}/plan")).json()["steps"]
    return [step["id"] for step in steps[::_STEPS_BETWEEN]]


def _copy(service: ServiceHere, folder: Path, number: int) -> Copy:
    kept = Copy(
        folder / f"{number}.sqlite3",
        folder / f"{number}.cell.json",
        any(line["kind"] == "computed" for line in service.lines()),
    )
    with (
        closing(LIBRARY.connect(service.database)) as source,
        closing(LIBRARY.connect(kept.database)) as copy,
    ):
        source.backup(copy)
    shutil.copy(folder / "cell.json", kept.cell)
    return kept
