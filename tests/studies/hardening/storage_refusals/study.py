"""The whole study, on a few processes: half of the sessions with a tracker, half with a ballbar."""

import asyncio
import itertools
import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from random import Random

from tests.integration.web.ballbar_bench import PLACEMENT
from tests.studies.hardening.storage_refusals.ballbar_session import MOMENTS, ballbar_session
from tests.studies.hardening.storage_refusals.outcome import Found, Outcome
from tests.studies.hardening.storage_refusals.tracker_session import TRACKER_FAULTS, tracker_session
from tests.studies.hardening.storage_refusals.trouble import FAULTS
from tests.studies.taken_up.begun import Begun, begin

_SHORT = {"placements": [PLACEMENT]}
_LONG = {"poses": 13, "seed": 1}  # the fewest poses with a pre-calibration that finds something
_ROBOTS = (("irb120-tilted", 2, _SHORT), ("lrmate-tilted", 1, _SHORT), ("lrmate-tilted", 1, _LONG))
_NEAR_THE_END = 14  # copies: of a long session no more than a short one has is walked


async def refusals(folder: Path, runs: int, seed: int, lock_s: float, processes: int) -> Found:
    """Run so many sessions and return what became of them; a lock is held for up to `lock_s`."""
    loop = asyncio.get_running_loop()
    # Not forked: an event loop and its threads do not survive that.
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        robots = range(len(_ROBOTS))
        begun = await asyncio.gather(*(loop.run_in_executor(pool, _begin, n, folder) for n in robots))
        sessions = (
            loop.run_in_executor(pool, _session, number, seed, lock_s, begun, folder)
            for number in range(runs)
        )
        return Found(await asyncio.gather(*sessions))


def _begin(number: int, folder: Path) -> Begun:
    scenario, seed, wanted = _ROBOTS[number]
    begun = asyncio.run(begin(scenario, seed, wanted, folder / f"robot-{number}"))
    return replace(begun, copies=begun.copies[-_NEAR_THE_END:])


def _session(number: int, seed: int, lock_s: float, begun: Sequence[Begun], folder: Path) -> Outcome:
    """Run the session with this number; it draws from a generator of its own."""
    rng, turn = Random(f"{seed}/{number}"), number // 2
    with tempfile.TemporaryDirectory(dir=folder) as name:
        fresh = Path(name)
        if number % 2 == 0:
            fault = TRACKER_FAULTS[turn % len(TRACKER_FAULTS)]
            return asyncio.run(tracker_session(fresh, fault, rng, lock_s))
        tried = [*itertools.product(FAULTS, MOMENTS)]
        Random(seed).shuffle(tried)
        fault, moment = tried[turn % len(tried)]
        one = begun[-1] if moment == "the pre-calibration" else begun[turn % len(begun)]
        return asyncio.run(ballbar_session(fresh, one, fault, moment, rng, lock_s))
