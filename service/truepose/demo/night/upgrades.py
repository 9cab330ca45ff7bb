"""What an earlier program left is read, verified and identified as on the day it was measured."""

import asyncio
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from truepose.demo.cell.client import ServiceClient, connected
from truepose.demo.cell.opened import DATABASE, SERVICE_LOG
from truepose.demo.cell.processes import SimulatedService, running_service
from truepose.demo.night.check import Check, at_most, none_of
from truepose.demo.night.earlier import earlier_schemas, write_earlier
from truepose.demo.progress import RunProgress
from truepose.storage.connection.sqlite.library import LIBRARY
from truepose.storage.integrity.verification import verify

# Identification got better in the meantime; where a parameter moved by more, it is another answer.
_MOST_MOVED: Final = 0.5
_CAMPAIGN: Final = 1
_IDENTIFICATION: Final = 1


@dataclass(frozen=True, slots=True)
class UpgradedDatabase:
    """The service on the database that a program of an earlier schema left."""

    schema: str

    @property
    def name(self) -> str:
        """As the night calls it."""
        return f"upgrade-from-{self.schema}"

    @property
    def note(self) -> str:
        """What is tried."""
        return f"The service takes over a database of schema {self.schema}"

    def run(self, folder: Path, progress: RunProgress) -> list[Check]:
        """Upgrade it, look at everything, and identify the campaign again; raises DemoError."""
        progress.doing = f"taking over a database of schema {self.schema}"
        write_earlier(self.schema, folder / DATABASE)
        kept = _positions(folder / DATABASE)
        checks = asyncio.run(_looked_at(folder, kept))
        return [*checks, none_of("records that are not as written", verify(folder / DATABASE).findings)]


def upgraded_databases() -> list[UpgradedDatabase]:
    """Return the case of every schema that was ever in use."""
    return [UpgradedDatabase(schema) for schema in earlier_schemas()]


def _positions(file: Path) -> dict[int, list[float]]:
    """Return every reading of a database by its number, as the earlier program wrote it."""
    connection = LIBRARY.connect(file)
    try:
        rows = connection.execute("SELECT id, document FROM readings").fetchall()
    finally:
        connection.close()
    return {number: json.loads(document)["position_tracker_mm"] for number, document in rows}


async def _looked_at(folder: Path, kept: dict[int, list[float]]) -> list[Check]:
    service = SimulatedService("irb120-clean", 3, folder / DATABASE, folder / SERVICE_LOG)
    async with running_service(service) as url, connected(url) as client:
        sessions = await client.get("/sessions")
        found = [reading for one in sessions for reading in await client.readings(one["id"])]
        now = {reading["id"]: reading["position_tracker_mm"] for reading in found}
        wrong = [f"reading {number}" for number in kept | now if kept.get(number) != now.get(number)]
        states = sorted({str(one["state"]) for one in sessions})
        return [
            Check("sessions", "finished", ", ".join(states), states == ["finished"]),
            none_of("readings lost or changed", wrong),
            await _identified_again(client),
        ]


async def _identified_again(client: ServiceClient) -> Check:
    then = (await client.get(f"/identifications/{_IDENTIFICATION}"))["document"]
    job = await client.identify(_CAMPAIGN)
    number = await client.finish_job(job)
    now = (await client.get(f"/identifications/{number}"))["document"]
    moved = max(_moved(then, now), default=float("inf"))
    return at_most("largest change of a parameter", moved, _MOST_MOVED, "standard uncertainties")


def _moved(then: dict[str, Any], now: dict[str, Any]) -> list[float]:
    """Return by how much the parameters of both differ, in standard uncertainties."""
    before = {one["name"]: one for one in then["parameters"]}
    return [
        abs(one["value"] - before[one["name"]]["value"]) / one["standard_uncertainty"]
        for one in now["parameters"]
        if one["name"] in before and one["standard_uncertainty"]
    ]
