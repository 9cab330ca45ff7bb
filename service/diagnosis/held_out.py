"""The gain: errors on points that neither the choice of the model nor its parameters saw."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from service.diagnosis.groups import names_of
from service.diagnosis.selection import Propose, Selected, select
from service.domain.arrays import FloatArray, IntArray
from service.domain.campaign import Campaign
from service.domain.diagnosis import Gain, HeldOutErrors
from service.effects.causes import Candidate
from service.identification.leg_problem import leg_block
from service.identification.observations import Block
from service.identification.problem import position_block
from service.identification.robust import RobustFit, fit
from service.identification.rows import sites
from service.identification.statistics import expected_noise_mm
from service.identification.structure import Structure

_RESAMPLED = 1000  # 25 of them lie beyond either end of the interval
_FOLDS = 5  # four fifths of the configurations choose: nearly as well as all


@dataclass(frozen=True, slots=True)
class Judged:
    """Held-out errors of the start model, of the extended one, and of that without each cause in turn."""

    errors: HeldOutErrors
    without: tuple[FloatArray, ...]  # (n, d) per group of picks
    site: IntArray  # (n,)
    noise_mm: float
    source: str  # "validation" or "cross_validation"

    def gain(self, group: int) -> Gain:
        """Return what one cause gains."""
        return gain_of(self.without[group], self.errors.after_mm, self.site)


@dataclass(frozen=True, slots=True)
class _Fold:
    """The configurations of one fold, and what was fitted and chosen without them."""

    out: IntArray  # readings of the first block
    start: RobustFit
    extended: RobustFit
    picks: tuple[Candidate, ...]


class Judging:
    """Judges extended models of one start: on the validation points, else by nested cross-validation."""

    def __init__(self, campaign: Campaign, start: RobustFit, propose: Propose) -> None:
        self._start = start
        self._propose = propose
        self._validation = _validation_block(campaign)

    def of(self, selected: Selected, groups: tuple[tuple[Candidate, ...], ...]) -> Judged:
        """Judge an extended model, and it without each of its groups."""
        if self._validation is not None:
            return _on_validation(self._validation, self._start, selected, groups)
        return _crossed(self._start, self._chosen if groups else self._plain, groups)

    @cached_property
    def _plain(self) -> tuple[_Fold, ...]:
        return tuple(_folds(self._start))

    @cached_property
    def _chosen(self) -> tuple[_Fold, ...]:
        """The folds with the choice made anew in each: once, since it hangs on no group."""
        return tuple(_chosen_in(fold, self._propose) for fold in self._plain)


def _validation_block(campaign: Campaign) -> Block | None:
    if campaign.calibration is not None:
        points = campaign.validation
        return None if points is None or len(points) == 0 else position_block(points, campaign)
    legs = campaign.validation_legs
    if legs is None or len(legs) == 0:
        return None
    anchors = tuple(sorted(set(zip(legs.placement.tolist(), legs.base_point.tolist(), strict=True))))
    return leg_block(legs, campaign, anchors)


def _on_validation(
    block: Block, start: RobustFit, selected: Selected, groups: tuple[tuple[Candidate, ...], ...]
) -> Judged:
    before = _residual(block, start.structure, start.values)
    after = _residual(block, selected.fit.structure, selected.fit.values)
    without = tuple(_without(block, selected.fit, group) for group in groups)
    errors = _errors(block, selected.fit, before, after)
    return Judged(errors, without, sites(block.targets.stops), expected_noise_mm(block), "validation")


def _residual(block: Block, structure: Structure, values: FloatArray) -> FloatArray:
    return block.result(structure, values, None).residual


def _without(block: Block, full: RobustFit, group: tuple[Candidate, ...]) -> FloatArray:
    """Residuals of the extended model without the parameters of a group, the others fitted again.

    The others follow as a normal posterior's mean does where the group is known to be zero.
    """
    names = names_of(group)
    out = np.array([name in names for name in full.structure.names])
    covariance = full.solution.covariance
    values = full.values - covariance[:, out] @ np.linalg.solve(
        covariance[np.ix_(out, out)], full.values[out]
    )
    values[out] = 0.0
    return _residual(block, full.structure, values)


def _folds(start: RobustFit) -> Iterator[_Fold]:
    """Fit the start model without each fold of configurations in turn."""
    site = sites(start.blocks[0].targets.stops)
    for held in np.array_split(np.random.default_rng(0).permutation(np.unique(site)), _FOLDS):
        out = np.flatnonzero(np.isin(site, held))
        if out.size:
            part = _part(start, held)
            yield _Fold(out, part, part, ())


def _chosen_in(fold: _Fold, propose: Propose) -> _Fold:
    chosen = select(fold.start, propose, lambda _share: None)
    return replace(fold, extended=chosen.fit, picks=chosen.picks)


def _crossed(start: RobustFit, folds: tuple[_Fold, ...], groups: tuple[tuple[Candidate, ...], ...]) -> Judged:
    first = start.blocks[0]
    shape = start.results[0].residual.shape
    before, after = np.zeros(shape), np.zeros(shape)
    without = tuple(np.zeros(shape) for _ in groups)
    for fold in folds:
        block = first.subset(fold.out)
        before[fold.out] = _residual(block, fold.start.structure, fold.start.values)
        after[fold.out] = _residual(block, fold.extended.structure, fold.extended.values)
        for left, group in zip(without, groups, strict=True):
            same = _same(fold.picks, group[0])
            left[fold.out] = _without(block, fold.extended, same) if same else after[fold.out]
    errors = _errors(first, start, before, after)
    stated = first.weighted(first.weights, 0.0)
    site = sites(first.targets.stops)
    return Judged(errors, without, site, expected_noise_mm(stated), "cross_validation")


def _same(picks: tuple[Candidate, ...], one: Candidate) -> tuple[Candidate, ...]:
    return tuple(pick for pick in picks if (pick.effect, pick.subject) == (one.effect, one.subject))


def _part(start: RobustFit, held: IntArray) -> RobustFit:
    """Fit the start model without some configurations."""
    blocks = tuple(
        block.subset(np.flatnonzero(~np.isin(sites(block.targets.stops), held))) for block in start.blocks
    )
    solution = fit(start.structure, blocks, start.values)
    gross = tuple(
        flags[~np.isin(sites(block.targets.stops), held)]
        for block, flags in zip(start.blocks, start.gross, strict=True)
    )
    return RobustFit(start.structure, blocks, solution, gross, start.chi2_per_dof)


def _errors(block: Block, shown: RobustFit, before: FloatArray, after: FloatArray) -> HeldOutErrors:
    state = block.result(shown.structure, shown.values, None).state
    return HeldOutErrors(block.targets.stops.config, state.position_mm, before, after)


def gain_of(before: FloatArray, after: FloatArray, site: IntArray) -> Gain:
    """RMS before and after with the 95 % interval of their difference, resampled by configuration.

    Parameters
    ----------
    before, after : ndarray, shape (n, d)
    site : ndarray, shape (n,)
    """
    squares = _by_site(before, after, site)
    differences = _resampled(squares)
    low, high = np.quantile(differences, [0.025, 0.975])
    total = squares.sum(axis=1)
    return Gain(
        float(np.sqrt(total[0] / total[2])),
        float(np.sqrt(total[1] / total[2])),
        (float(low), float(high)),
    )


def _by_site(before: FloatArray, after: FloatArray, site: IntArray) -> FloatArray:
    """Return sums of squares before, after, and counts, of every configuration, shape (3, S)."""
    _, which = np.unique(site, return_inverse=True)
    return np.stack([
        np.bincount(which, (before**2).sum(axis=1)),
        np.bincount(which, (after**2).sum(axis=1)),
        np.bincount(which),
    ])


def _resampled(squares: FloatArray) -> FloatArray:
    """Differences of the two RMS with configurations drawn with replacement."""
    drawn = np.random.default_rng(0).integers(0, squares.shape[1], (_RESAMPLED, squares.shape[1]))
    sums = squares[:, drawn].sum(axis=2)
    return np.asarray(np.sqrt(sums[0] / sums[2]) - np.sqrt(sums[1] / sums[2]))
