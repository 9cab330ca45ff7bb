"""Slips of a person at coded stops, and what the judges of connections say to them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from tests.studies.ballbar_report.coded_stops import READING_U_MM, ZERO_U_MM, CodedStop, StopMaker
from truepose.domain.arrays import FloatArray
from truepose.domain.ballbar import Leg, PoseForecast, Suspicion
from truepose.exchange.cells.file import simulated_cell
from truepose.kinematics.pose_device import base_triangle
from truepose.validation.connection_check import judge_leg, judge_pose

_NOMINAL_MM: Final = 300.0
_RANGE_MM: Final = 1.0
_SLIP_ODDS: Final = 100.0  # right against wrong, before anything is read: a slip in a hundred connections


@dataclass(frozen=True, slots=True)
class SlipCounts:
    """Counts over stops; at each of them one slip of every kind is made, and none."""

    stops: int = 0
    questions: int = 0  # right readings that were questioned, of six a stop
    poses_refused: int = 0  # without any slip
    same_named: int = 0
    single_named: int = 0
    single_nowhere: int = 0  # stops at which no other pair is within range
    exchanged_named: int = 0  # both legs, by the whole pose
    exchanged_named_at_once: int = 0  # the first of them, when it is read
    silent: int = 0  # slips that were stored without any question
    silent_likelier: int = 0  # ... though the readings are likelier of the true pairs than of those asked for
    silent_against_evidence: int = 0  # ... and that by more than slips are rare

    def __add__(self, other: "SlipCounts") -> "SlipCounts":
        """Return the counts of both."""
        return SlipCounts(*(getattr(self, name) + getattr(other, name) for name in self.__dataclass_fields__))


def count_slips(stops: int, seed: int) -> SlipCounts:
    """Make slips at a number of stops and count what is named."""
    rng = np.random.default_rng(seed)
    nests = np.array([nest.centre_mm for nest in simulated_cell("lrmate-tilted", 0).nests], dtype=np.float64)
    maker = StopMaker(base_triangle(_NOMINAL_MM, _NOMINAL_MM, _NOMINAL_MM), nests)
    counts = SlipCounts()
    for _ in range(stops):
        counts += slips_at(maker.stop(rng), rng)
    return counts


def slips_at(stop: CodedStop, rng: np.random.Generator) -> SlipCounts:
    """Make every slip once at a stop."""
    right = Course(stop, {})
    counts = SlipCounts(
        stops=1,
        questions=sum(one is not None for one in right.doubts.values()),
        poses_refused=bool(right.verdict),
    )
    again = int(rng.integers(5))
    same = Course(stop, {stop.legs[again + 1]: stop.legs[int(rng.integers(again + 1))]})
    first, second = (stop.legs[k] for k in sorted(rng.choice(6, 2, replace=False).tolist()))
    exchanged = Course(stop, {first: second, second: first})
    single = _single(stop, rng)
    counts += SlipCounts(
        same_named=same.named_at_once(*same.slips, kind="same_pair"),
        exchanged_named=exchanged.named_by_pose(),
        exchanged_named_at_once=exchanged.named_at_once(first),
        single_nowhere=single is None,
        single_named=single is not None and (single.named_at_once(*single.slips) or single.named_by_pose()),
    )
    return counts + silences([course for course in (same, exchanged, single) if course is not None])


def _single(stop: CodedStop, rng: np.random.Generator) -> "Course | None":
    """Connect another pair within range that was not read yet, where there is one."""
    at = int(rng.integers(6))
    read = stop.legs[: at + 1]
    others = [
        pair
        for pair, length in stop.true_mm.items()
        if pair not in read and abs(length - _NOMINAL_MM) <= _RANGE_MM
    ]
    return Course(stop, {stop.legs[at]: others[int(rng.integers(len(others)))]}) if others else None


def silences(courses: list["Course"]) -> SlipCounts:
    """Count the courses in which nobody was asked anything although something was wrong."""
    silent = [course.log_odds_of_slip() for course in courses if course.silent]
    return SlipCounts(
        silent=len(silent),
        silent_likelier=sum(odds > 0.0 for odds in silent),
        silent_against_evidence=sum(odds > math.log(_SLIP_ODDS) for odds in silent),
    )


class Course:
    """All legs of a stop read one after the other, some from other pairs than asked, every one judged."""

    def __init__(self, stop: CodedStop, slips: Mapping[Leg, Leg]) -> None:
        self.slips = slips
        self._forecast = stop.forecast
        self.taken: dict[Leg, float] = {}
        self.doubts: dict[Leg, Suspicion | None] = {}
        for leg in stop.legs:
            length = stop.read(slips.get(leg, leg))
            self.doubts[leg] = _judged(leg, length, self.taken, stop.forecast)
            self.taken[leg] = length  # whatever is said to it: what follows is judged as if nobody listened
        self.verdict = judge_pose(
            *(self.taken, stop.forecast),
            reading_u_mm=READING_U_MM,
            zero_u_mm=ZERO_U_MM,
            range_mm=_RANGE_MM,
        )

    @property
    def silent(self) -> bool:
        """Whether nobody was asked anything."""
        return not self.verdict and not any(self.doubts.values())

    def named_at_once(self, leg: Leg, *, kind: str | None = None) -> bool:
        """Whether the wrong leg is told with the pair that it is of, when it is read."""
        doubt = self.doubts[leg]
        return doubt is not None and doubt.suspected == self.slips[leg] and kind in {None, doubt.kind}

    def named_by_pose(self) -> bool:
        """Whether the whole pose tells all wrong legs, and no others."""
        return {(one.asked, one.suspected) for one in self.verdict} == set(self.slips.items())

    def log_odds_of_slip(self) -> float:
        """Return how much likelier the readings are of the true pairs than of those asked for (logarithm)."""
        asked = tuple(self.taken)
        lengths = np.array(list(self.taken.values()))
        true = tuple(self.slips.get(leg, leg) for leg in asked)
        return _log_density(lengths, true, self._forecast) - _log_density(lengths, asked, self._forecast)


def _judged(
    leg: Leg, length_mm: float, taken: Mapping[Leg, float], forecast: PoseForecast
) -> Suspicion | None:
    return judge_leg(
        *(leg, length_mm, taken, forecast),
        reading_u_mm=READING_U_MM,
        zero_u_mm=ZERO_U_MM,
        nominal_mm=_NOMINAL_MM,
        range_mm=_RANGE_MM,
    )


def _log_density(length_mm: FloatArray, pairs: tuple[Leg, ...], forecast: PoseForecast) -> float:
    """Return the log-density of lengths under the forecast of these pairs, up to what all pairs share."""
    rows = [forecast.legs.index(pair) for pair in pairs]
    covariance = np.array(forecast.covariance_mm2)[np.ix_(rows, rows)]
    covariance = covariance + (READING_U_MM**2 + ZERO_U_MM**2) * np.eye(len(rows))
    off = length_mm - np.array(forecast.length_mm)[rows]
    _, logarithm = np.linalg.slogdet(covariance)
    return float(-0.5 * off @ np.linalg.solve(covariance, off) - 0.5 * logarithm)
