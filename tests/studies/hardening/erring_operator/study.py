"""The whole study, on a few processes."""

import asyncio
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeAlias

from tests.studies.hardening.erring_operator.random_session import run_sessions
from tests.studies.hardening.erring_operator.tally import Tally, joined
from tests.studies.taken_up.begun import Begun, begin

Robot: TypeAlias = tuple[str, int, Mapping[str, Any]]  # scenario, seed, what is wanted of its session
ROBOTS: tuple[Robot, ...] = (
    ("lrmate-tilted", 3, {"poses": 8}),
    ("irb120-tilted", 0, {"poses": 16}),
    ("lrmate-tilted", 1, {"poses": 16}),
    ("irb120-tilted", 2, {"poses": 16}),
    ("irb120-tilted", 4, {"poses": 8}),
    ("lrmate-tilted", 5, {"poses": 16}),
)


@dataclass(frozen=True, slots=True)
class Wanted:
    """How much is tried."""

    sessions: int = 1000
    robots: int = len(ROBOTS)
    deeds: int = 30  # of the operator in each session
    share: float = 0.3  # of the steps at which the operator errs
    seed: int = 0
    processes: int = 2


def study(wanted: Wanted, robots: Sequence[Robot], folder: Path) -> Tally:
    """Walk the robots' sessions rightly, then run the random ones; here where one process is wanted."""
    if wanted.processes == 1:
        begun = [_begin(number, robots[number], folder) for number in range(wanted.robots)]
        return joined([_run(wanted, 0, begun, folder)])
    # Not forked: an event loop and its threads do not survive that.
    with ProcessPoolExecutor(wanted.processes, mp_context=get_context("spawn")) as pool:
        begun = list(pool.map(_begin, range(wanted.robots), robots, [folder] * wanted.robots))
        parts = range(wanted.processes)
        tallies = [pool.submit(_run, wanted, part, begun, folder) for part in parts]
        return joined([tally.result() for tally in tallies])


def _begin(number: int, robot: Robot, folder: Path) -> Begun:
    scenario, seed, session = robot
    return asyncio.run(begin(scenario, seed, {"seed": seed, **session}, folder / f"robot-{number}"))


def _run(wanted: Wanted, part: int, begun: Sequence[Begun], folder: Path) -> Tally:
    numbers = range(part, wanted.sessions, wanted.processes)
    return asyncio.run(run_sessions(numbers, begun, wanted.deeds, wanted.share, wanted.seed, folder))
