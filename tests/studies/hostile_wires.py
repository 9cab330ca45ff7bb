"""Hostile input to every driver: what it makes of bad lines, late, stale and foreign answers, other units.

`python -m tests.studies.hostile_wires --out DIR [--runs N] [--seed N]` asks each driver so many times over a
wire that spoils one answer, and once more over a good wire: a value that is taken must be the device's true
one. Wires keep virtual time, so nobody waits. One in ten faults happens while the driver connects.

A wrong value counts as *unseen* only where one character or bit of a whole frame was another, in its place
and within range, or where a number of any length lost or doubled a digit: without a checksum nothing betrays
that. All others could have been betrayed.
"""

import argparse
import asyncio
import json
import sys
import time
from collections import Counter as Count
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from tests.studies.wires.cameras import Camera
from tests.studies.wires.fanuc import Fanuc
from tests.studies.wires.gauges import Bar, Bridge, Cable, Counter
from tests.studies.wires.line_gauges import KeyenceAmplifiers, MitutoyoCounter, MitutoyoLine
from tests.studies.wires.machines import ClockOfCell, Controller, HandsOfPerson, Tracker
from tests.studies.wires.spoiling import GENERAL, WITHIN_A_FRAME, WITHIN_FREE_NUMBERS
from truepose_drivers.errors import DriverError, DriverFaultError
from truepose_drivers.guard import guarded

RUNS = 20_000
BENCHES = {
    "leica_emscon": Tracker,
    "abb_open_abb": Controller,
    "fanuc_mappdk": Fanuc,
    "ndi_polaris": Camera,
    "ballbar_hid": Bar,
    "ballbar_bridge": Bridge,
    "heidenhain_nd": Counter,
    "mitutoyo_usb_itn": Cable,
    "keyence_gt2": KeyenceAmplifiers,
    "mitutoyo_eh": MitutoyoCounter,
    "mitutoyo_serial": MitutoyoLine,
    "cell_clock": ClockOfCell,
    "cell_hands": HandsOfPerson,
}
_PATIENCE_S = 5.0  # wall time; nothing here takes a thousandth of it
_WHILE_CONNECTING = 0.1


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
    foreign: int = 0
    hung: int = 0
    wall_s: float = 0.0
    examples: list[str] = field(default_factory=list)
    wrong_by_fault: dict[str, int] = field(default_factory=dict)


class Trial:
    """One driver on its bench."""

    def __init__(self, name, seed):
        self.tally = Tally(name)
        self._rng = np.random.default_rng([seed, sorted(BENCHES).index(name)])
        self._name = name
        self._bench = BENCHES[name]()
        device = guarded(name, self._bench.kind, self._bench.driver)
        self._device = self._bench.watched(device) if hasattr(self._bench, "watched") else device
        self._earlier = b"?"
        self._wrong = Count()
        self._unseen = WITHIN_FREE_NUMBERS if self._bench.free_numbers else WITHIN_A_FRAME

    async def run(self, inputs):
        began_s = time.monotonic()
        names = [spoil.__name__ for spoil in GENERAL] + list(self._bench.specials)
        for _ in range(inputs):
            fault = str(self._rng.choice(names))
            self.tally.inputs += 1
            if self._rng.random() < _WHILE_CONNECTING:
                await self._device.close()
            else:
                await self._reach()
                self._bench.move(self._rng)
            self._arm(fault)
            await self._judge(fault)
            self._bench.link.spoil = None
            self._bench.move(self._rng)
            await self._judge(f"after {fault}")  # what a fault leaves behind
        self.tally.wall_s = round(time.monotonic() - began_s, 2)
        self.tally.wrong_by_fault = dict(self._wrong)
        return self.tally

    async def _reach(self):
        if self._bench.kind == "clock" or self._device.connected:
            return
        await self._device.connect()
        if hasattr(self._bench, "prepare"):
            await self._bench.prepare(self._device)

    def _arm(self, fault):
        spoil = next((spoil for spoil in GENERAL if spoil.__name__ == fault), None)
        if spoil is None:
            self._bench.special(fault, self._rng)
            return
        skipped = int(self._rng.integers(4)) if self._rng.integers(2) else 0

        def spoiled(said, left=skipped):
            if left > 0:  # a later answer of the same conversation
                self._bench.link.spoil = lambda next_said: spoiled(next_said, left - 1)
                return said
            whole = b"".join(said)
            earlier, self._earlier = self._earlier, whole
            return spoil(self._rng, said, earlier)

        self._bench.link.spoil = spoiled

    async def _judge(self, fault):
        try:
            async with asyncio.timeout(_PATIENCE_S):
                await self._reach()
                value = await self._bench.ask(self._device)
        except TimeoutError:
            self._note("hung", fault, "no end")
        except DriverFaultError as error:
            self._note("foreign", fault, error)
        except DriverError:
            self.tally.refused += 1
        except Exception as error:
            self._note("foreign", fault, repr(error))
        else:
            self._judge_value(fault, value)

    def _judge_value(self, fault, value):
        if value is None:
            self.tally.no_value += 1
        elif self._bench.is_right(value):
            self.tally.right += 1
        elif fault in self._unseen:
            self.tally.wrong_unseen += 1
        else:
            self._wrong[fault] += 1
            self._note("wrong_betrayable", fault, value)

    def _note(self, what, fault, detail):
        setattr(self.tally, what, getattr(self.tally, what) + 1)
        if len(self.tally.examples) < 20:
            self.tally.examples.append(f"{what}, {fault}: {detail}")


async def study(inputs, seed, names=tuple(BENCHES)):
    """Ask every driver so often; returns a tally each."""
    return [await Trial(name, seed).run(inputs) for name in names]


_COLUMNS = ("inputs", "right", "no_value", "refused", "wrong_betrayable", "wrong_unseen", "foreign", "hung")


def table(tallies):
    """Return the tallies as lines of a table."""
    head = " ".join(f"{name:>16s}" for name in ("driver", *_COLUMNS, "wall_s"))
    lines = [
        " ".join(f"{value!s:>16s}" for value in (t.driver, *(getattr(t, c) for c in _COLUMNS), t.wall_s))
        for t in tallies
    ]
    return [head, *lines]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--runs", type=int, default=RUNS, help="hostile inputs to each driver")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--driver", choices=BENCHES, action="append", help="only this one; may be repeated")
    options = parser.parse_args()
    tallies = asyncio.run(study(options.runs, options.seed, options.driver or tuple(BENCHES)))
    options.out.mkdir(parents=True, exist_ok=True)
    document = {"runs": options.runs, "seed": options.seed, "drivers": [asdict(tally) for tally in tallies]}
    (options.out / "hostile_wires.json").write_text(json.dumps(document, indent=1))
    sys.stdout.writelines(f"{line}\n" for line in table(tallies))


if __name__ == "__main__":
    main()
