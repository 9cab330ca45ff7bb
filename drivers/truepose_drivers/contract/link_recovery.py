"""Faults of a driver's link: how soon one is told and is over, and whether anything stale is taken.

A fault befalls a link at any moment: in the middle of an answer, between two, while a task waits. The
device is away for a while and moves meanwhile. Then the service tries to connect, again and again.
"""

import asyncio
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from truepose_drivers.contract import wire_faults
from truepose_drivers.contract.bench import NewBench
from truepose_drivers.contract.case import ContractBrokenError, SimulatedTimeLoop, Trial, broken
from truepose_drivers.contract.wire_faults import Fault
from truepose_drivers.errors import DriverError
from truepose_drivers.transports.link import now_s

FAULTS_EACH: Final = 500
BACK_WITHIN_S: Final = 5.0
_RETRY_S: Final = 0.25
_LONGEST_AWAY_S: Final = 10.0
_MOST_EXAMPLES: Final = 10
_GIVE_UP_S: Final = 120.0
_BY_ANSWER: Final[dict[str, Fault]] = {
    "cut": wire_faults.cut,
    "stalled": wire_faults.half_late,
    "split": wire_faults.split,
    "merged": wire_faults.merge,
    "doubled": wire_faults.repeat,
    "replayed": wire_faults.replay,
    "garbled": wire_faults.garbage,
}
_OF_LINE: Final = ("half_open", "hung_up", "unplugged")


@dataclass
class RecoveryTally:
    """What one driver made of the faults of its link."""

    driver: str
    faults: int = 0
    lost_s: list[float] = field(default_factory=list)  # from the question to its error, beyond the measuring
    back_s: list[float] = field(default_factory=list)  # from the device's return to a reading
    stale: int = 0  # values that were taken, and were not what the device showed
    left_open: int = 0  # links that were up after an error of theirs
    examples: list[str] = field(default_factory=list)

    cpu_s: float = 0.0


def tally(new_bench: NewBench, faults: int, seed: int = 0) -> RecoveryTally:
    """Let so many faults befall a driver's link, in simulated time."""
    began_s = time.process_time()
    bench = new_bench()
    found = RecoveryTally(bench.plugin.name)
    with asyncio.Runner(loop_factory=SimulatedTimeLoop) as runner:
        runner.run(_run(Trial(bench, seed=seed), found, faults))
    found.cpu_s = round(time.process_time() - began_s, 2)
    return found


def require_found(new_bench: NewBench, faults: int, seed: int = 0) -> None:
    """See that faults are told and pass; raises ContractBrokenError."""
    found = tally(new_bench, faults, seed)
    lost_within_s = new_bench().lost_within_s
    slow = max(found.lost_s, default=0.0) > lost_within_s or max(found.back_s, default=0.0) > BACK_WITHIN_S
    if slow or found.stale or found.left_open:
        shown = "\n  ".join((line(found), *found.examples))
        broken(f"{found.driver} does not recover from faults of its link (seed {seed}):\n  {shown}")


def line(found: RecoveryTally) -> str:
    """Return a tally in one line of text."""
    lost, back = (_spread(times) for times in (found.lost_s, found.back_s))
    return (
        f"{found.driver:20s} {found.faults:5d} faults   lost {lost}   back {back}   "
        f"stale {found.stale}   left open {found.left_open}   cpu {found.cpu_s:.1f} s"
    )


def _spread(times_s: Sequence[float]) -> str:
    ordered = sorted(times_s) or [0.0]
    return f"{ordered[len(ordered) // 2]:5.2f} s, at most {ordered[-1]:5.2f} s"


async def _run(trial: Trial, found: RecoveryTally, faults: int) -> None:
    names = (*_BY_ANSWER, *_OF_LINE)
    for _ in range(faults):
        await _settle(trial)
        fault = names[int(trial.rng.integers(len(names)))]
        found.faults += 1
        try:
            await _suffer(trial, found, fault)
        except ContractBrokenError as error:
            found.stale += 1
            if len(found.examples) < _MOST_EXAMPLES:
                found.examples.append(f"{fault}: {error}")
            await trial.close()
    await trial.close()


async def _settle(trial: Trial) -> None:
    trial.mend()
    await trial.recover()
    trial.bench.move(trial.rng)


async def _suffer(trial: Trial, found: RecoveryTally, fault: str) -> None:
    _strike(trial, fault)
    began_s = now_s()
    taken = await trial.take()
    if isinstance(taken, DriverError):
        found.lost_s.append(max(0.0, now_s() - began_s - trial.bench.measures_s))
        if trial.connected and fault in _OF_LINE:
            found.left_open += 1
    await asyncio.sleep(float(trial.rng.uniform(0.0, _LONGEST_AWAY_S)))
    trial.bench.move(trial.rng)
    trial.mend()
    found.back_s.append(await _back_s(trial))


def _strike(trial: Trial, fault: str) -> None:
    if fault in _BY_ANSWER:
        trial.spoil(_BY_ANSWER[fault], later=int(trial.rng.integers(2)))
        return
    if fault != "half_open":
        trial.wiring.hang_up()
    trial.wiring.deaf = fault == "half_open"
    trial.wiring.unreachable = fault == "unplugged"


async def _back_s(trial: Trial) -> float:
    """Try as the service does until the device is read again, and return how long that took [s]."""
    began_s = now_s()
    while isinstance(await trial.take(), DriverError):
        await asyncio.sleep(_RETRY_S)
        if now_s() - began_s > _GIVE_UP_S:
            broken("the device is back, but the driver no longer reads it")
    return max(0.0, now_s() - began_s - trial.bench.measures_s)
