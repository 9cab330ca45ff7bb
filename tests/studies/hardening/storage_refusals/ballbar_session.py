"""A ballbar session whose database refuses: the service is a process, the cell stands here, hands over REST.

The session is taken up from a copy, brought to a moment, and goes on while the fault lasts. The operator
sends an act that is refused again with the same key. At the end the service is killed, and what it
acknowledged must be on the disk.
"""

import asyncio
import contextlib
import shutil
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

import httpx

from tests.studies.hardening.storage_refusals.outcome import TOO_LATE, Outcome
from tests.studies.hardening.storage_refusals.trouble import FAULTS, lasts_s
from tests.studies.interruptions.killed_service import KilledService
from tests.studies.interruptions.ledger_check import faults
from tests.studies.taken_up.begun import Begun, Copy
from tests.studies.taken_up.cell_text import cell_text
from tests.studies.taken_up.ledger_on_disk import lines
from tests.studies.taken_up.onlooked_cell import OnlookedCell, standing
from truepose.demo.errors import DemoError
from truepose.demo.simulated_operator import Session, SimulatedOperator, present_step
from truepose.storage.integrity.verification import verify_left

_ANSWER_S = 60.0
_PATIENCE_S = 900.0  # for a session, on a busy machine
_STEPS = 6  # at most, until the moment is looked for
_HEALTH_S = 0.2
_LAST = 3  # copies from which a session has ended before much can happen


@dataclass
class _Scene:
    """One session, and the fault that is to come."""

    person: SimulatedOperator
    cell: OnlookedCell
    http: httpx.AsyncClient
    file: Path
    pid: int
    outcome: Outcome
    rng: Random
    began: asyncio.Event = field(default_factory=asyncio.Event)
    until: contextlib.ExitStack = field(default_factory=contextlib.ExitStack)

    def refuse(self) -> None:
        """Have the database refuse from now on."""
        if not self.began.is_set():
            self.until.enter_context(FAULTS[self.outcome.fault](self.file, self.pid))
            self.began.set()

    async def refuse_for_a_while(self) -> None:
        """Let the fault last from its begin on, and look what the service says meanwhile."""
        await self.began.wait()
        with self.until, contextlib.suppress(TimeoutError):
            async with asyncio.timeout(self.outcome.lasted_s):
                while True:
                    health = (await self.http.get("/health")).json()
                    self.outcome.told = self.outcome.told or health["status"] != "ok"
                    await asyncio.sleep(_HEALTH_S)


Moment = Callable[[_Scene], Awaitable[object]]


# each brings a session to a moment, and does what belongs to it


async def _at_a_prompt(scene: _Scene) -> None:
    await scene.person.walk_until(_runs_on(scene.rng.randrange(_STEPS)))
    scene.refuse()


async def _at_the_pre_calibration(scene: _Scene) -> None:
    await scene.person.walk_until(lambda session: _kind(session) == "precalibrate" and _runs(session))
    scene.refuse()


async def _in_a_motion(scene: _Scene) -> None:
    scene.cell.on_motion = lambda waypoints, limits: scene.refuse()
    await scene.person.walk_until(lambda session: scene.began.is_set())


def _act_in_a_motion(name: str) -> Moment:
    async def moment(scene: _Scene) -> None:
        async with asyncio.TaskGroup() as acting:

            def refuse(*_: object) -> None:
                if not scene.began.is_set():
                    scene.refuse()
                    acting.create_task(scene.person.act(name))

            scene.cell.on_motion = refuse
            await scene.person.walk_until(lambda session: scene.began.is_set())

    return moment


def _act(name: str) -> Moment:
    async def moment(scene: _Scene) -> None:
        await _at_a_prompt(scene)
        await scene.person.act(name)

    return moment


async def _at_a_resumption(scene: _Scene) -> None:
    await scene.person.walk_until(_runs_on(scene.rng.randrange(_STEPS)))
    await scene.person.act("pause")
    scene.refuse()
    await scene.person.act("resume")


MOMENTS: Mapping[str, Moment] = {
    "in a motion": _in_a_motion,
    "a prompt is open": _at_a_prompt,
    "a pause": _act("pause"),
    "a pause in a motion": _act_in_a_motion("pause"),
    "a resumption": _at_a_resumption,
    "a stop": _act("stop"),
    "an end": _act("abort"),
    "an end in a motion": _act_in_a_motion("abort"),
    "the pre-calibration": _at_the_pre_calibration,
}


def _kind(session: Session) -> str | None:
    return None if session["step"] is None else str(session["step"]["kind"])


def _runs(session: Session) -> bool:
    return session["state"] == "running"


def _runs_on(steps: int) -> Callable[[Session], bool]:
    """Return what says whether a session has gone on by so many steps, and runs."""
    seen: set[str | None] = set()

    def reached(session: Session) -> bool:
        if _runs(session):
            seen.add(present_step(session))
        return _runs(session) and len(seen) > steps

    return reached


async def ballbar_session(
    folder: Path,
    begun: Begun,
    fault: str,
    moment: str,
    rng: Random,
    lock_s: float,
    further: int | None = None,
) -> Outcome:
    """Take up a session, have its database refuse at a moment, and see what becomes of it.

    It is followed to its end, or over so many steps `further`.
    """
    outcome = Outcome("ballbar", fault, moment, lasts_s(fault, rng, lock_s))
    copy = _copy_before(begun, moment, rng)
    before = _entries(copy.database)
    shutil.copy(copy.cell, folder / "cell.json")
    shutil.copy(copy.database, folder / "sessions.sqlite3")
    async with _taken_up(folder, begun, outcome, rng) as scene:
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(_PATIENCE_S):
                await _walk(scene, further)
    _judge(scene, before)
    return outcome


def _copy_before(begun: Begun, moment: str, rng: Random) -> Copy:
    """Return a copy; of those before the pre-calibration the last one, where that is the moment."""
    if moment == "the pre-calibration":
        return [copy for copy in begun.copies if not copy.precalibrated][-1]
    return rng.choice(begun.copies[:-_LAST] or begun.copies)


@contextlib.asynccontextmanager
async def _taken_up(folder: Path, begun: Begun, outcome: Outcome, rng: Random) -> AsyncIterator[_Scene]:
    async with standing(begun.scenario, begun.seed, folder / "cell.json") as (cell, addresses):
        (folder / "cell.toml").write_text(cell_text(begun.scenario, addresses), encoding="utf-8")
        file = folder / "sessions.sqlite3"
        service = KilledService(folder / "cell.toml", file, folder / "service.log")
        await service.start()
        try:
            async with httpx.AsyncClient(base_url=service.url, timeout=_ANSWER_S, trust_env=False) as http:
                session_id = (await http.get("/api/v1/sessions")).json()[0]["id"]
                person = SimulatedOperator(http, session_id, "tablet-2")  # other keys than those of the copy
                await person.act("hand_over")
                yield _Scene(person, cell, http, file, service.pid, outcome, rng)
        finally:
            await service.kill()


async def _walk(scene: _Scene, further: int | None) -> None:
    lasting = asyncio.create_task(scene.refuse_for_a_while())
    try:
        await MOMENTS[scene.outcome.moment](scene)
        if not scene.began.is_set():
            scene.outcome.moment = TOO_LATE
            scene.refuse()
        reached = _runs_on(further) if further is not None else lambda session: False
        session = await scene.person.walk_until(reached)
        await lasting
    except (DemoError, httpx.TransportError) as error:
        scene.outcome.state = repr(error)
        return
    finally:
        lasting.cancel()
        scene.until.close()
    scene.outcome.state = session["state"]
    ends = {"finished", "aborted"} if scene.outcome.moment.startswith("an end") else {"finished"}
    scene.outcome.came_to_its_end = session["state"] in ends or reached(session)


def _judge(scene: _Scene, before: list[dict[str, Any]]) -> None:
    outcome, own = scene.outcome, scene.person.ledger
    found = faults(own, before, _entries(scene.file))
    outcome.wrong = [*found.lost, *found.doubled, *found.moved, *verify_left(scene.file).findings]
    outcome.kept = sum(act.entry is not None for act in own.acts)
    outcome.repeated = own.repeated


def _entries(database: Path) -> list[dict[str, Any]]:
    """Return the ledger as the check has it."""
    return [{**line, "text": line["document"].get("entered") or ""} for line in lines(database)]
