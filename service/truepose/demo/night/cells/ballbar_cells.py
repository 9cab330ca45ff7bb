"""A robot calibrated by the ballbar alone, and judged by the tracker of its cell."""

import asyncio
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from truepose.demo.cell.client import ServiceClient
from truepose.demo.cell.opened import opened_cell
from truepose.demo.errors import SessionHaltedError
from truepose.demo.night.cells.judged_session import VALIDATION, judged_by_tracker
from truepose.demo.night.check import Check
from truepose.demo.progress import RunProgress

_POSES: Final = 20
# The ballbar knows no world frame: errors after the best alignment. Tracker noise is 0.026 of it.
_ALIGNED_MM: Final = 0.035


@dataclass(frozen=True, slots=True)
class BallbarCell:
    """A ballbar session with the simulated hands; `scenario` is shipped."""

    scenario: str
    seed: int

    @property
    def name(self) -> str:
        """As the night calls it."""
        return f"{self.scenario}-ballbar"

    @property
    def note(self) -> str:
        """How much of it is measured."""
        return f"{_POSES} poses of the ballbar, {VALIDATION} validation configurations of the tracker"

    def run(self, folder: Path, progress: RunProgress) -> list[Check]:
        """Measure, identify and judge; raises DemoError."""
        return asyncio.run(self._run(folder, progress))

    async def _run(self, folder: Path, progress: RunProgress) -> list[Check]:
        async with opened_cell(self.scenario, self.seed, folder) as client:
            with progress.phase("measuring poses with the ballbar"):
                session_id = await self._ballbar(client)
            return await judged_by_tracker(client, session_id, self.seed, _ALIGNED_MM, progress)

    async def _ballbar(self, client: ServiceClient) -> int:
        session_id = await client.plan_ballbar("ballbar", _POSES, self.seed)
        ended = await client.person_at(session_id).walk()
        if ended["state"] != "finished":
            raise SessionHaltedError(f"Session {session_id} is {ended['state']}: {ended['reason']}")
        return session_id
