"""How long the steps of a session took, learnt from its own lines."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import StrEnum
from statistics import fmean, median
from typing import Final

_FAR_OFF: Final = 3.0  # times the median


@dataclass(slots=True)
class StepTimes:
    """How long the steps took, in cell time; only the time in which the session ran counts."""

    elapsed_s: float = 0.0
    _last_s: float | None = None
    _ended_s: float = 0.0  # elapsed when the step before ended
    _taken_s: dict[StrEnum, list[float]] = field(default_factory=dict)

    def tick(self, now_s: float, *, running: bool) -> None:
        """Let time pass until `now_s`."""
        if running and self._last_s is not None:
            self.elapsed_s += max(0.0, now_s - self._last_s)
        self._last_s = now_s

    def end_step(self, kind: StrEnum | None) -> None:
        """Count the time since the step before as that of a step of this kind."""
        if kind is not None:
            self._taken_s.setdefault(kind, []).append(self.elapsed_s - self._ended_s)
        self._ended_s = self.elapsed_s

    @property
    def in_step_s(self) -> float:
        """How long the present step has been under way."""
        return self.elapsed_s - self._ended_s

    def mean_s(self, kind: StrEnum) -> float | None:
        """Return the mean time of steps of a kind, which their sum follows; None before the first.

        One far off the others is none of a usual step: a fault, a search, somebody who helped.
        """
        taken = self._taken_s.get(kind)
        if not taken:
            return None
        usual = _FAR_OFF * median(taken)
        return fmean([time_s for time_s in taken if time_s <= usual] or taken)

    def median_s(self, kinds: Iterable[StrEnum], at_least: int = 1) -> float | None:
        """Return the median time of steps of these kinds; None before there were enough of them."""
        taken = [time_s for kind in kinds for time_s in self._taken_s.get(kind, ())]
        return median(taken) if len(taken) >= at_least else None
