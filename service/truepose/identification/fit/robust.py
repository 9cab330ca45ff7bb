r"""Robust fit: outliers get no weight, and model inadequacy is added to the stated noise.

Rounds of solving alternate with three decisions.

*Prior.* The stated widths w hold what the data do not see. Where the data clearly ask for larger errors p - m
of the geometry, its widths are scaled up together, never down; with C the posterior variances

    factor^2 = sum ((p - m) / w)^2 / sum (1 - C / w^2)        between 1 and 10

*Discrepancy.* Where the residuals r of the readings kept are larger than their stated variance v (chi-square
test at 0.1 %), a standard deviation d per component is added to every reading such that

    sum of weight * r^2 / (v + d^2) = degrees of freedom        (REML with one variance component)

or their median its expectation where that is less: heavy tails are no reason to doubt all readings.

*Gross readings.* A reading whose squared normalised residual exceeds the chi-square quantile that noise would
exceed in one campaign of a hundred (Bonferroni over all readings) gets no weight. The first rounds weigh
softly (Cauchy), so that a start spoilt by gross readings does not decide. Readings of fixed nests are judged
by one another (`observations.fixed_nests`): a model that they contradict does not judge them.

References
----------
D. J. C. MacKay, Neural Computation 4(3), 1992, 415-447 (evidence for the width of a prior).
D. A. Harville, J. American Statistical Association 72, 1977, 320-338 (REML).
P. J. Rousseeuw, A. M. Leroy, Robust Regression and Outlier Detection, 1987.
"""

from dataclasses import dataclass, replace

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.identification.distributions import chi2_limit, chi2_median
from truepose.identification.fit.root_finding import crossing
from truepose.identification.fit.solver import Solution, absorbed, solve
from truepose.identification.model.derivatives import mean_variance
from truepose.identification.model.estimates import Estimate
from truepose.identification.model.structure import Structure
from truepose.identification.observations.blocks import (
    FALSE_ALARM,
    BlockResult,
    ObservationBlock,
    StackedBlocks,
    linearise_blocks,
    reweigh,
)

_SOFT_ROUNDS = 40
_SETTLED = 1e-3  # relative change of the typical residual
_WIDEST = 10.0  # a geometry that asks for more is not this robot's
_HARD_ROUNDS = 12
_EXCESS_LEVEL = 1e-3  # level at which stated uncertainties are found too small
_MOSTLY_LACKING = 0.5  # share of the variance that the model lacks
_TAPER = 1.5  # full weight up to a third of the limit, in squared residuals
_LOST = 4.0 / 3.0  # growth of the typical residual at which hard weights have failed
_CAUCHY = 2.4  # 95 % efficiency on normal noise


@dataclass(frozen=True, slots=True)
class RobustFit:
    """The fit with the weights it settled on.

    Attributes
    ----------
    structure : Structure
        With the prior widths of the fit, which may be wider than stated.
    blocks : tuple of Block
        With final weights and discrepancies.
    solution : Solution
    gross : tuple of ndarray of bool, shape (n,) each
        Readings without weight, of each block.
    chi2_per_dof : float
        Of the readings kept, against the stated uncertainties alone; 1 where these are right.
    """

    structure: Structure
    blocks: tuple[ObservationBlock, ...]
    solution: Solution[StackedBlocks]
    gross: tuple[BoolArray, ...]
    chi2_per_dof: float

    @property
    def without_weight(self) -> int:
        """How many readings of the first table have none, be it their position or their orientation."""
        blocks = zip(self.blocks, self.gross, strict=True)
        here = (flags for block, flags in blocks if block.table == self.blocks[0].table)
        # Each once: the sentence of a status counted positions, the list below it orientations as well.
        return len({row for flags in here for row in np.flatnonzero(flags).tolist()})

    @property
    def values(self) -> FloatArray:
        """Parameter values, shape (P,)."""
        return self.solution.values

    @property
    def estimate(self) -> Estimate:
        """The model with its values."""
        return Estimate(self.structure, self.values, self.solution.covariance)

    @property
    def results(self) -> tuple[BlockResult, ...]:
        """Each block at the solution."""
        return self.solution.final.results


def fit(
    structure: Structure,
    blocks: tuple[ObservationBlock, ...],
    start: FloatArray,
    point: StackedBlocks | None = None,
) -> Solution[StackedBlocks]:
    """Fit with the weights as they are.

    Parameters
    ----------
    structure : Structure
    blocks : tuple of Block
    start : ndarray, shape (P,)
        Internal units.
    point : StackedBlocks, optional
        At the start, where the readings were predicted already; they may weigh otherwise now.
    """
    return solve(
        lambda values, previous: linearise_blocks(structure, blocks, values, previous),
        start,
        structure.prior_means,
        structure.prior_widths,
        first=None if point is None else reweigh(blocks, point),
    )


def robust_fit(structure: Structure, blocks: tuple[ObservationBlock, ...], start: FloatArray) -> RobustFit:
    """Fit, decide about gross readings and discrepancy, and fit again until nothing changes.

    Parameters
    ----------
    structure : Structure
    blocks : tuple of Block
        With unit weights and the stated uncertainties.
    start : ndarray, shape (P,)
        Internal units.

    Returns
    -------
    RobustFit
        Its `solution` says whether the last solving converged.
    """
    structure, soft, nearly = _soft_rounds(structure, blocks, start)
    gentle = fit(structure, soft, nearly.values, nearly.final)
    blocks, gross, solution = _hard_rounds(structure, soft, gentle)
    if _typical(solution.final.results[0]) > _LOST * _typical(gentle.final.results[0]):
        # A sizeable minority drags the fit away from what the majority agrees on: weigh softly after all.
        judged = tuple(
            _judged(block, result, gentle.covariance)
            for block, result in zip(soft, gentle.final.results, strict=True)
        )
        gross = tuple(flags for flags, _ in judged)
        blocks = tuple(
            block.weighted(np.where(flags, 0.0, block.weights), block.discrepancy)
            for block, flags in zip(soft, gross, strict=True)
        )
        solution = fit(structure, blocks, gentle.values, gentle.final)
    return RobustFit(structure, blocks, solution, gross, _stated_chi2(blocks, solution))


def counted_fit(structure: Structure, blocks: tuple[ObservationBlock, ...], start: FloatArray) -> RobustFit:
    """Fit with every reading counting in full: what moves many at once makes none of them gross.

    A discrepancy is still added. Parameters and start as of `robust_fit`.
    """
    solution = fit(structure, blocks, start)
    blocks = _with_discrepancy(blocks, solution)
    solution = fit(structure, blocks, solution.values, solution.final)
    gross = tuple(np.zeros(len(block.weights), dtype=bool) for block in blocks)
    return RobustFit(structure, blocks, solution, gross, _stated_chi2(blocks, solution))


def settled_fit(
    structure: Structure, blocks: tuple[ObservationBlock, ...], start: FloatArray, rounds: int = _HARD_ROUNDS
) -> RobustFit:
    """Fit from a start that is close: decisions of an earlier fit stand in `blocks` and are made again.

    Parameters and start as of `robust_fit`; `rounds` is the most times that decisions are made anew.
    """
    blocks, gross, solution = _hard_rounds(structure, blocks, fit(structure, blocks, start), rounds)
    return RobustFit(structure, blocks, solution, gross, _stated_chi2(blocks, solution))


def _hard_rounds(
    structure: Structure,
    blocks: tuple[ObservationBlock, ...],
    solution: Solution[StackedBlocks],
    rounds: int = _HARD_ROUNDS,
) -> tuple[tuple[ObservationBlock, ...], tuple[BoolArray, ...], Solution[StackedBlocks]]:
    gross: tuple[BoolArray, ...] = ()
    seen: set[bytes] = set()
    for _ in range(rounds):
        judged = tuple(
            _judged(block, result, solution.covariance)
            for block, result in zip(blocks, solution.final.results, strict=True)
        )
        gross = tuple(flags for flags, _ in judged)
        blocks = tuple(
            block.weighted(weights, block.discrepancy)
            for block, (_, weights) in zip(blocks, judged, strict=True)
        )
        blocks = _with_discrepancy(blocks, solution)
        solution = fit(structure, blocks, solution.values, solution.final)
        # Readings at the limit may come and go by turns for ever: weights that were there before end it.
        key = b"".join(np.round(weights, 2).tobytes() for _, weights in judged)
        if key in seen:
            break
        seen.add(key)
    return blocks, gross, solution


def _soft_rounds(
    structure: Structure, blocks: tuple[ObservationBlock, ...], start: FloatArray
) -> tuple[Structure, tuple[ObservationBlock, ...], Solution[StackedBlocks]]:
    stated, typical = structure, np.inf
    held = frozenset[str]().union(*(block.held() for block in blocks))
    values, point = start, linearise_blocks(structure, blocks, start, None)
    for _ in range(_SOFT_ROUNDS):
        before, typical = typical, _typical(point.results[0])
        if abs(before - typical) < _SETTLED * typical:
            break
        # Widths are scaled from the stated ones every time: from the last ones they could only grow.
        blocks = tuple(_softly(block, result) for block, result in zip(blocks, point.results, strict=True))
        solution = fit(structure, blocks, values, point)
        values, point = solution.values, solution.final
        structure = _widened(stated, held, values, solution.covariance)
    return structure, blocks, solution


def _typical(result: BlockResult) -> float:
    return float(np.median(np.linalg.norm(result.residual, axis=1)))


def _widened(
    stated: Structure, held: frozenset[str], values: FloatArray, covariance: FloatArray
) -> Structure:
    """Widen the priors of the geometry together, but for those held, where the data ask for more.

    The factor is the evidence's: squared deviations per parameter that the data determine.
    """
    geometry = effects_with(Trait.GEOMETRY)
    chosen = np.array(
        [
            owner in geometry and name not in held
            for name, owner in zip(stated.names, stated.owners, strict=True)
        ],
        dtype=bool,
    )
    if not chosen.any():
        return stated
    widths = stated.prior_widths[chosen]
    asked = float((((values - stated.prior_means)[chosen] / widths) ** 2).sum())
    determined = float(np.clip(1.0 - np.diag(covariance)[chosen] / widths**2, 0.0, 1.0).sum())
    factor = float(np.clip(np.sqrt(asked / max(determined, 1.0)), 1.0, _WIDEST))
    specs = tuple(
        spec._replace(prior_width=spec.prior_width * factor) if geometric else spec
        for spec, geometric in zip(stated.specs, chosen, strict=True)
    )
    return replace(stated, specs=specs)


def _softly(block: ObservationBlock, result: BlockResult) -> ObservationBlock:
    length = np.linalg.norm(result.residual, axis=1)
    typical = float(np.median(length) / np.sqrt(chi2_median(result.residual.shape[1])))
    stated = block.stated_sigma()
    if typical == stated == 0.0:
        return block  # nothing lies off the model, as far as anybody says
    # By the median: gross readings make neither the scale nor the discrepancy larger.
    excess = np.sqrt(max(typical**2 - stated**2, 0.0))
    weights = 1.0 / (1.0 + (length / (_CAUCHY * max(typical, stated))) ** 2)
    return block.weighted(weights, excess)


def _judged(
    block: ObservationBlock, result: BlockResult, covariance: FloatArray
) -> tuple[BoolArray, FloatArray]:
    """Flag gross readings and weigh the others, against a scale that they cannot move: the median.

    Where the stated noise explains the data, a reading counts in full or not at all. Where the model
    lacks something, the shape of what it lacks is unknown, unlike noise: only a clear gap makes a
    reading gross, and those on the last part of the way there count less.
    """
    n, d = result.residual.shape
    spread = block.component_variance() + block.scatter_mm**2
    squared = block.squared(result) * spread / (spread + _foretold(block, result, covariance))
    scale = max(1.0, float(np.median(squared) / chi2_median(d)))
    lacking = block.discrepancy**2 / float(np.mean(spread))
    limit = (1.0 + lacking) * scale * chi2_limit(FALSE_ALARM / n, d)
    gross = block.bad_among(squared > limit)
    if lacking < _MOSTLY_LACKING or not block.of_arm:
        return gross, np.where(gross, 0.0, 1.0)
    return gross, np.clip(_TAPER * (1.0 - squared / limit), 0.0, 1.0)


def _foretold(block: ObservationBlock, result: BlockResult, covariance: FloatArray) -> FloatArray:
    """Return how well readings that hardly count are foretold by the others, variance, shape (n,); else 0.

    They are off by that as well: with hardly more readings than parameters, one that was once left out
    would stay out for it. R. D. Cook, S. Weisberg, Residuals and Influence in Regression, 1982, section 2.2.
    """
    variance = np.zeros(len(block.weights))
    alone = np.flatnonzero(~block.counts)
    if alone.size:
        variance[alone] = mean_variance(result.jacobian[:, alone], covariance)
    return variance


def _with_discrepancy(
    blocks: tuple[ObservationBlock, ...], solution: Solution[StackedBlocks]
) -> tuple[ObservationBlock, ...]:
    return tuple(
        block.weighted(block.weights, _discrepancy(block, result, solution))
        for block, result in zip(blocks, solution.final.results, strict=True)
    )


def _discrepancy(block: ObservationBlock, result: BlockResult, solution: Solution[StackedBlocks]) -> float:
    own = block.own_discrepancy()
    if own is not None:
        return own
    dof = degrees_of_freedom(block, result, solution.covariance)

    def excess(extra: float) -> float:
        white = block.weighted(block.weights, extra).whitened(result)
        return float(white @ white) - dof

    # Readings that state nothing must be off by something, or they would weigh infinitely much.
    smallest = 0.0 if block.stated_sigma() > 0.0 else 1e-6
    if smallest == 0.0 and excess(0.0) + dof <= chi2_limit(_EXCESS_LEVEL, dof):
        return 0.0
    largest = 10.0 * float(np.sqrt(np.mean(result.residual**2))) + 1e-9
    if excess(smallest) <= 0.0 or excess(largest) >= 0.0:
        return smallest
    mean = crossing(excess, smallest, largest)
    return min(mean, _by_median(block, result, dof, (smallest, largest)))


def _by_median(
    block: ObservationBlock, result: BlockResult, dof: float, bounds: tuple[float, float]
) -> float:
    """Discrepancy that brings the median squared residual of a stop to its place: blind to heavy tails.

    Of whitened residuals: what the readings of one stop share is no reason to doubt each of them.
    """
    n, d = result.residual.shape
    kept = block.weights > 0.0
    _, stop = np.unique(block.targets.stops.config[kept], return_inverse=True)
    if stop.size == 0:
        return bounds[0]
    sizes, which = np.unique(np.bincount(stop), return_inverse=True)
    medians = np.array([chi2_median(d * size) for size in sizes.tolist()])
    # Residuals are smaller than errors by what the parameters absorbed.
    usual = medians[which] * dof / (float(block.weights.sum()) * d)

    def excess(extra: float) -> float:
        white = block.weighted(block.weights, extra).whitened(result).reshape(n, d)[kept]
        return float(np.median(np.bincount(stop, (white**2).sum(axis=1)) / usual)) - 1.0

    if excess(bounds[0]) <= 0.0:
        return bounds[0]
    return bounds[1] if excess(bounds[1]) >= 0.0 else crossing(excess, *bounds)


def degrees_of_freedom(block: ObservationBlock, result: BlockResult, covariance: FloatArray) -> float:
    """Return the readings kept, less what the parameters absorb of them: the trace of the leverage.

    Parameters
    ----------
    block : ObservationBlock
    result : BlockResult
        At the solution, with n readings of d components.
    covariance : ndarray, shape (P, P)
        Posterior: a parameter that its prior holds absorbs nothing.

    Returns
    -------
    float
        sum of weights * d - tr(J^T C J) of whitened J; 1 at least.
    """
    kept = float(block.weights.sum()) * result.residual.shape[1]
    return float(max(kept - absorbed(result.white_jacobian, covariance), 1.0))


def _stated_chi2(blocks: tuple[ObservationBlock, ...], solution: Solution[StackedBlocks]) -> float:
    total, degrees = 0.0, 0.0
    for block, result in zip(blocks, solution.final.results, strict=True):
        if block.stated_sigma() == 0.0:
            continue
        white = block.weighted(block.weights, 0.0).whitened(result)
        total += float(white @ white)
        degrees += degrees_of_freedom(block, result, solution.covariance)
    return total / max(degrees, 1.0)
