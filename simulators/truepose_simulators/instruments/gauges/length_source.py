"""What the ballbar endpoints ask of the cell: the same bar, whatever protocol speaks for it."""

import math
from dataclasses import dataclass
from typing import Literal, Protocol

from truepose_simulators.faults.kinds import BallbarFrozen, BallbarTooFast, BallbarZeroJumps, WireFault
from truepose_simulators.faults.scripted import Faults


class Sample(Protocol):
    """What the bar's transducer shows at one moment."""

    @property
    def deviation_mm(self) -> float:
        """Longer than the bar's own zero is positive; NaN without a signal."""
        ...

    @property
    def signal(self) -> Literal["good", "out_of_range", "none"]:
        """Whether the transducer moves freely, stands at a stop, or says nothing."""
        ...

    @property
    def temperature_c(self) -> float:
        """Temperature of the bar."""
        ...

    @property
    def sequence(self) -> int:
        """Grows with every sample."""
        ...


class LengthSource(Protocol):
    """The bar in the simulated person's hands."""

    @property
    def plugged(self) -> bool:
        """Whether its cable is in."""
        ...

    def sample(self, time_s: float) -> Sample:
        """Read the transducer at a cell time."""
        ...


class CellTime(Protocol):
    """The cell's clock, as far as an instrument needs it."""

    @property
    def now_s(self) -> float:
        """Present cell time [s]."""
        ...


@dataclass(frozen=True, slots=True)
class Display:
    """A sample as the bar's electronics give it."""

    deviation_mm: float
    signal: Literal["good", "out_of_range", "none"]
    temperature_c: float
    sequence: int
    too_fast: bool = False


class Electronics:
    """What stands between transducer and plug: it loses count while the bar is moved too fast."""

    def __init__(self, bar: LengthSource, faults: Faults, clock: CellTime) -> None:
        self._bar = bar
        self._faults = faults
        self._clock = clock
        self._shown: Display | None = None  # last

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

    def show(self) -> Display:
        """Read the transducer now; electronics that hang show what they showed."""
        if self.has(BallbarFrozen) and self._shown is not None:
            return self._shown
        self._shown = self._read()
        return self._shown

    def has(self, kind: type[WireFault]) -> bool:
        """Whether its wire, or whoever is at its keys, does that now."""
        return self._faults.holds(kind, self._clock.now_s)

    def _read(self) -> Display:
        now_s = self._clock.now_s
        sample = self._bar.sample(now_s)
        if self._faults.holds(BallbarTooFast, now_s):
            return Display(math.nan, "none", sample.temperature_c, sample.sequence, too_fast=True)
        off_mm = math.fsum(jump.by_mm for jump, _ in self._faults.holding(BallbarZeroJumps, now_s))
        return Display(sample.deviation_mm + off_mm, sample.signal, sample.temperature_c, sample.sequence)
