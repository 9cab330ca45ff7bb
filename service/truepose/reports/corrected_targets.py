"""Corrected targets as a table."""

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from truepose.domain.results.corrections import CorrectedTargets
from truepose.reports.wording.rounding import MISSING, fixed, millimetres, uncertainty_mm
from truepose.words.catalogue import Catalogue

_HEADS: Final = (
    "corrected.head.line",
    "corrected.head.target",
    "corrected.head.status",
    "corrected.head.shift",
    "corrected.head.uncertainty",
    "corrected.head.outside",
    "corrected.head.moved",
)
_STATUSES: Final = {
    "ok": "corrected.status.ok",
    "limits_unknown": "corrected.status.limits_unknown",
    "joint_limit": "corrected.status.joint_limit",
    "out_of_reach": "corrected.status.out_of_reach",
    "singular": "corrected.status.singular",
}


def target_heads(words: Catalogue) -> tuple[str, ...]:
    """Return the names of the columns."""
    return tuple(map(words.say, _HEADS))


def target_rows(
    targets: CorrectedTargets, words: Catalogue, first: int, count: int
) -> Iterator[tuple[str, ...]]:
    """Yield the cells of some targets, of those from `first` (0-based) on."""
    shift = np.linalg.norm(targets.shift_mm, axis=1)
    for row in range(first, min(first + count, len(targets.names))):
        yield (
            str(targets.lines[row]),
            targets.names[row],
            words.say(_STATUSES[targets.statuses[row]]),
            millimetres(float(shift[row])),
            _uncertain(float(targets.uncertainty_mm[row])),
            _outside(float(targets.outside_mm[row]), words),
            _degrees(float(targets.moved_rad[row])),
        )


def _uncertain(value_mm: float) -> str:
    return uncertainty_mm(value_mm)


def _outside(value_mm: float, words: Catalogue) -> str:
    if not math.isfinite(value_mm):
        return MISSING
    return millimetres(value_mm) if value_mm > 0.0 else words.say("corrected.within")


def _degrees(angle_rad: float) -> str:
    return fixed(math.degrees(angle_rad), 3, "deg")
