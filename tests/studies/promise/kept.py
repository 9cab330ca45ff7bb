"""A promise and what came of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.planning.prediction.plan import PromisedPlan


@dataclass(frozen=True, slots=True)
class Kept:
    """Mean and largest error over the volume, as promised and as attained by one cell."""

    n: int
    promised_mm: float
    interval_90_mm: tuple[float, float]
    worst_promised_mm: float
    attained_mm: float
    worst_attained_mm: float

    @property
    def inside(self) -> bool:
        """Whether the attained mean is in the stated interval."""
        low, high = self.interval_90_mm
        return low <= self.attained_mm <= high


def kept(plan: PromisedPlan, errors_mm: FloatArray) -> Kept:
    """Hold true errors (m,) against a plan."""
    said = plan.promised
    attained, worst = float(errors_mm.mean()), float(errors_mm.max())
    return Kept(said.n, said.mean_mm, said.interval_90_mm, said.worst_mm, attained, worst)


@dataclass(frozen=True, slots=True)
class Tally:
    """All cells of one kind."""

    kind: str
    cells: int
    promised_mm: float
    attained_mm: float
    off_percent: float  # mean attained over mean promised
    spread_percent: float  # standard error of that, from the cells
    inside: int
    worst_promised_mm: float
    worst_attained_mm: float


def tally(kind: str, cells: Sequence[Kept]) -> Tally:
    """Return what many cells say together."""
    promised = float(np.mean([cell.promised_mm for cell in cells]))
    attained = np.array([cell.attained_mm for cell in cells])
    spread = float(attained.std(ddof=1) / np.sqrt(len(cells))) if len(cells) > 1 else float("nan")
    return Tally(
        kind,
        len(cells),
        promised,
        float(attained.mean()),
        100.0 * (float(attained.mean()) / promised - 1.0),
        100.0 * spread / promised,
        sum(cell.inside for cell in cells),
        float(np.mean([cell.worst_promised_mm for cell in cells])),
        float(np.mean([cell.worst_attained_mm for cell in cells])),
    )
