"""Why a reading was given no weight, in words that a person at the robot can act on."""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results.identification import Outlier
from truepose.domain.sentences import Sentence, said
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.evaluation import Targets, evaluate

_EXPLAINED = 0.2  # a rival explanation must leave less than this share of the residual


def outliers(fit: RobustFit) -> tuple[Outlier, ...]:
    """Return the readings without weight, in the order of their table, each with its reason."""
    return tuple(
        _outlier(fit, number, row)
        for number, block in enumerate(fit.blocks)
        if block.table == fit.blocks[0].table
        for row in np.flatnonzero(fit.gross[number]).tolist()
    )


def _outlier(fit: RobustFit, number: int, row: int) -> Outlier:
    block, norm = fit.blocks[number], float(np.linalg.norm(fit.results[number].residual[row]))
    turned = block.quantity == "orientation"
    return Outlier(
        row=row,
        config=int(block.targets.stops.config[row]),
        nest=int(block.targets.nest[row]),
        residual_mm=0.0 if turned else norm,
        reason=_turned(norm) if turned else _off(fit, number, row, norm),
    )


def _turned(turn_rad: float) -> Sentence:
    return said("gross.turned", turn_deg=float(np.rad2deg(turn_rad)))


def _off(fit: RobustFit, number: int, row: int, norm_mm: float) -> Sentence:
    block = fit.blocks[number]
    expected = float(np.sqrt(np.mean(block.component_variance()) + block.scatter_mm**2))
    plain = said("gross.off", norm_mm=norm_mm, expected_mm=expected)
    rival = None if block.place_mm is None else _rival(fit, number, row, block.place_mm, _EXPLAINED * norm_mm)
    return said("gross.off_and", off=plain, rival=rival) if rival else plain


def _rival(fit: RobustFit, number: int, row: int, places_mm: FloatArray, limit_mm: float) -> Sentence | None:
    """Another nest or another row that this place fits, if there is one."""
    targets = fit.blocks[number].targets
    nest = _fitting_nest(fit, targets.taken(np.array([row])), places_mm[row], limit_mm)
    if nest:
        return said("gross.other_nest", nest=nest)
    distance = np.linalg.norm(fit.results[number].state.position_mm - places_mm[row], axis=1)
    distance[row] = np.inf
    other = int(np.argmin(distance))
    if distance[other] < limit_mm:
        return said("gross.exchanged", config=int(targets.stops.config[other]))
    return None


def _fitting_nest(fit: RobustFit, one: Targets, place_mm: FloatArray, limit_mm: float) -> int:
    for nest in range(1, len(fit.structure.nests_mm) + 1):
        if nest == one.nest[0]:
            continue
        state = evaluate(fit.structure, fit.values, Targets(one.stops, np.array([nest])))
        if float(np.linalg.norm(state.position_mm[0] - place_mm)) < limit_mm:
            return nest
    return 0
