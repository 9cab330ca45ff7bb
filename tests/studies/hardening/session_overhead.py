"""What a session costs beside its devices.

`python -m tests.studies.hardening.session_overhead --out DIR [--runs N]`: a tracker session on devices in
memory, which answer at once, with the ledger of the service on a real disk. The time within the devices is
taken off, and what a session costs at its beginning and end: it is the difference of two lengths.
"""

import asyncio
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any, Final, NamedTuple

import numpy as np

from tests.helpers.ballbar.cells import domain_cell
from tests.studies.running import from_command_line
from tests.unit.service.sessions.tracker.fakes import FakeCell, make_plan
from tests.unit.service.sessions.tracker.operators import PatientOperator
from truepose.domain.session import SessionPlan, SessionState
from truepose.sessions.tracker.runner import TrackerRunner
from truepose.storage.database import Database
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.records import SessionSetup

_SHORT: Final = 10
_ASKED: Final = {
    "robot": ("read_joints", "move_joints"),
    "tracker": ("find_reflector", "measure_point", "environment", "change_face"),
    "clock": ("now_s", "sleep"),
}


class Cost(NamedTuple):
    """Of one session."""

    wall_s: float
    cpu_s: float
    devices_s: float
    lines: float


class Stopwatch:
    """Adds up what is spent within the devices."""

    def __init__(self) -> None:
        self.spent_s = 0.0

    def around(self, ask: Callable[..., Awaitable[Any]]) -> Callable[..., Awaitable[Any]]:
        """Return what asks the device and takes the time."""

        async def timed(*arguments: Any, **named: Any) -> Any:
            begun_s = time.perf_counter()
            try:
                return await ask(*arguments, **named)
            finally:
                self.spent_s += time.perf_counter() - begun_s

        return timed


def _watched(cell: FakeCell) -> Stopwatch:
    watch = Stopwatch()
    for device, members in _ASKED.items():
        for member in members:
            part = getattr(cell, device)
            setattr(part, member, watch.around(getattr(part, member)))
    return watch


async def session_cost(plan: SessionPlan, folder: Path) -> Cost:
    """Run a session and return what it cost."""
    database = Database(f"sqlite:///{folder / f'{len(plan.stops)}-{time.monotonic_ns()}.sqlite3'}")
    try:
        session_id = await SessionRepository(database).add("overhead", SessionSetup(domain_cell()), plan)
        ledger = await LedgerRepository(database).of_session(session_id)
        cell = FakeCell()
        watch = _watched(cell)
        runner = TrackerRunner(plan, cell.cell, ledger)
        operator = PatientOperator(look_s=0.02)
        begun_s, cpu_s = time.perf_counter(), time.process_time()
        ended = await operator.attend(runner, asyncio.create_task(runner.run()))
        spent = time.perf_counter() - begun_s, time.process_time() - cpu_s
        lines = len(await LedgerRepository(database).whole(session_id))
    finally:
        database.close()
    if ended is not SessionState.FINISHED:
        raise RuntimeError(f"the session is {ended.value}: {operator.questions}")
    return Cost(*spent, watch.spent_s, lines)


@dataclass(frozen=True)
class Overhead:
    """What each configuration costs beside its devices: medians over the runs."""

    wall_ms: float
    least_wall_ms: float  # of the run that other work disturbed least
    cpu_ms: float
    devices_ms: float  # which was taken off
    lines: float  # of the ledger, each on the disk before anything follows from it


async def overhead(out: Path, configurations: int, runs: int) -> Overhead:
    """Measure so many configurations so often."""
    found = [await _difference(out, configurations) for _ in range(runs)]
    wall_s, cpu_s, devices_s, lines = (median(column) / configurations for column in zip(*found, strict=True))
    least_s = min(cost.wall_s for cost in found) / configurations
    return Overhead(1e3 * wall_s, 1e3 * least_s, 1e3 * cpu_s, 1e3 * devices_s, lines)


async def _difference(folder: Path, configurations: int) -> Cost:
    """Return what the configurations of a long session cost that a short one does not have."""
    short = await session_cost(make_plan(_SHORT), folder)
    long = await session_cost(make_plan(_SHORT + configurations), folder)
    wall_s, cpu_s, devices_s, lines = np.subtract(long, short).tolist()
    return Cost(wall_s - devices_s, cpu_s - devices_s, devices_s, lines)


def told(found: Overhead) -> str:
    """Say it in a sentence."""
    return (
        f"{found.wall_ms:.1f} ms a configuration beside the devices ({found.cpu_ms:.1f} ms of CPU time, least"
        f" {found.least_wall_ms:.1f} ms), {found.lines:.1f} lines\n"
    )


if __name__ == "__main__":
    from_command_line(__doc__, "session_overhead", overhead, told, configurations=40, runs=9)
