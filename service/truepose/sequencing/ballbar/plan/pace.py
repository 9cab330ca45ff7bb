"""How far a ballbar session is and how many minutes are left, learnt from this operator's own pace."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from truepose.domain.measurement.ballbar import StepKind
from truepose.sequencing.engine.pace import StepTimes

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


def remaining_s(times: StepTimes, open_kinds: Iterable[StepKind]) -> float:
    """Return how long the steps that are still open will take."""
    expected = {kind: _expected_s(times, kind) for kind in StepKind}
    return sum(expected[kind] for kind in open_kinds)


def _expected_s(times: StepTimes, kind: StepKind) -> float:
    """Return how long a step of this kind takes: this operator's median, else the thesis' order."""
    learnt = times.median_s([kind], _ENOUGH)
    return _THESIS_S[kind] if learnt is None else learnt


def pace_s_per_reading(times: StepTimes) -> float | None:
    """Return the median time of a reading; None before the first."""
    return times.median_s(_READINGS)
