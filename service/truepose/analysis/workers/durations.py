"""How long jobs take: a usual time by what they are asked, corrected by how long earlier ones took here."""

import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from truepose.storage.records import JobKind, JobTaken

REMEMBERED: Final = 15  # earlier jobs of a kind; their median forgets one that the computer was busy at
_HARDLY_S: Final = 0.05
_NEARLY: Final = 0.95  # of the time foreseen: from there on a job that goes on is late
_LATE: Final = 0.25  # of the time it took so far is what a late job is said to need still


@dataclass(frozen=True, slots=True)
class _Usual:
    start_s: float
    each_s: float


# Seconds of one core of 2020; the worker's start, and each reading, configuration, pose or kB of a file.
_USUAL: Final = {
    JobKind.IDENTIFICATION: _Usual(2.0, 0.02),
    JobKind.VALIDATION: _Usual(1.5, 0.002),
    JobKind.DIAGNOSIS: _Usual(20.0, 0.2),
    JobKind.PLAN: _Usual(2.0, 0.1),
    JobKind.BALLBAR_PLAN: _Usual(3.0, 1.0),
    JobKind.CONTACT_PLAN: _Usual(1.5, 0.01),
    JobKind.CORRECTION: _Usual(2.0, 0.05),
}


def expected_s(kind: JobKind, work_count: int, earlier: Sequence[JobTaken]) -> float:
    """Return how long a job is expected to run [s], once it has a worker."""
    ratios = [taken.duration_s / _usual_s(kind, taken.work_count) for taken in earlier]
    return _usual_s(kind, work_count) * (statistics.median(ratios) if ratios else 1.0)


def _usual_s(kind: JobKind, work_count: int) -> float:
    usual = _USUAL[kind]
    return usual.start_s + usual.each_s * work_count


@dataclass(frozen=True, slots=True)
class Outlook:
    """How far a job is and how long it still takes."""

    fraction: float
    remaining_s: float


def outlook(expected_s: float, elapsed_s: float, told: float, told_at_s: float) -> Outlook:
    """Return how far a running job is, by what is foreseen and by what it tells of itself.

    Parameters
    ----------
    expected_s : float
        How long such a job takes [s].
    elapsed_s : float
        Since it has its worker [s].
    told : float
        Which fraction of its work it told last, 0 to 1; the more that is, the more it counts.
    told_at_s : float
        When it told that, since it has its worker [s].
    """
    by_itself_s = told_at_s / told if told > 0 else expected_s
    total_s = max((1 - told) * expected_s + told * by_itself_s, _HARDLY_S)
    remaining_s = total_s - elapsed_s
    if elapsed_s > _NEARLY * total_s:
        remaining_s = max(remaining_s, _LATE * elapsed_s * (1 - told))
    return Outlook(min(max(told, elapsed_s / (elapsed_s + remaining_s)), 1.0), remaining_s)
