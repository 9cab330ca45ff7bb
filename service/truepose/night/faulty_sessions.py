"""Sessions in which much goes wrong, as the night's seed draws it: they end, and nothing false is kept.

What may go wrong, and when, is a scenario's `[[fault]]` tables (docs/faults.md); somebody looks after the
session as a person would: looks at the cell, confirms, goes on. Or the service is killed in the middle of a
session, again and again, and goes on where it was.
"""

import asyncio
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np

from truepose.demo.client import Attendance, ServiceClient, attend
from truepose.demo.processes import DATABASE, opened_cell
from truepose.demo.progress import RunProgress
from truepose.demo.truth import cell_endpoint
from truepose.domain.arrays import FloatArray
from truepose.exchange.cells.file import scenario_text
from truepose.night.check import Check, at_most, none_of
from truepose.storage.integrity.verification import verify

_KILLED_CONFIGURATIONS: Final = 25
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
        count = _KILLED_CONFIGURATIONS
        return f"The service is killed {self.kills} times while it measures {count} configurations"

    def run(self, folder: Path, progress: RunProgress) -> list[Check]:
        """Kill and look; raises DemoError."""
        return asyncio.run(self._run(folder, progress))

    async def _run(self, folder: Path, progress: RunProgress) -> list[Check]:
        rng = np.random.default_rng(self.seed)
        lives = _Lives(self.seed, folder)
        async with lives.life() as client:
            job = await client.plan("killed", "calibration", _KILLED_CONFIGURATIONS, self.seed)
            session_id = await client.finish_job(job)
        for measured in np.sort(rng.choice(_KILLED_CONFIGURATIONS - 1, self.kills, replace=False)):
            progress.doing = f"killing the service after {measured} configurations"
            async with lives.life(killed=True) as client:
                await lives.work(client, session_id, int(measured), float(rng.uniform(0.0, _WITHIN_S)))
        async with lives.life() as client:
            await lives.finish(client, session_id)
        return [
            *lives.checks(),
            none_of("broken links of the hash chain", verify(folder / DATABASE).findings),
        ]


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
            _measured_twice([one for one in self._known if _counts(one)]),
            none_of("restarts followed by unrequested motion", self._moved),
            Check("configurations", f"{planned} measured", done, int(self._ended["measured"]) == planned),
        ]


def _counts(reading: Mapping[str, Any]) -> bool:
    return reading["point"] is not None and reading["superseded_by"] is None


def _measured_twice(readings: Sequence[Mapping[str, Any]]) -> Check:
    """Return the check that no configuration has more than one of the readings that count."""
    measured = Counter(reading["point"]["config"] for reading in readings)
    twice = [f"configuration {config}" for config, count in sorted(measured.items()) if count > 1]
    return none_of("configurations measured twice", twice)


_CONFIGURATIONS: Final = 30
_FAULTS: Final = 8
# Ten standard deviations of the tracker at its distance: what is farther off is no reading of that stop.
_FALSE_MM: Final = 0.2
_LONGEST_S: Final = 600.0

Keys = Mapping[str, Any]
_Draw = Callable[[np.random.Generator], Keys]


def _strikes(kind: str, most: int = 1) -> _Draw:
    return lambda rng: {"kind": kind, "count": int(rng.integers(1, most + 1))}


def _lasts(kind: str, **keys: Any) -> _Draw:
    return lambda rng: {"kind": kind, **keys, "for_s": round(float(rng.uniform(1.0, 8.0)), 1)}


def _stops(kind: str) -> _Draw:
    return lambda rng: {**_lasts(kind)(rng), "after_s": round(float(rng.uniform(0.05, 0.8)), 2)}


_KINDS: Final[Sequence[_Draw]] = (
    _strikes("beam_broken", 3),
    _strikes("tracker_silent"),
    _strikes("tracker_cut"),
    _strikes("tracker_repeats_result", 2),
    _strikes("tracker_stale_result"),
    _strikes("tracker_units_changed"),
    _lasts("link_cut", device="tracker"),
    _lasts("link_cut", device="robot"),
    _lasts("link_half_open", device="tracker"),
    _lasts("link_half_open", device="robot"),
    _lasts("tracker_blinded"),
    _lasts("temperature_step", by_k=-3.0),
    _strikes("robot_refuses"),
    _stops("emergency_stop"),
    _stops("protective_stop"),
)


@dataclass(frozen=True, slots=True)
class FaultySession:
    """A tracker session on a cell with faults; `scenario` is shipped."""

    scenario: str
    seed: int

    @property
    def name(self) -> str:
        """As the night calls it: the robot is the first word, as of every scenario."""
        return f"{self.scenario}-faulty"

    @property
    def note(self) -> str:
        """What goes wrong, in its order."""
        return f"{_CONFIGURATIONS} configurations, with " + ", ".join(
            f"{fault['kind'].replace('_', ' ')} at {fault['configuration']}" for fault in self.faults()
        )

    def faults(self) -> list[Keys]:
        """Return what goes wrong, the first first."""
        rng = np.random.default_rng((self.seed, *self.scenario.encode()))
        at = np.sort(rng.choice(np.arange(2, _CONFIGURATIONS), _FAULTS, replace=False))
        drawn = rng.choice(len(_KINDS), _FAULTS, replace=False)
        return [
            {**_KINDS[kind](rng), "configuration": int(number)}
            for kind, number in zip(drawn, at, strict=True)
        ]

    def run(self, folder: Path, progress: RunProgress) -> list[Check]:
        """Measure, with somebody beside it; raises DemoError."""
        scenario = folder / f"{self.name}.toml"
        scenario.write_text(scenario_text(self.scenario, "fault", self.faults()), encoding="utf-8")
        return asyncio.run(self._run(scenario, folder, progress))

    async def _run(self, scenario: Path, folder: Path, progress: RunProgress) -> list[Check]:
        async with opened_cell(str(scenario), self.seed, folder) as client:
            with progress.phase("choosing configurations") as told:
                job = await client.plan("faulty", "validation", _CONFIGURATIONS, self.seed)
                session_id = await client.finish_job(job, told)
            with progress.phase("measuring with faults"):
                await client.begin(session_id)
                seen = await _ended(client, session_id)
            session = await client.get(f"/sessions/{session_id}")
            counting = [one for one in await client.readings(session_id) if _counts(one)]
            return _checks(seen, session, counting, await _errors_mm(client, counting))


async def _ended(client: ServiceClient, session_id: int) -> Attendance:
    async with asyncio.timeout(_LONGEST_S):
        return await attend(client, session_id)


async def _errors_mm(client: ServiceClient, readings: Sequence[Mapping[str, Any]]) -> FloatArray:
    """Return how far readings are from what was true of their stops, shape (n,)."""
    (cell,) = await client.get("/cells")
    (truth,) = [entry for entry in cell["endpoints"] if entry["device"] == "truth"]
    async with cell_endpoint(truth["host"], truth["port"]) as endpoint:
        true = await endpoint.ask(
            "positions",
            joints_rad=np.radians([one["point"]["commanded_deg"] for one in readings]).tolist(),
            nests=[one["nest"] for one in readings],
            time_s=[one["time_s"] for one in readings],
        )
    read = np.array([one["position_world_mm"] for one in readings])
    errors: FloatArray = np.linalg.norm(read - np.array(true["positions_mm"]), axis=1)
    return errors


def _checks(
    seen: Attendance,
    session: Mapping[str, Any],
    readings: Sequence[Mapping[str, Any]],
    errors_mm: FloatArray,
) -> list[Check]:
    configurations = [one["point"]["config"] for one in readings]
    left_out = {one["config"]: one["reason"] for one in session["skipped_stops"]}
    unknown = sorted(set(range(1, session["planned"] + 1)) - {*configurations, *left_out})
    silent = [f"configuration {config}" for config, reason in left_out.items() if not reason]
    largest = float(errors_mm.max(initial=0.0))
    state = f"{seen.session['state']}, operator prompted {len(seen.reasons)} times"
    return [
        at_most("largest error of an accepted reading", largest, _FALSE_MM, "mm", 3),
        none_of("configurations neither measured nor skipped", [f"configuration {n}" for n in unknown]),
        _measured_twice(readings),
        none_of("configurations skipped without a reason", silent),
        at_most("configurations skipped", len(left_out), _FAULTS, "of 30", 0),
        Check("session", "finished", state, seen.finished),
    ]
