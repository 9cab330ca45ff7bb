"""A robot calibrated by the ballbar or by a closed loop, and judged by the tracker of its cell."""

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

from truepose.demo.client import ServiceClient, attend
from truepose.demo.errors import SessionHaltedError
from truepose.demo.processes import opened_cell
from truepose.demo.progress import RunProgress
from truepose.night.check import Check, at_most, convergence_check

VALIDATION: Final = 60  # configurations of the tracker


@dataclass(frozen=True, slots=True)
class TrackerlessCell:
    """A robot measured without the tracker of its cell, which judges it afterwards."""

    name: str  # as the night calls it
    scenario: str  # shipped
    seed: int
    limit_mm: float  # of the mean error after the best alignment; the tracker's noise is 0.026 of it
    note: str
    doing: str
    measure: Callable[[ServiceClient, int], Awaitable[int]]  # with the seed; returns the session's number

    def run(self, folder: Path, progress: RunProgress) -> list[Check]:
        """Measure, identify and judge; raises DemoError."""
        return asyncio.run(self._run(folder, progress))

    async def _run(self, folder: Path, progress: RunProgress) -> list[Check]:
        async with opened_cell(self.scenario, self.seed, folder) as client:
            with progress.phase(self.doing):
                session_id = await self.measure(client, self.seed)
            return await self._judged(client, session_id, progress)

    async def _judged(self, client: ServiceClient, session_id: int, progress: RunProgress) -> list[Check]:
        with progress.phase("measuring validation configurations") as told:
            job = await client.plan("validation", "validation", VALIDATION, self.seed)
            validation_id = await client.finish_job(job, told)
            await client.run_session(validation_id, told)
        campaign = await client.campaign_of("night", [session_id, validation_id])
        with progress.phase("identifying") as told:
            identified = await client.result_of(await client.identify(campaign), "identifications", told)
        checks = [convergence_check(identified["document"])]
        if identified["model_id"] is None:
            return checks
        with progress.phase("validating") as told:
            job = await client.validate(identified["model_id"], campaign, None)
            document = (await client.result_of(job, "validations", told))["document"]
        aligned, distance = (document[key]["identified"]["mean_mm"] for key in ("relative", "distance"))
        return [
            *checks,
            at_most("measured error, aligned, mean", aligned, self.limit_mm, "mm"),
            at_most("distance error, mean", distance, self.limit_mm, "mm"),
        ]


_POSES: Final = 20
_BALLBAR_MM: Final = 0.035


def ballbar_cells(seed: int) -> list[TrackerlessCell]:
    """Return the case of each robot that is measured by the ballbar, with the simulated hands."""
    note = f"{_POSES} ballbar poses, {VALIDATION} tracker validation configurations"
    doing = "measuring poses with the ballbar"
    return [
        TrackerlessCell(f"{name}-ballbar", name, seed, _BALLBAR_MM, note, doing, _by_ballbar)
        for name in ("irb120-tilted", "lrmate-tilted")
    ]


async def _by_ballbar(client: ServiceClient, seed: int) -> int:
    session_id = await client.plan_ballbar("ballbar", _POSES, seed)
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


# What a session asks for on each shipped cell, and the limit of its errors.
_LOOPS: Final[Mapping[str, tuple[dict[str, Any], float]]] = MappingProxyType({
    "lrmate-two-spheres": (_spheres(), 0.08),  # 240 mm apart, certified to 0.003
    "lrmate-three-gauges": (_gauges(), 0.05),
    "lrmate-wires": (_wires(), 0.05),
})


def loop_cells(seed: int) -> list[TrackerlessCell]:
    """Return the case of every loop that determines the robot."""
    note = f"{_STOPS} configurations at the loop's targets, and tracker validation configurations"
    doing = "measuring the closed loop"
    return [
        TrackerlessCell(name, name, seed, limit_mm, note, doing, partial(_by_loop, wanted))
        for name, (wanted, limit_mm) in _LOOPS.items()
    ]


async def _by_loop(wanted: Mapping[str, Any], client: ServiceClient, seed: int) -> int:
    session_id = await client.plan_contacts({"name": "loop", "stops": _STOPS, "seed": seed, **wanted})
    await client.begin(session_id)
    ended = await attend(client, session_id)
    if not ended.finished:
        raise SessionHaltedError(f"Session {session_id} is {ended.session['state']}.")
    return session_id
