"""A plan with its promise, whatever the instrument."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.errors import ConfigurationError, UnderdeterminedError
from truepose.domain.measurement.ballbar import Leg
from truepose.domain.results.identification import NotIdentifiable
from truepose.planning import observability
from truepose.planning.ballbar.fixture import BaseFixture
from truepose.planning.promise.curve import CurvePoint
from truepose.planning.promise.spread import Discrepancy

_INDICES: Final = ("O1", "O2", "O3", "O4", "O5")


@dataclass(frozen=True, slots=True)
class Assumptions:
    """What a promise takes for granted; standard deviations per axis [mm]."""

    reading_mm: float  # of a reading, RMS over the plan; of a length where lengths are read
    repeatability_mm: float  # of the arm
    discrepancy: Discrepancy
    kept_out: tuple[str, ...] = ()  # names of the keep-out volumes that arm, tool and bars stay outside


@dataclass(frozen=True, slots=True)
class BallbarPoses:
    """What is measured with the ballbar in each of n configurations, and from where."""

    legs: tuple[tuple[Leg, ...], ...]  # n
    placement: IntArray  # (n,) of the base fixture, from 1
    fixtures: tuple[BaseFixture, ...]  # in the order of their placements


@dataclass(frozen=True, slots=True)
class PromisedPlan:
    """Configurations to measure, in the order of their visits, and what they promise."""

    joints_rad: FloatArray  # (n, J)
    nest: IntArray | None  # (n,) 1-based; None: all nests, by their legs
    poses: BallbarPoses | None  # None: positions are read
    curve: tuple[CurvePoint, ...]  # numbers of configurations, those measured before included
    advised: int  # the knee of the curve
    measured: int  # configurations that were measured before
    left_open: tuple[NotIdentifiable, ...]  # what readings at all of them would not determine
    observability: Mapping[str, float]  # O1 to O5 of all of them, by name
    assumptions: Assumptions
    targets: tuple[tuple[int, ...], ...] | None = None  # n, read at each stop of a closed loop; None: none

    @property
    def total(self) -> int:
        """Configurations that the promise rests on."""
        return self.measured + len(self.joints_rad)

    @property
    def promised(self) -> CurvePoint:
        """The promise of this plan."""
        return next(point for point in self.curve if point.n == self.total)


def require_some(n: int | None) -> None:
    """Refuse a plan of nothing; raises ConfigurationError."""
    if n is not None and n < 1:
        raise ConfigurationError(f"{n} configurations were asked for; ask for at least one.")


def indices(rows: FloatArray) -> dict[str, float]:
    """Return O1 to O5 of whitened rows (n, d, P); 0 where there are fewer readings than parameters."""
    flat = rows.reshape(-1, rows.shape[2])
    try:
        first = observability.observability_o1(flat, len(rows))
    except UnderdeterminedError:
        return dict.fromkeys(_INDICES, 0.0)
    others = (
        observability.observability_o2,
        observability.observability_o3,
        observability.observability_o4,
        observability.observability_o5,
    )
    return dict(zip(_INDICES, (first, *(index(flat) for index in others)), strict=True))
