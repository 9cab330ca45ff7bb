"""Readings that no place of the arm can have given, set aside before anything is squared.

Wherever the base stands: two tool nests are never further from each other than twice the arm's reach with its
tool, and two lengths from one cup never differ by more. A reading beyond twice that is none of this arm.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, distinct_values
from truepose.domain.measurement.campaign import Campaign, Quantity, Readings
from truepose.domain.results.identification import Outlier
from truepose.domain.sentences import Text, said
from truepose.identification.verdict.conventions import reach_mm

_FAR: Final = 4.0  # reaches; two are possible
_TOOL_MM: Final = 2000.0  # no unknown nest is further from the last frame
_BEYOND: Final[dict[Quantity, str]] = {
    "position": "gross.beyond_reach.position",
    "length": "gross.beyond_reach.length",
}
_ACCIDENTS: Final = 0.2  # share of the readings beyond which they are none: the table is of another robot


@dataclass(frozen=True, slots=True)
class WithinReach:
    """A campaign without the readings that were set aside."""

    campaign: Campaign
    outliers: tuple[Outlier, ...]
    rows: IntArray  # (m,) where the readings that are left stand in their table

    @property
    def sentence(self) -> Text:
        """What was set aside; empty where nothing was."""
        n = len(self.outliers)
        if n == 0:
            return ""
        configs = tuple(outlier.config for outlier in self.outliers[:5])
        key = "reach.one" if n == 1 else "reach.several" if n <= 5 else "reach.many"
        return said(key, readings=n, configurations=configs)

    def with_rows_of_table(self, outliers: tuple[Outlier, ...]) -> tuple[Outlier, ...]:
        """Return outliers of the readings that are left, and those set aside, by their rows in the table."""
        placed = (replace(outlier, row=int(self.rows[outlier.row])) for outlier in outliers)
        return tuple(sorted((*self.outliers, *placed), key=lambda outlier: outlier.row))


def within_reach(campaign: Campaign) -> WithinReach:
    """Set aside the readings that identify and that the arm cannot have reached, where they are few."""
    readings = campaign.readings
    if readings is None:
        return WithinReach(campaign, (), np.zeros(0, dtype=np.int64))
    reach = _with_tool_mm(campaign)
    away_mm = _away_mm(readings)
    beyond = ~(away_mm <= _FAR * reach)  # also what is no number
    if beyond.mean() > _ACCIDENTS:
        beyond = np.zeros(len(readings), dtype=bool)
    rows = np.flatnonzero(~beyond)
    if not beyond.any():
        return WithinReach(campaign, (), rows)
    found = tuple(_outlier(readings, int(row), float(away_mm[row]), reach) for row in np.flatnonzero(beyond))
    return WithinReach(campaign.of_rows(rows), found, rows)


def _with_tool_mm(campaign: Campaign) -> float:
    nests = [np.zeros(3) if nest.centre_mm is None else np.array(nest.centre_mm) for nest in campaign.nests]
    unknown = any(nest.centre_mm is None for nest in campaign.nests)
    longest = max((float(np.abs(nest).sum()) for nest in nests), default=0.0)
    return reach_mm(campaign.robot) + max(longest, _TOOL_MM if unknown else 0.0)


def _away_mm(readings: Readings) -> FloatArray:
    """Return how far each reading is from the middle one of all it can be compared with [mm], shape (n,)."""
    away, seen_from = np.empty(len(readings)), readings.seen_from
    for number in distinct_values(seen_from):
        here = seen_from == number
        seen = readings.observed_mm[here]
        away[here] = np.abs(seen - np.nanmedian(seen, axis=0)).max(axis=1)
    return away


def _outlier(readings: Readings, row: int, away_mm: float, reach: float) -> Outlier:
    return Outlier(
        row=row,
        config=int(readings.stops.config[row]),
        nest=int(readings.nest[row]),
        residual_mm=away_mm,
        reason=said(_BEYOND[readings.quantity], away_mm=away_mm, reach_mm=reach),
    )
