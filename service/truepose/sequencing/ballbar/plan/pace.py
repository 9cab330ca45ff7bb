"""How far a ballbar session is and how many minutes are left, learnt from this operator's own pace."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from statistics import median
from typing import Final

from truepose.domain.ballbar import StepKind

# One minute per pose of six legs, under one hour for 39 configurations with the set-up: thesis section 3.5.
_THESIS_S: Final = {
    StepKind.MOVE: 12.0,
    StepKind.INITIALISE: 10.0,
    StepKind.CONNECT_LEG: 6.0,
    StepKind.DETACH: 2.0,
    StepKind.MEASURE_SIDE: 10.0,
    StepKind.PLACE_BASE: 120.0,
    StepKind.FIT_BALL: 20.0,
    StepKind.CLAMP_CUP: 20.0,
    StepKind.REMOVE_BALL: 20.0,
    StepKind.PRECALIBRATE: 30.0,
}
_READINGS: Final = frozenset({StepKind.INITIALISE, StepKind.MEASURE_SIDE, StepKind.CONNECT_LEG})
_ENOUGH: Final = 3  # steps of a kind before their median says more than the thesis


@dataclass(frozen=True, slots=True)
class BallbarProgress:
    """How far a session is; readings include those of the calibrator."""

    readings: int
    planned: int
    skipped_poses: int
    elapsed_s: float  # time in which the session ran; pauses are not in it
    remaining_s: float
    pace_s_per_reading: float | None  # median; None before the first


@dataclass(slots=True)
class StepTimes:
    """How long the steps took, in cell time; only the time in which the session ran counts."""

    elapsed_s: float = 0.0
    _last_s: float | None = None
    _ended_s: float = 0.0  # elapsed when the step before ended
    _taken_s: dict[StepKind, list[float]] = field(default_factory=dict)

    def tick(self, now_s: float, *, running: bool) -> None:
        """Let time pass until `now_s`."""
        if running and self._last_s is not None:
            self.elapsed_s += max(0.0, now_s - self._last_s)
        self._last_s = now_s

    def end_step(self, kind: StepKind | None) -> None:
        """Count the time since the step before as that of a step of this kind."""
        if kind is not None:
            self._taken_s.setdefault(kind, []).append(self.elapsed_s - self._ended_s)
        self._ended_s = self.elapsed_s

    def expected_s(self, kind: StepKind) -> float:
        """Return how long a step of this kind takes: this operator's median, else the thesis' order."""
        taken = self._taken_s.get(kind, ())
        return median(taken) if len(taken) >= _ENOUGH else _THESIS_S[kind]

    def remaining_s(self, open_kinds: Iterable[StepKind]) -> float:
        """Return how long the steps that are still open will take."""
        expected = {kind: self.expected_s(kind) for kind in StepKind}
        return sum(expected[kind] for kind in open_kinds)

    def pace_s_per_reading(self) -> float | None:
        """Return the median time of a reading; None before the first."""
        taken = [time_s for kind in _READINGS for time_s in self._taken_s.get(kind, ())]
        return median(taken) if taken else None
