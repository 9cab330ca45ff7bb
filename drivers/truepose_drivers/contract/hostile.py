"""Hostile input: what a driver makes of bad lines, late, stale and foreign answers, other units.

A driver is asked many times over a line that spoils one answer, and once more over a good one: a value that
is taken must be what the device truly shows. One in ten faults happens while the driver connects.

A wrong value counts as *unseen* only where one character or bit of a whole frame was another, in its place
and within range, or where a number of any length lost or doubled a digit: without a checksum nothing betrays
that. All others could have been betrayed.
"""

import asyncio
import time
from dataclasses import dataclass, field
from typing import Final

from truepose_drivers.contract.bench import NewBench
from truepose_drivers.contract.case import SimulatedTimeLoop, Trial, broken
from truepose_drivers.contract.wire_faults import GENERAL, WITHIN_A_FRAME, WITHIN_FREE_NUMBERS
from truepose_drivers.errors import DriverError, DriverFaultError

QUICK_INPUTS: Final = 20_000
_PATIENCE_S: Final = 300.0
_WHILE_CONNECTING: Final = 0.1
_DEEPEST: Final = 4
_IN_STEP_WITHIN: Final = 2  # good exchanges
_MOST_EXAMPLES: Final = 20
_SPOILS: Final = {spoil.__name__: spoil for spoil in GENERAL}


@dataclass
class Tally:
    """What one driver made of its hostile inputs."""

    driver: str
    inputs: int = 0
    right: int = 0
    no_value: int = 0  # a reading that says that there is none
    refused: int = 0
    wrong_betrayable: int = 0
    wrong_unseen: int = 0
    foreign: int = 0  # exceptions that are none of a driver
    hung: int = 0
    out_of_step: int = 0  # nothing was read over the second good exchange
    cpu_s: float = 0.0
    examples: list[str] = field(default_factory=list)
    wrong_by_fault: dict[str, int] = field(default_factory=dict)

    @property
    def harmed(self) -> bool:
        """Whether anything happened that must not."""
        return bool(self.wrong_betrayable or self.foreign or self.hung or self.out_of_step)

    def note(self, what: str, fault: str, detail: object) -> None:
        """Count what must not happen, and keep the first of it."""
        setattr(self, what, getattr(self, what) + 1)
        if len(self.examples) < _MOST_EXAMPLES:
            self.examples.append(f"{what}, {fault}: {detail}")


def tally(new_bench: NewBench, inputs: int, seed: int = 0) -> Tally:
    """Ask a driver so often, in simulated time."""
    with asyncio.Runner(loop_factory=SimulatedTimeLoop) as runner:
        return runner.run(_Hostility(new_bench, seed).run(inputs))


def require_unharmed(new_bench: NewBench, inputs: int, seed: int = 0) -> None:
    """See that hostile inputs do no harm; raises ContractBrokenError."""
    found = tally(new_bench, inputs, seed)
    if found.harmed:
        shown = "\n  ".join(found.examples)
        broken(f"{found.driver} was harmed by hostile inputs (seed {seed}):\n  {shown}")


class _Hostility:
    """One driver, behind its guard as in the service, on a line that is spoiled again and again."""

    def __init__(self, new_bench: NewBench, seed: int) -> None:
        self._bench = new_bench()
        self._seed = seed
        self._tally = Tally(self._bench.plugin.name)
        self._unseen = WITHIN_FREE_NUMBERS if self._bench.free_numbers else WITHIN_A_FRAME

    async def run(self, inputs: int) -> Tally:
        began_s = time.process_time()
        self._trial = Trial(self._bench, seed=self._seed, behind_guard=True)
        names = [*_SPOILS, *self._bench.specials]
        for _ in range(inputs):
            await self._endure(names[int(self._trial.rng.integers(len(names)))])
        await self._trial.close()
        self._tally.cpu_s = round(time.process_time() - began_s, 2)
        return self._tally

    async def _endure(self, fault: str) -> None:
        self._tally.inputs += 1
        await self._begin(fault)
        self._arm(fault)
        await self._judge(fault)
        self._trial.mend()
        for exchange in range(_IN_STEP_WITHIN):
            self._bench.move(self._trial.rng)
            if await self._judge(f"after {fault}"):
                return
            refused = exchange
        self._tally.note("out_of_step", fault, f"{refused + 1} good exchanges were refused")

    async def _begin(self, fault: str) -> None:
        if self._trial.connects and self._trial.rng.random() < _WHILE_CONNECTING:
            await self._trial.device.close()
            return
        await self._trial.reach()
        self._bench.move(self._trial.rng)

    def _arm(self, fault: str) -> None:
        if fault in _SPOILS:
            rng = self._trial.rng
            self._trial.spoil(_SPOILS[fault], later=int(rng.integers(_DEEPEST)) if rng.integers(2) else 0)
        else:
            self._bench.special(fault, self._trial.wiring, self._trial.rng)

    async def _judge(self, fault: str) -> bool:
        """Ask once; whether a value came."""
        try:
            async with asyncio.timeout(_PATIENCE_S):
                value = await self._trial.ask()
        except TimeoutError:
            self._tally.note("hung", fault, "no end")
        # Before DriverError, of which it is one: the guard says by it that a driver raised something foreign.
        except DriverFaultError as error:
            self._tally.note("foreign", fault, error)
        except DriverError:
            self._tally.refused += 1
        except Exception as error:
            self._tally.note("foreign", fault, repr(error))
        else:
            self._judge_value(fault, value)
            return value is not None
        return False

    def _judge_value(self, fault: str, value: object) -> None:
        if value is None:
            self._tally.no_value += 1
        elif self._bench.is_right(value):
            self._tally.right += 1
        elif fault in self._unseen:
            self._tally.wrong_unseen += 1
        else:
            self._tally.wrong_by_fault[fault] = self._tally.wrong_by_fault.get(fault, 0) + 1
            self._tally.note("wrong_betrayable", fault, value)
