"""Hostile bytes to a driver's codec alone: fast enough for millions in a night.

The answers of a good session are recorded on the bench, damaged as lines damage them, and given to the codec.
It may refuse what it hears, for the driver then closes its link. It may wait for more, for the driver then
hears nothing in time. But it comes to an end, and raises nothing that is no DriverError.
"""

import asyncio
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from truepose_drivers.contract.bench import Bench, NewBench
from truepose_drivers.contract.case import SimulatedTimeLoop, Trial, broken
from truepose_drivers.contract.wire_faults import GENERAL, whole
from truepose_drivers.errors import DriverError

_READINGS: Final = 4  # of the good session
_MOST_EXAMPLES: Final = 20
_LONGEST: Final = 300  # bytes of an example


@dataclass
class CodecTally:
    """What one codec made of hostile bytes."""

    driver: str
    inputs: int = 0
    read: int = 0
    refused: int = 0
    waiting: int = 0  # for the rest of what it took for a message
    foreign: int = 0  # exceptions that are none of a driver
    cpu_s: float = 0.0
    examples: list[str] = field(default_factory=list)

    def note(self, data: bytes, error: Exception) -> None:
        """Count what must not happen, and keep the first of it."""
        self.foreign += 1
        if len(self.examples) < _MOST_EXAMPLES:
            self.examples.append(f"{data[:_LONGEST]!r}: {error!r}")


def has_codec(bench: Bench) -> bool:
    """Whether a bench says how its driver's codec reads."""
    return type(bench).decoded is not Bench.decoded


def tally(new_bench: NewBench, inputs: int, seed: int = 0) -> CodecTally:
    """Give a codec so many hostile inputs."""
    began_s = time.process_time()
    bench = new_bench()
    found = CodecTally(bench.plugin.name, inputs)
    rng = np.random.default_rng(seed)
    answers = _recorded(new_bench)
    for _ in range(inputs):
        answer, earlier = (answers[int(rng.integers(len(answers)))] for _ in range(2))
        fault = GENERAL[int(rng.integers(len(GENERAL)))]
        _judge(bench, whole(fault(rng, [answer], earlier)), found)
    found.cpu_s = round(time.process_time() - began_s, 2)
    return found


def require_unharmed(new_bench: NewBench, inputs: int, seed: int = 0) -> None:
    """See that hostile bytes do no harm to a codec; raises ContractBrokenError."""
    found = tally(new_bench, inputs, seed)
    if found.foreign:
        shown = "\n  ".join(found.examples)
        broken(f"the codec of {found.driver} was harmed by hostile bytes (seed {seed}):\n  {shown}")


def _judge(bench: Bench, damaged: bytes, found: CodecTally) -> None:
    try:
        made = bench.decoded(damaged)
    except DriverError:
        found.refused += 1
    except Exception as error:
        found.note(damaged, error)
    else:
        found.read += bool(made)
        found.waiting += not made


def _recorded(new_bench: NewBench) -> Sequence[bytes]:
    """Return answers of a good session that its codec reads."""
    with asyncio.Runner(loop_factory=SimulatedTimeLoop) as runner:
        return runner.run(_session(new_bench()))


async def _session(bench: Bench) -> Sequence[bytes]:
    trial = Trial(bench)
    for _ in range(_READINGS):
        await trial.read()
        bench.move(trial.rng)
    await trial.close()
    return list(dict.fromkeys(answer for answer in trial.wiring.said if _is_read(bench, answer)))


def _is_read(bench: Bench, answer: bytes) -> bool:
    try:
        return bool(bench.decoded(answer))
    except DriverError:  # of another line of the device
        return False
