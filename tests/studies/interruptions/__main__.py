"""The service is killed at random moments of a ballbar session; a person with a ledger of their own goes on.

    python -m tests.studies.interruptions --kills 200 --out out/interruptions

Each kill is a SIGKILL to the service and its workers. It is started again; the person repeats the request
that got no answer, with its key. After each start: no acknowledged entry is missing, none is doubled, the
step is the one that was shown, and nothing has moved without a confirmation.
"""

import asyncio
import contextlib
import json
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Final, TypeAlias

import httpx
import numpy as np

from tests.studies.interruptions.killed_service import KilledService, standing_cell
from tests.studies.interruptions.ledger_check import Entry, Faults, faults
from tests.studies.running import study_parser
from truepose.demo.simulated_operator import SimulatedOperator

_ALIVE_S: Final = (0.02, 2.0)  # how long the service lives between a start and a kill
_PAGE: Final = 1000
_ANSWER_S: Final = 900.0  # choosing the poses of a session takes half a minute, on a busy machine many
Shown: TypeAlias = dict[str, Any]  # a session as the service shows it
_ENDED: Final = frozenset({"finished", "aborted", "failed"})
_STAY: Final = frozenset({"control", "shown"})  # entries that end no step


@dataclass(slots=True)
class Tally:
    """What was seen."""

    kills: int = 0
    sessions: int = 0
    acknowledged: int = 0
    repeated: int = 0
    entries: int = 0
    lost: list[str] = field(default_factory=list)
    doubled: list[str] = field(default_factory=list)
    moved: list[str] = field(default_factory=list)
    other_step: list[str] = field(default_factory=list)
    not_awaiting: list[str] = field(default_factory=list)
    ready_s: list[float] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether something was tried, and nothing was wrong."""
        return self.kills > 0 and not (
            self.lost or self.doubled or self.moved or self.other_step or self.not_awaiting
        )

    def add(self, found: Faults) -> None:
        """Take what a check found; each sentence once."""
        for kept, new in ((self.lost, found.lost), (self.doubled, found.doubled), (self.moved, found.moved)):
            kept.extend(sentence for sentence in new if sentence not in kept)


async def interrupt(
    tally: Tally,
    kills: int,
    seed: int,
    folder: Path,
    wanted: Mapping[str, Any],
    scenario: str = "lrmate-tilted",
    database: str | None = None,
) -> None:
    """Kill the service `kills` times in sessions as `wanted`, as REST takes it.

    The records are in a file of the folder, or in `database`. What was seen is in `tally`, also where
    something breaks the run.
    """
    rng = np.random.default_rng(seed)
    async with standing_cell(scenario, seed, 0, folder / "cell.log") as cell_file:
        (folder / "cell.toml").write_text(cell_file, encoding="utf-8")
        url = database or f"sqlite:///{folder / 'sessions.sqlite3'}"
        service = KilledService(folder / "cell.toml", url, folder / "service.log")
        await service.start()
        try:
            async with httpx.AsyncClient(base_url=service.url, timeout=_ANSWER_S, trust_env=False) as http:
                while tally.kills < kills:
                    await _Session(http, service, tally, rng).run(kills, wanted, seed)
        finally:
            await service.kill()


class _Session:
    """One session, interrupted until it has ended or enough was seen."""

    def __init__(
        self, http: httpx.AsyncClient, service: KilledService, tally: Tally, rng: np.random.Generator
    ) -> None:
        self._http = http
        self._service = service
        self._tally = tally
        self._rng = rng

    async def run(self, kills: int, wanted: Mapping[str, Any], seed: int) -> None:
        session = {"name": "interrupted", "seed": seed + self._tally.sessions, **wanted}
        created = await self._http.post("/api/v1/sessions", json={"kind": "ballbar", **session})
        created.raise_for_status()
        self._tally.sessions += 1
        person = SimulatedOperator(self._http, created.json()["id"], f"tablet-{self._tally.sessions}")
        walking = asyncio.create_task(person.walk())
        before: list[Entry] = []
        try:
            while self._tally.kills < kills and not walking.done():
                await asyncio.wait({walking}, timeout=float(self._rng.uniform(*_ALIVE_S)))
                before = await self._interrupted(person, before)
        finally:
            await _ended(walking)
            self._tally.acknowledged += len(person.ledger.acts)
            self._tally.repeated += person.ledger.repeated
            self._tally.entries += len(before)
        await person.act("abort")

    async def _interrupted(self, person: SimulatedOperator, before: Sequence[Entry]) -> list[Entry]:
        """Kill the service, start it again, and check what it says; returns its ledger."""
        person.hands_free.clear()
        await self._service.kill()
        self._tally.kills += 1
        self._tally.ready_s.append(await self._service.start())
        now = (await self._http.get(f"{person.path}/situation")).json()
        after = await self._entries(person.path)
        self._tally.add(faults(person.ledger, before, after))
        self._judge_restart(person.seen, now, after)
        person.hands_free.set()
        return after

    async def _entries(self, path: str) -> list[Entry]:
        found: list[Entry] = []
        while True:
            last = found[-1]["number"] if found else 0
            page = await self._http.get(f"{path}/ledger", params={"after": last, "limit": _PAGE})
            entries = page.json()["entries"]
            found += entries
            if len(entries) < _PAGE:
                return found

    def _judge_restart(self, seen: Shown | None, now: Shown, after: Sequence[Entry]) -> None:
        """Check that the session awaits a person, at the step that was shown unless an entry ended that."""
        if now["state"] not in {"planned", "awaiting_confirmation", *_ENDED}:
            self._tally.not_awaiting.append(f"After kill {self._tally.kills} the session is {now['state']}.")
        if seen is None or seen["step"] is None or now["step"] is None:
            return
        unseen = [e for e in after if e["number"] > (seen["ledger_number"] or 0) and e["kind"] not in _STAY]
        if not unseen and seen["step"]["id"] != now["step"]["id"]:
            step_ids = f"{seen['step']['id']} before and {now['step']['id']} after"
            self._tally.other_step.append(f"At kill {self._tally.kills} the step was {step_ids}.")


async def _ended(task: "asyncio.Task[Any]") -> None:
    if not task.done():
        task.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await task


def report(tally: Tally) -> dict[str, Any]:
    """Return the tally as a document."""
    ready_s = sorted(tally.ready_s)
    quantiles = None
    if ready_s:
        median, p95 = (float(q) for q in np.quantile(ready_s, [0.5, 0.95]))
        quantiles = {"median": median, "p95": p95, "max": ready_s[-1]}
    return {**asdict(tally), "ready_s": quantiles, "pass": tally.passed}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run from the command line; exit status 1 where anything was lost, doubled or moved."""
    parser = study_parser(__doc__, kills=200, seed=0, poses=20, scenario="lrmate-tilted")
    parser.add_argument("--database", help="URL; by default a file in the folder")
    parser.add_argument("--out", type=Path, help="folder for interruptions.json, the database and the logs")
    wanted = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory(prefix="truepose-") as temporary:
        folder = Path(temporary) if wanted.out is None else wanted.out
        folder.mkdir(parents=True, exist_ok=True)
        tally = Tally()
        try:
            session = {"poses": wanted.poses}
            asyncio.run(
                interrupt(tally, wanted.kills, wanted.seed, folder, session, wanted.scenario, wanted.database)
            )
        finally:
            text = json.dumps(report(tally), indent=1)
            (folder / "interruptions.json").write_text(text + "\n", encoding="utf-8")
            sys.stdout.write(text + "\n")
    return 0 if tally.passed else 1


if __name__ == "__main__":
    sys.exit(main())
