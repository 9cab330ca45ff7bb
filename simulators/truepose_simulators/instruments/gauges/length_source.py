"""What the ballbar endpoints ask of the cell: the same bar, whatever protocol speaks for it."""

import math
from dataclasses import dataclass, replace
from typing import Literal, Protocol, TypeAlias

from truepose_simulators.cell.environment import CellClock
from truepose_simulators.faults.kinds import BallbarFrozen, BallbarTooFast, BallbarZeroJumps, WireFault
from truepose_simulators.faults.scripted import Faults

Signal: TypeAlias = Literal["good", "out_of_range", "none"]


@dataclass(frozen=True, slots=True)
class Sample:
    """What a gauge's transducer shows at one moment."""

    deviation_mm: float  # longer than the gauge's own zero is positive; NaN without a signal
    signal: Signal  # whether the transducer moves freely, stands at a stop, or says nothing
    sequence: int  # grows with every sample
    temperature_c: float = math.nan  # of the ballbar; a gauge of a closed loop has no thermometer
    too_fast: bool = False  # for the electronics to count


class LengthSource(Protocol):
    """The bar in the simulated person's hands."""

    @property
    def plugged(self) -> bool:
        """Whether its cable is in."""

    def sample(self, time_s: float) -> Sample:
        """Read the transducer at a cell time."""


class Electronics:
    """What stands between transducer and plug: it loses count while the bar is moved too fast."""

    def __init__(self, bar: LengthSource, faults: Faults, clock: CellClock) -> None:
        self._bar = bar
        self._faults = faults
        self._clock = clock
        self._shown: Sample | None = None  # last

    @property
    def plugged(self) -> bool:
        """Whether the bar's cable is in."""
        return self._bar.plugged

    @property
    def now_s(self) -> float:
        """Present cell time [s]."""
        return self._clock.now_s

    def serial(self, own: str) -> str:
        """Return the serial number that it tells; `own` where nobody has exchanged it."""
        return self._faults.serial("ballbar", own, self._clock.now_s)

    def show(self) -> Sample:
        """Read the transducer now; electronics that hang show what they showed."""
        if self.has(BallbarFrozen) and self._shown is not None:
            return self._shown
        self._shown = self._read()
        return self._shown

    def has(self, kind: type[WireFault]) -> bool:
        """Whether its wire, or whoever is at its keys, does that now."""
        return self._faults.holds(kind, self._clock.now_s)

    def _read(self) -> Sample:
        now_s = self._clock.now_s
        sample = self._bar.sample(now_s)
        if self._faults.holds(BallbarTooFast, now_s):
            return replace(sample, deviation_mm=math.nan, signal="none", too_fast=True)
        off_mm = math.fsum(jump.by_mm for jump, _ in self._faults.holding(BallbarZeroJumps, now_s))
        return replace(sample, deviation_mm=sample.deviation_mm + off_mm)
