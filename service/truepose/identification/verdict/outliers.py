"""Why a reading was given no weight, in words that a person at the robot can act on."""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results import Outlier
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.observations.blocks import OrientationBlock, PositionBlock

_EXPLAINED = 0.2  # a rival explanation must leave less than this share of the residual


def outliers(fit: RobustFit) -> tuple[Outlier, ...]:
    """Return the readings without weight, in the order of their table, each with its reason."""
    block, result, flags = fit.blocks[0], fit.results[0], fit.gross[0]
    norms = np.linalg.norm(result.residual, axis=1)
    expected = float(np.sqrt(np.mean(block.component_variance()) + block.scatter_mm**2))
    found = []
    for row in np.flatnonzero(flags):
        reason = _rival(fit, int(row)) if isinstance(block, PositionBlock) else ""
        plain = f"off by {norms[row]:.3g} mm where {expected:.2g} mm per axis is usual in these data"
        found.append(
            Outlier(
                row=int(row),
                config=int(block.targets.stops.config[row]),
                nest=int(block.targets.nest[row]),
                residual_mm=float(norms[row]),
                reason=f"{plain}: {reason}" if reason else plain,
            )
        )
    found += _orientation_outliers(fit)
    return tuple(found)


def _rival(fit: RobustFit, row: int) -> str:
    """Another nest or another row that this position fits, if there is one."""
    block, result = fit.blocks[0], fit.results[0]
    if not isinstance(block, PositionBlock):
        return ""
    limit = _EXPLAINED * float(np.linalg.norm(result.residual[row]))
    measured = block.measured_mm[row]
    nest = _fitting_nest(fit, block, row, measured, limit)
    if nest:
        return f"it fits nest {nest}, its label is probably wrong"
    distance = np.linalg.norm(result.state.position_mm - measured, axis=1)
    distance[row] = np.inf
    other = int(np.argmin(distance))
    if distance[other] < limit:
        config = int(block.targets.stops.config[other])
        return f"it fits configuration {config}, the two rows are probably exchanged"
    return ""


def _fitting_nest(fit: RobustFit, block: PositionBlock, row: int, measured: FloatArray, limit: float) -> int:
    present = int(block.targets.nest[row])
    one = block.taken(np.array([row])).targets
    for nest in range(1, len(fit.structure.nests_mm) + 1):
        if nest == present:
            continue
        state = evaluate(fit.structure, fit.values, Targets(one.stops, np.array([nest])))
        if float(np.linalg.norm(state.position_mm[0] - measured)) < limit:
            return nest
    return 0


def _orientation_outliers(fit: RobustFit) -> list[Outlier]:
    found = []
    for block, result, flags in zip(fit.blocks, fit.results, fit.gross, strict=True):
        if not isinstance(block, OrientationBlock):
            continue
        for row in np.flatnonzero(flags):
            turn = float(np.linalg.norm(result.residual[row]))
            found.append(
                Outlier(
                    row=int(row),
                    config=int(block.targets.stops.config[row]),
                    nest=int(block.targets.nest[row]),
                    residual_mm=0.0,
                    reason=f"its orientation is off by {np.rad2deg(turn):.3g} deg; the position is kept",
                )
            )
    return found
