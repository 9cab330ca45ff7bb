"""The service is killed in the middle of a session, again and again, and goes on where it was."""

import asyncio
from collections.abc import Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np

from truepose.demo.cell.client import ServiceClient
from truepose.demo.cell.opened import DATABASE, opened_cell
from truepose.demo.night.attended import attend
from truepose.demo.night.check import Check, none_of
from truepose.demo.progress import RunProgress
from truepose.storage.integrity.verification import verify

_CONFIGURATIONS: Final = 25
_STILL_S: Final = 0.5  # for which a service that came back is watched to do nothing by itself
_WITHIN_S: Final = 0.05  # of the moment of a kill after a configuration was measured: a stop takes as long

Reading: TypeAlias = dict[str, Any]


@dataclass(frozen=True, slots=True)
class KilledService:
    """A calibration whose service is killed at moments that the night's seed draws."""

    seed: int
    kills: int = 5
    name: str = "killed-service"

    @property
    def note(self) -> str:
        """What is tried."""
        return f"The service is killed {self.kills} times while it measures {_CONFIGURATIONS} configurations"

    def run(self, folder: Path, progress: RunProgress) -> list[Check]:
        """Kill and look; raises DemoError."""
        return asyncio.run(self._run(folder, progress))

    async def _run(self, folder: Path, progress: RunProgress) -> list[Check]:
        rng = np.random.default_rng(self.seed)
        lives = _Lives(self.seed, folder)
        async with lives.life() as client:
            job = await client.plan("killed", "calibration", _CONFIGURATIONS, self.seed)
            session_id = await client.finish_job(job)
        for measured in np.sort(rng.choice(_CONFIGURATIONS - 1, self.kills, replace=False)):
            progress.doing = f"killing the service after {measured} configurations"
            async with lives.life(killed=True) as client:
                await lives.work(client, session_id, int(measured), float(rng.uniform(0.0, _WITHIN_S)))
        async with lives.life() as client:
            await lives.finish(client, session_id)
        return [*lives.checks(), none_of("broken links of the chain", verify(folder / DATABASE).findings)]


class _Lives:
    """A service through its lives, and what was wrong between them."""

    def __init__(self, seed: int, folder: Path) -> None:
        self._seed, self._folder = seed, folder
        self._known: list[Reading] = []
        self._lost: list[str] = []
        self._moved: list[str] = []
        self._ended: dict[str, Any] = {}

    def life(self, *, killed: bool = False) -> AbstractAsyncContextManager[ServiceClient]:
        """Return the service on its database, until it is ended."""
        return opened_cell("irb120-clean", self._seed, self._folder, killed=killed)

    async def work(self, client: ServiceClient, session_id: int, measured: int, more_s: float) -> None:
        """Take the session up, let it measure, and remember what it acknowledged."""
        await self._taken_up(client, session_id)
        await attend(client, session_id, lambda done: done > measured)
        await asyncio.sleep(more_s)
        self._known = await client.readings(session_id)

    async def finish(self, client: ServiceClient, session_id: int) -> None:
        """Take the session up for the last time."""
        await self._taken_up(client, session_id)
        self._ended = (await attend(client, session_id)).session
        self._compare(await client.readings(session_id))
        self._known = await client.readings(session_id)

    async def _taken_up(self, client: ServiceClient, session_id: int) -> None:
        """See that nothing is lost, and that nothing begins by itself."""
        before = await client.readings(session_id)
        self._compare(before)
        await asyncio.sleep(_STILL_S)
        state = (await client.get(f"/sessions/{session_id}"))["state"]
        if len(await client.readings(session_id)) > len(before) or state == "running":
            self._moved.append(f"after {len(before)} readings the session was {state}")
        if state == "planned":
            await client.begin(session_id)

    def _compare(self, now: Sequence[Reading]) -> None:
        by_id = {reading["id"]: reading for reading in now}
        for reading in self._known:
            if by_id.get(reading["id"]) != reading:
                self._lost.append(f"reading {reading['id']} of nest {reading['nest']}")

    def checks(self) -> list[Check]:
        """Return what was seen."""
        done = f"{self._ended['measured']} measured, {self._ended['skipped']} skipped"
        planned = int(self._ended["planned"])
        return [
            none_of("acknowledged readings lost or changed", self._lost),
            none_of("configurations measured twice", self._twice()),
            none_of("restarts after which something moved by itself", self._moved),
            Check("configurations", f"{planned} measured", done, int(self._ended["measured"]) == planned),
        ]

    def _twice(self) -> list[str]:
        counting = [r["point"]["config"] for r in self._known if r["point"] and r["superseded_by"] is None]
        return [f"configuration {one}" for one in sorted(set(counting)) if counting.count(one) > 1]
