"""One session after the other, each taken up somewhere, with an operator who errs and a cell that changes."""

import random
import shutil
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from tests.studies.hardening.erring_operator.onlooker import Onlooker
from tests.studies.hardening.erring_operator.operator import ErringOperator
from tests.studies.hardening.erring_operator.tally import Tally
from tests.studies.taken_up.begun import Begun, Copy
from tests.studies.taken_up.onlooked_cell import OnlookedCell, standing
from tests.studies.taken_up.service_here import ServiceHere

_CHANGES = 0.02  # of the deeds: limits of the cell file, or a restart without a change
_FINISHED = 0.1  # of the sessions are walked to their end, with an operator who errs no more after a while
_MOST_DEEDS = 600
_NARROW_DEG = 10.0  # about where the arm stands
_SLOW_MM_S = 50.0


async def run_sessions(
    numbers: Iterable[int], begun: Sequence[Begun], deeds: int, share: float, seed: int, folder: Path
) -> Tally:
    """Run the sessions with these numbers; each draws from a generator of its own."""
    tally = Tally()
    for number in numbers:
        rng = random.Random(f"{seed}/{number}")
        here = folder / f"session-{number}"
        here.mkdir()
        try:
            await _run(tally, rng.choice(begun), deeds, share, rng, here, number)
        finally:
            shutil.rmtree(here)
    return tally


async def _run(
    tally: Tally, begun: Begun, deeds: int, share: float, rng: random.Random, folder: Path, number: int
) -> None:
    copy = _moment(begun, rng)
    shutil.copy(copy.cell, folder / "cell.json")
    shutil.copy(copy.database, folder / "sessions.sqlite3")
    async with standing(begun.scenario, begun.seed, folder / "cell.json") as (cell, addresses):
        service = ServiceHere(folder, begun.scenario, addresses)
        operator = ErringOperator(cell, rng, share)
        onlooker = Onlooker(cell, service, operator, tally.seen, service.lines())
        faults = len(tally.seen.faults)
        try:
            await _start(service, operator)
            finishes = rng.random() < _FINISHED
            for deed in range(_MOST_DEEDS if finishes else deeds):
                if deed == deeds:
                    operator.take_care()
                if deed < deeds and rng.random() < _CHANGES:
                    await _change(cell, service, operator, onlooker, rng)
                onlooker.read_ledger()
                if not await operator.deed():
                    onlooker.read_ledger()
                    onlooker.take_the_end()
                    break
        finally:
            await service.stop()
        onlooker.read_ledger()
        tally.take(operator, service.lines(), cell)
        tally.name_faults(faults, f"session {number}, {begun.scenario} {begun.seed}, {copy.database.stem}")


def _moment(begun: Begun, rng: random.Random) -> Copy:
    """Return a moment before or after the pre-calibration, each half of the time where there are both."""
    kinds = [[c for c in begun.copies if c.precalibrated is wanted] for wanted in (False, True)]
    return rng.choice(rng.choice([kind for kind in kinds if kind]))


async def _start(service: ServiceHere, operator: ErringOperator) -> None:
    await service.start()
    operator.http = service.http
    sessions = (await service.http.get("/api/v1/sessions")).json()
    operator.session_id = sessions[0]["id"]


async def _change(
    cell: OnlookedCell, service: ServiceHere, operator: ErringOperator, onlooker: Onlooker, rng: random.Random
) -> None:
    """Write another cell file and start the service anew, as after an engineer was there."""
    await service.stop()
    own = np.degrees(cell.plant.arm.limits_rad)
    onlooker.limits_deg, onlooker.speed_mm_s = None, None
    section = ""
    if rng.random() < 0.6:
        stands = np.degrees(cell.robot.target_rad)[:, np.newaxis]
        narrow = np.clip(stands + np.array([-_NARROW_DEG, _NARROW_DEG]), own[:, :1], own[:, 1:])
        onlooker.limits_deg, onlooker.speed_mm_s = narrow, _SLOW_MM_S
        section = f"[limits]\njoints_deg = {narrow.round(3).tolist()}\ntool_speed_mm_s = {_SLOW_MM_S}\n"
    service.describe(section)
    await _start(service, operator)
