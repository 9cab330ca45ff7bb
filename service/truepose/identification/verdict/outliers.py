"""Outliers: readings that no place of the arm can have given, and why a reading was given no weight.

What no place of the arm can have given is set aside before anything is squared. Wherever the base stands: two
tool nests are never further from each other than twice the arm's reach with its tool, and two lengths from
one cup never differ by more. A reading beyond twice that is none of this arm: with the median over the
readings that it can be compared with,

    away = largest component of |observed - median| > 4 (sum over the joints of |a| + |d|, and the tool)

unless more than a fifth are: then it is the table that is wrong.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, distinct_values
from truepose.domain.campaign import Campaign, Quantity, Readings
from truepose.domain.identification import Model, Outlier
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.verdict.conventions import reach_mm
from truepose.messages.message import Message, Text, message

_FAR: Final = 4.0  # reaches; two are possible
_TOOL_MM: Final = 2000.0  # no unknown nest is further from the flange frame
_BEYOND: Final[dict[Quantity, str]] = {
    "position": "gross.beyond_reach.position",
    "length": "gross.beyond_reach.length",
}
_ACCIDENTS: Final = 0.2  # share of the readings beyond which they are none: the table is of another robot


@dataclass(frozen=True, slots=True)
class ReachableCampaign:
    """A campaign without the readings that were set aside.

    Attributes
    ----------
    campaign : Campaign
    outliers : tuple of Outlier
        Set aside, by their rows in the table.
    rows : ndarray of int, shape (m,)
        Where the readings that are left stand in their table.
    """

    campaign: Campaign
    outliers: tuple[Outlier, ...]
    rows: IntArray

    @property
    def sentence(self) -> Text:
        """What was set aside; empty where nothing was."""
        n = len(self.outliers)
        if n == 0:
            return ""
        configs = tuple(outlier.config for outlier in self.outliers[:5])
        if n > len(configs):
            return message("reach.set_aside.first", readings=n, configurations=configs)
        return message("reach.set_aside", n=n, configurations=configs)

    def with_rows_of_table(self, outliers: tuple[Outlier, ...]) -> tuple[Outlier, ...]:
        """Return outliers of the readings that are left, and those set aside, by their rows in the table."""
        placed = (replace(outlier, row=int(self.rows[outlier.row])) for outlier in outliers)
        return tuple(sorted((*self.outliers, *placed), key=lambda outlier: outlier.row))


def with_set_aside(model: Model | None, reached: ReachableCampaign) -> Model | None:
    """Return a model that counts the readings set aside among those without weight.

    Parameters
    ----------
    model : Model or None
        Of the readings that are left.
    reached : ReachableCampaign

    Returns
    -------
    Model or None
    """
    aside = len(reached.outliers)
    if model is None or not aside:
        return model
    told = model.identified_from
    counted = {name: int(told[name]) + aside for name in ("readings", "readings_without_weight")}
    return replace(model, identified_from={**told, **counted})


def within_reach(campaign: Campaign) -> ReachableCampaign:
    """Set aside the readings that identify and that the arm cannot have reached, where they are few.

    Parameters
    ----------
    campaign : Campaign

    Returns
    -------
    ReachableCampaign
        With all readings where more than a fifth are out of reach: then the table is of another robot.
    """
    readings = campaign.readings
    if readings is None:
        return ReachableCampaign(campaign, (), np.zeros(0, dtype=np.int64))
    reach = _with_tool_mm(campaign)
    away_mm = _away_mm(readings)
    # Before the fit: the square of a number of another order would leave no digits to the others.
    beyond = ~(away_mm <= _FAR * reach)  # also what is no number
    if beyond.mean() > _ACCIDENTS:
        beyond = np.zeros(len(readings), dtype=bool)
    rows = np.flatnonzero(~beyond)
    if not beyond.any():
        return ReachableCampaign(campaign, (), rows)
    found = tuple(
        _beyond_reach(readings, int(row), float(away_mm[row]), reach) for row in np.flatnonzero(beyond)
    )
    return ReachableCampaign(campaign.of_rows(rows), found, rows)


def _with_tool_mm(campaign: Campaign) -> float:
    nests = [np.zeros(3) if nest.centre_mm is None else np.array(nest.centre_mm) for nest in campaign.nests]
    # Where a nest is unknown the tool may be as long as tools are: nothing is set aside for a long one.
    unknown = any(nest.centre_mm is None for nest in campaign.nests)
    longest = max((float(np.abs(nest).sum()) for nest in nests), default=0.0)
    return reach_mm(campaign.robot) + max(longest, _TOOL_MM if unknown else 0.0)


def _away_mm(readings: Readings) -> FloatArray:
    """Return how far each reading is from the middle one of all it can be compared with [mm], shape (n,)."""
    away, seen_from = np.empty(len(readings)), readings.seen_from
    # Lengths from different cups cannot be compared: each cup may stand anywhere.
    for number in distinct_values(seen_from):
        here = seen_from == number
        seen = readings.observed_mm[here]
        away[here] = np.abs(seen - np.nanmedian(seen, axis=0)).max(axis=1)
    return away


def _beyond_reach(readings: Readings, row: int, away_mm: float, reach: float) -> Outlier:
    return Outlier(
        row=row,
        config=int(readings.stops.config[row]),
        nest=int(readings.nest[row]),
        residual_mm=away_mm,
        reason=message(_BEYOND[readings.quantity], away_mm=away_mm, reach_mm=reach),
    )


_EXPLAINED = 0.2  # a rival explanation must leave less than this share of the residual


def outliers(fit: RobustFit) -> tuple[Outlier, ...]:
    """Return the readings without weight, in the order of their table, each with its reason."""
    return tuple(
        _outlier(fit, number, row)
        for number, block in enumerate(fit.blocks)
        # Rows count in one table: sides, cups and fixed nests stand in others.
        if block.table == fit.blocks[0].table
        for row in np.flatnonzero(fit.gross[number]).tolist()
    )


def _outlier(fit: RobustFit, number: int, row: int) -> Outlier:
    block, norm = fit.blocks[number], float(np.linalg.norm(fit.results[number].residual[row]))
    # An angle has no residual in mm; the reason tells it.
    turned = block.quantity == "orientation"
    return Outlier(
        row=row,
        config=int(block.targets.stops.config[row]),
        nest=int(block.targets.nest[row]),
        residual_mm=0.0 if turned else norm,
        reason=_turned(norm) if turned else _off(fit, number, row, norm),
    )


def _turned(turn_rad: float) -> Message:
    return message("gross.turned", turn_deg=float(np.rad2deg(turn_rad)))


def _off(fit: RobustFit, number: int, row: int, norm_mm: float) -> Message:
    block = fit.blocks[number]
    # With the discrepancy of the fit: beside it the reading was judged.
    expected = float(np.sqrt(np.mean(block.component_variance()) + block.scatter_mm**2))
    plain = message("gross.off", norm_mm=norm_mm, expected_mm=expected)
    rival = None if block.place_mm is None else _rival(fit, number, row, block.place_mm, _EXPLAINED * norm_mm)
    return message("gross.off_and", off=plain, rival=rival) if rival else plain


def _rival(fit: RobustFit, number: int, row: int, places_mm: FloatArray, limit_mm: float) -> Message | None:
    """Another nest or another row that this place fits, if there is one."""
    targets = fit.blocks[number].targets
    # First, as it needs no other row to have gone wrong.
    nest = _fitting_nest(fit, targets.taken(np.array([row])), places_mm[row], limit_mm)
    if nest:
        return message("gross.other_nest", nest=nest)
    # Rows exchanged in a table: what was read here fits where another row says the arm was.
    distance = np.linalg.norm(fit.results[number].state.position_mm - places_mm[row], axis=1)
    distance[row] = np.inf
    other = int(np.argmin(distance))
    if distance[other] < limit_mm:
        return message("gross.exchanged", config=int(targets.stops.config[other]))
    return None


def _fitting_nest(fit: RobustFit, one: Targets, place_mm: FloatArray, limit_mm: float) -> int:
    for nest in range(1, len(fit.structure.nests_mm) + 1):
        if nest == one.nest[0]:
            continue
        state = evaluate(fit.structure, fit.values, Targets(one.stops, np.array([nest])))
        if float(np.linalg.norm(state.position_mm[0] - place_mm)) < limit_mm:
            return nest
    return 0
