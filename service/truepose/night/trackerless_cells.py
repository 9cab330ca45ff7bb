"""A robot calibrated by the ballbar or by a closed loop, and judged by the tracker of its cell."""

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from truepose.demo.client import ServiceClient, attend
from truepose.demo.errors import SessionHaltedError
from truepose.demo.processes import opened_cell
from truepose.demo.progress import RunProgress
from truepose.night.check import Check, at_most, convergence_check

VALIDATION: Final = 60  # configurations of the tracker


async def judged_by_tracker(
    client: ServiceClient, session_id: int, seed: int, limit_mm: float, progress: RunProgress
) -> list[Check]:
    """Identify by a session, and judge after the best alignment; `limit_mm` is of the mean error."""
    with progress.phase("measuring validation configurations") as told:
        validation_id = await client.finish_job(
            await client.plan("validation", "validation", VALIDATION, seed), told
        )
        await client.run_session(validation_id, told)
    campaign = await client.campaign_of("night", [session_id, validation_id])
    with progress.phase("identifying") as told:
        number = await client.finish_job(await client.identify(campaign), told)
        identified = await client.get(f"/identifications/{number}")
    checks = [convergence_check(identified["document"])]
    if identified["model_id"] is None:
        return checks
    with progress.phase("validating") as told:
        job = await client.validate(identified["model_id"], campaign, None)
        number = await client.finish_job(job, told)
    document = (await client.get(f"/validations/{number}"))["document"]
    aligned, distance = (document[key]["identified"]["mean_mm"] for key in ("relative", "distance"))
    return [
        *checks,
        at_most("measured error, aligned, mean", aligned, limit_mm, "mm"),
        at_most("error of distances, mean", distance, limit_mm, "mm"),
    ]


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


_STOPS: Final = 60
_AT_GAUGES: Final = (430.0, 0.0, 120.0)
_NORMALS: Final = ((0.8165, 0.0, -0.5774), (-0.4082, 0.7071, -0.5774), (-0.4082, -0.7071, -0.5774))
_DRUMS: Final = ((700.0, -500.0, 0.0), (700.0, 500.0, 0.0), (-300.0, 600.0, 0.0))


def _spheres() -> dict[str, Any]:
    places = ((420.0, -120.0, 80.0), (420.0, 120.0, 80.0))
    sphere = {"kind": "sphere", "zero_mm": 16.0, "zero_u_mm": 0.002}
    return {
        "targets": [{**sphere, "place_mm": place} for place in places],
        "distances": [{"targets": [1, 2], "distance_mm": 240.0, "u_mm": 0.003}],
        "nest": 2,
    }


def _gauges() -> dict[str, Any]:
    targets = [{"kind": "gauge", "place_mm": _AT_GAUGES, "normal": normal} for normal in _NORMALS]
    return {"targets": targets, "nest": 2}


def _wires() -> dict[str, Any]:
    wire = {"kind": "wire", "zero_mm": 700.0, "zero_is_certified": False}
    targets = [{**wire, "place_mm": place} for place in _DRUMS]
    return {"targets": targets, "nest": 2, "stroke_mm": 500.0, "margin_mm": 20.0, "reading_u_mm": 0.02}


# What a session asks for on each shipped cell; errors after the best alignment, 0.026 of them the tracker's.
_LOOPS: Final[Mapping[str, tuple[dict[str, Any], float]]] = MappingProxyType({
    "lrmate-two-spheres": (_spheres(), 0.08),  # 240 mm apart, certified to 0.003
    "lrmate-three-gauges": (_gauges(), 0.05),
    "lrmate-wires": (_wires(), 0.05),
})


@dataclass(frozen=True, slots=True)
class LoopCell:
    """A session of a closed loop; `name` is a shipped scenario."""

    name: str
    seed: int

    @property
    def note(self) -> str:
        """How much of it is measured."""
        return f"{_STOPS} stops at the loop's targets, and validation configurations of the tracker"

    def run(self, folder: Path, progress: RunProgress) -> list[Check]:
        """Measure, identify and judge; raises DemoError."""
        return asyncio.run(self._run(folder, progress))

    async def _run(self, folder: Path, progress: RunProgress) -> list[Check]:
        wanted, limit_mm = _LOOPS[self.name]
        async with opened_cell(self.name, self.seed, folder) as client:
            with progress.phase("measuring the loop"):
                session_id = await self._loop(client, wanted)
            return await judged_by_tracker(client, session_id, self.seed, limit_mm, progress)

    async def _loop(self, client: ServiceClient, wanted: Mapping[str, Any]) -> int:
        session_id = await client.plan_contacts({
            "name": "loop",
            "stops": _STOPS,
            "seed": self.seed,
            **wanted,
        })
        await client.begin(session_id)
        ended = await attend(client, session_id)
        if not ended.finished:
            raise SessionHaltedError(f"Session {session_id} is {ended.session['state']}.")
        return session_id


def loop_cells(seed: int) -> list[LoopCell]:
    """Return the case of every loop that determines the robot."""
    return [LoopCell(name, seed) for name in _LOOPS]
