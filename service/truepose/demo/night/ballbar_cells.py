"""A robot calibrated by the ballbar alone, and judged by the tracker of its cell."""

import asyncio
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from truepose.demo.cell.client import ServiceClient, connected
from truepose.demo.cell.processes import SimulatedService, running_service
from truepose.demo.cell.run import DATABASE, SERVICE_LOG
from truepose.demo.errors import SessionHaltedError
from truepose.demo.night.check import Check, at_most
from truepose.demo.progress import RunProgress

_POSES: Final = 20
_VALIDATION: Final = 60
# The ballbar knows no world frame: errors after the best alignment. Tracker noise is 0.026 of it.
_ALIGNED_MM: Final = 0.035
_DISTANCE_MM: Final = 0.026


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
        return f"{_POSES} poses of the ballbar, {_VALIDATION} validation configurations of the tracker"

    def run(self, folder: Path, progress: RunProgress) -> list[Check]:
        """Measure, identify and judge; raises DemoError."""
        return asyncio.run(self._run(folder, progress))

    async def _run(self, folder: Path, progress: RunProgress) -> list[Check]:
        service = SimulatedService(self.scenario, self.seed, folder / DATABASE, folder / SERVICE_LOG)
        async with running_service(service) as url, connected(url) as client:
            await client.connect_devices()
            with progress.phase("measuring poses with the ballbar"):
                sessions = [await self._ballbar(client)]
            with progress.phase("measuring validation configurations") as told:
                job = await client.plan("validation", "validation", _VALIDATION, self.seed)
                sessions.append(await client.finish_job(job, told))
                await client.run_session(sessions[-1], told)
            campaign = await client.campaign_of("ballbar", sessions)
            with progress.phase("identifying") as told:
                number = await client.finish_job(await client.identify(campaign), told)
                identified = await client.get(f"/identifications/{number}")
            return [_converged(identified), *await _judged(client, identified["model_id"], campaign)]

    async def _ballbar(self, client: ServiceClient) -> int:
        session_id = await client.plan_ballbar("ballbar", _POSES, self.seed)
        ended = await client.person_at(session_id).walk()
        if ended["state"] != "finished":
            raise SessionHaltedError(f"Session {session_id} is {ended['state']}: {ended['reason']}")
        return session_id


def _converged(identified: dict[str, Any]) -> Check:
    status = str(identified["document"]["status"])
    return Check("identification", "converged", status, status == "converged")


async def _judged(client: ServiceClient, model_id: int | None, campaign: int) -> list[Check]:
    if model_id is None:
        return []
    job = await client.validate(model_id, campaign, None)
    number = await client.finish_job(job, lambda done, planned, doing: None)
    document = (await client.get(f"/validations/{number}"))["document"]
    aligned, distance = (document[key]["identified"]["mean_mm"] for key in ("relative", "distance"))
    return [
        at_most("measured error, aligned, mean", aligned, _ALIGNED_MM, "mm"),
        at_most("error of distances, mean", distance, _DISTANCE_MM, "mm"),
    ]
