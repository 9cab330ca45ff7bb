"""Errors on readings that neither the choice of a model nor its parameters saw, and the gain there.

Decisions rest on nested cross-validation within the calibration. The validation readings are asked once, when
everything is decided (decision 0031).

The gain is RMS(before) - RMS(after) with RMS = sqrt(sum |e_i|^2 / n). Its interval is the bootstrap's: whole
configurations are drawn with replacement, since readings of one configuration share their error.

References
----------
B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap, 1993, section 13.3 (percentile interval).
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from truepose.diagnosis.evidence.cross_validation import Errors, Nested, as_found, partition
from truepose.diagnosis.screening.selection import Choice, Selection, names_of
from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Campaign, sites
from truepose.domain.diagnosis import Gain, HeldOutErrors
from truepose.domain.singular_covariance import solve_singular
from truepose.effects.causes import Candidate
from truepose.effects.signatures import of_legs, signature_of
from truepose.identification.distributions import chi2_median
from truepose.identification.fit.assessment import held_out_residuals
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.structure import Structure
from truepose.identification.observations.blocks import ObservationBlock
from truepose.identification.verdict.judge import (
    Assessment,
    expected_noise_mm,
    judge_estimates,
    observation_block,
)

_RESAMPLED = 1000  # 25 of them lie beyond either end of the interval


def gain_of(before: FloatArray, after: FloatArray, site: IntArray) -> Gain:
    """Return RMS before and after with the 95 % interval of their difference, resampled by configuration.

    Parameters
    ----------
    before, after : ndarray, shape (n, d)
        Errors of the same n >= 1 readings [mm].
    site : ndarray of int, shape (n,)
        The configuration of each.

    Returns
    -------
    Gain
        [mm]; the interval is of before less after.
    """
    squares = _by_site(before, after, site)
    differences = _resampled(squares)
    low, high = np.quantile(differences, [0.025, 0.975])
    # Per reading, not per component: a position's error is the length of its vector.
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
    """Return the differences of the two RMS with configurations drawn with replacement, shape (1000,)."""
    sums = squares @ _times_drawn(squares.shape[1]).T.astype(float)
    return np.asarray(np.sqrt(sums[0] / sums[2]) - np.sqrt(sums[1] / sums[2]))


@lru_cache(maxsize=4)
def _times_drawn(sites: int) -> IntArray:
    """Return how often each site is drawn in each resampling, the same for whatever is compared, (r, S)."""
    # One set of draws for all groups of a diagnosis: their intervals differ by what they gain, not by chance.
    drawn = np.random.default_rng(0).integers(0, sites, (_RESAMPLED, sites))
    times = np.zeros((_RESAMPLED, sites), dtype=np.int64)
    np.add.at(times, (np.arange(_RESAMPLED)[:, None], drawn), 1)
    return times


Groups = tuple[tuple[Candidate, ...], ...]


@dataclass(frozen=True, slots=True)
class Improvement:
    """Held-out errors of the initial model and of the extended one, and what each of its causes gains.

    Attributes
    ----------
    errors : HeldOutErrors
        Of n readings.
    gains : tuple of Gain
        Per group of picks.
    seen_in : tuple of int
        Per group: how many folds choose it too; none of validation readings.
    site : ndarray of int, shape (n,)
        Configuration of each reading.
    noise_mm : float
        Mean norm that stated noise alone gives.
    source : str
        "validation" or "cross_validation".
    beyond : float
        Typical validation error over what noise and parameters explain [1].
    described : Gain or None
        What is described gains beside the causes; None where nothing is.
    """

    errors: HeldOutErrors
    gains: tuple[Gain, ...]
    seen_in: tuple[int, ...]
    site: IntArray
    noise_mm: float
    source: str
    beyond: float = 1.0
    described: Gain | None = None

    @property
    def together(self) -> Gain:
        """What all causes gain together."""
        return gain_of(self.errors.before_mm, self.errors.after_mm, self.site)

    @property
    def named_share(self) -> float | None:
        """Share of the squared error beyond the noise that named causes take off; None where none is beyond.

        Without what is described. Of d alike components the RMS of noise is sqrt(pi / 2) (d = 1) or
        sqrt(3 pi / 8) (d = 3) times its mean norm.
        """
        alone = self.errors.before_mm.shape[1] == 1
        noise_mm = self.noise_mm * np.sqrt(np.pi / 2.0 if alone else 3.0 * np.pi / 8.0)
        gain = self.together
        after_mm = gain.rms_after_mm if self.described is None else self.described.rms_before_mm
        beyond = gain.rms_before_mm**2 - noise_mm**2
        if beyond <= 0.0:
            return None
        return float(np.clip((gain.rms_before_mm**2 - after_mm**2) / beyond, 0.0, 1.0))


class CrossValidation:
    """Judges extended models of one start on configurations left out of the calibration.

    The choice in the folds of each partition is made once, when it is first needed.
    """

    def __init__(self, first: Choice) -> None:
        self._first, self._fit = first, first.first.fit

    def of(self, selected: Selection, groups: Groups, *, described: bool = False) -> Improvement:
        """Judge an extended model on the configurations left out.

        Together it is judged by the choice that each fold makes anew, or by all that each fold describes;
        single causes by the model as it was found, with and without them.

        Parameters
        ----------
        selected : Selection
        groups : tuple of tuple of Candidate
            Its picks, by cause.
        described : bool
            Whether all cells are described too.

        Returns
        -------
        Improvement
        """
        block, result = self._fit.blocks[0], self._fit.results[0]
        config, site = block.targets.stops.config, sites(block.targets.stops)
        nested = self._nested(groups)
        after = nested.described if described else nested.chosen if groups else nested.start
        held_out = HeldOutErrors(config, result.state.position_mm, nested.start, after)
        gains = tuple(gain_of(*errors, site) for errors in _of_groups(selected, groups))
        # Of what is stated alone: the discrepancy is what a better model would not leave.
        noise_mm = expected_noise_mm(block.weighted(block.weights, 0.0))
        more = gain_of(nested.chosen, nested.described, site) if described else None
        seen_in = tuple(nested.seen_in(group) for group in groups)
        return Improvement(held_out, gains, seen_in, site, noise_mm, "cross_validation", described=more)

    def asks_for_description(self, groups: Groups) -> bool:
        """Return whether a description predicts what is left out better than the choice does.

        Parameters
        ----------
        groups : tuple of tuple of Candidate
            Picks by cause; one that runs in time has the folds be blocks of time.

        Returns
        -------
        bool
        """
        nested = self._nested(groups)
        return float((nested.described**2).sum()) < float((nested.chosen**2).sum())

    def _nested(self, groups: Groups) -> Nested:
        """Return the folds that these groups are judged by."""
        return self._in_time if _run_in_time(groups) else self._at_random

    @cached_property
    def _at_random(self) -> Nested:
        return Nested(self._first, partition(self._fit, in_time=False))

    @cached_property
    def _in_time(self) -> Nested:
        return Nested(self._first, partition(self._fit, in_time=True))


def _of_groups(selected: Selection, groups: Groups) -> tuple[Errors, ...]:
    """Return the errors without each group and with all: of what runs in time, on readings of other times."""
    found: dict[int, Errors] = {}
    for in_time in (False, True):
        here = [k for k, group in enumerate(groups) if _run_in_time((group,)) == in_time]
        parts = partition(selected.fit, in_time=in_time)
        errors = as_found(selected.fit, parts, [names_of(groups[k]) for k in here])
        found.update(zip(here, errors, strict=True))
    return tuple(found[k] for k in range(len(groups)))


def _run_in_time(groups: Groups) -> bool:
    """Whether something runs in time that configurations between others would fill in.

    What is drawn anew at each mounting is never foretold, and of legs a block in time is a placement.
    """
    cells = [signature_of(pick) for group in groups for pick in group]
    over = {cell.over for cell in cells}
    return "time" in over and "mounting" not in over and not any(map(of_legs, cells))


def on_validation(
    campaign: Campaign, fits: tuple[RobustFit, RobustFit], selected: Selection, groups: Groups
) -> Improvement | None:
    """Judge the start, the model in the end and single causes on the validation readings.

    Parameters
    ----------
    campaign : Campaign
    fits : tuple of RobustFit
        The start, and the model in the end.
    selected : Selection
        The model with the findings alone.
    groups : tuple of tuple of Candidate
        Its picks, by cause.

    Returns
    -------
    Improvement or None
        None without validation readings.
    """
    block = validation_block(campaign, selected.fit.structure)
    if block is None:
        return None
    ends = judge_estimates(block, fits[0].estimate, fits[1].estimate)
    site, found = sites(block.targets.stops), _residual(block, selected.fit.structure, selected.fit.values)
    gains = tuple(gain_of(_without(block, selected.fit, group), found, site) for group in groups)
    errors = HeldOutErrors(ends.stops.config, ends.position_mm, ends.nominal_mm, ends.identified_mm)
    beyond = _beyond(ends)
    # The same fit means that nothing was described: there is no gain to tell.
    more = None if fits[1] is selected.fit else gain_of(found, ends.identified_mm, site)
    return Improvement(errors, gains, (), site, expected_noise_mm(block), "validation", beyond, more)


def nominal_errors(campaign: Campaign, nominal: RobustFit) -> FloatArray:
    """Return the errors of the nominal robot on the readings that judge.

    Parameters
    ----------
    campaign : Campaign
    nominal : RobustFit
        Base and unknown nests alone, around the nominal robot.

    Returns
    -------
    ndarray, shape (n, d)
        On validation readings; without any, on each reading of the fit as if it had been left out [mm].
    """
    block = validation_block(campaign, nominal.structure)
    if block is None:
        return held_out_residuals(nominal)[0]
    return _residual(block, nominal.structure, nominal.values)


def _beyond(ends: Assessment) -> float:
    """Return the typical error over what noise and parameters explain; 1 where no noise is stated."""
    if ends.block.stated_sigma() == 0.0:
        return 1.0
    # By the median: a few outliers among the validation readings say nothing about the model.
    squared = (ends.identified_mm**2).sum(axis=1) / (ends.noise_variance + ends.variance)
    return float(np.sqrt(np.median(squared) / chi2_median(ends.block.components)))


def validation_block(campaign: Campaign, structure: Structure) -> ObservationBlock | None:
    """Return the validation readings as a block of a model.

    Parameters
    ----------
    campaign : Campaign
    structure : Structure
        Of the model that is judged.

    Returns
    -------
    ObservationBlock or None
        None where there are none.
    """
    readings = campaign.held_out
    return None if readings is None else observation_block(readings, campaign.scatter_mm, structure)


def _residual(block: ObservationBlock, structure: Structure, values: FloatArray) -> FloatArray:
    """Return the residuals of a model with these values (P,), shape (n, d) [mm]."""
    return block.result(structure, values, None).residual


def _without(block: ObservationBlock, full: RobustFit, group: tuple[Candidate, ...]) -> FloatArray:
    """Return the residuals of the extended model without a group, the others fitted again, shape (n, d) [mm].

    The others follow as a normal posterior's mean does where the group's values v are known to be zero: all
    values change by -C_.v C_vv^-1 v.
    """
    names = names_of(group)
    out = np.array([name in names for name in full.structure.names])
    covariance = full.solution.covariance
    values = full.values - covariance[:, out] @ solve_singular(covariance[np.ix_(out, out)], full.values[out])
    # Exactly: where C_vv is singular, the equation leaves a rest of what it does not determine.
    values[out] = 0.0
    return _residual(block, full.structure, values)
