"""Cross-validation by configuration, all folds from one linearisation.

Parameters are fitted to the other readings to first order, and the held-out ones keep what these predict:
with J the derivatives of the held-out readings, r their residuals at the common fit, and s the step that the
others ask for (`Projection.step`), their errors are r - J s. Without each fold the choice is made anew from
the start (nested), or a model is taken as it was found and only its parameters are fitted anew.

References
----------
M. Stone, J. Royal Statistical Society B 36(2), 1974, 111-147 (choice within cross-validation).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from truepose.diagnosis.evidence.signature_functions import signatures_in_data
from truepose.diagnosis.screening.candidates import Pool, candidate_motions
from truepose.diagnosis.screening.normal_equations import NormalEquations, normal_of
from truepose.diagnosis.screening.selection import Choice, chosen
from truepose.diagnosis.screening.significance import screen
from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.campaign import sites
from truepose.effects.causes import Candidate
from truepose.identification.fit.robust import RobustFit

_CHANCE = 0.05  # of noise alone, for one candidate
_FOLDS = 5  # four fifths of the configurations choose: nearly as well as all


class Errors(NamedTuple):
    """Errors on configurations held out, of a model and of what it is compared with.

    Attributes
    ----------
    before, after : ndarray, shape (n, d)
        [mm].
    """

    before: FloatArray
    after: FloatArray


@dataclass(frozen=True, slots=True)
class _Fold:
    """Readings that are held out, and what the others choose."""

    out: IntArray  # (o,) of the first block
    choice: Choice


def partition(fit: RobustFit, *, in_time: bool) -> tuple[IntArray, ...]:
    """Part the configurations of the first block into folds.

    Parameters
    ----------
    fit : RobustFit
    in_time : bool
        Blocks of time, so that a drift must be extrapolated and cannot be interpolated; else at random, with
        a fixed seed.

    Returns
    -------
    tuple of ndarray of int
        Configurations of each of five folds; revisits lie in that of the configuration they revisit.
    """
    site, time_s = _sites(fit), fit.blocks[0].targets.stops.time_s
    unique = np.unique(site)
    if not in_time or time_s is None:
        return tuple(np.array_split(np.random.default_rng(0).permutation(unique), _FOLDS))
    known = np.nan_to_num(time_s, nan=-np.inf)
    begun = [float(known[site == one].min()) for one in unique.tolist()]
    return tuple(np.array_split(unique[np.argsort(begun, kind="stable")], _FOLDS))


class Nested:
    """The choice made anew without each part of the configurations.

    The readings of a fold take no part in the choice that they judge, neither in the picks nor in their
    sizes; only the list of candidates, and the weights, come from all readings.
    """

    def __init__(self, first: Choice, parts: Sequence[IntArray]) -> None:
        self._fit = first.first.fit
        likely = _likely(first)
        self._folds = tuple(
            _Fold(out, chosen(likely.of_rows(_others(self._fit, held))))
            for held, out in _held(self._fit, parts)
        )

    @cached_property
    def start(self) -> FloatArray:
        """Errors of the initial model, shape (n, d) [mm]."""
        return self._errors(lambda choice: ((), choice.first.normal))

    @cached_property
    def chosen(self) -> FloatArray:
        """Errors of what is chosen, shape (n, d) [mm]."""
        return self._errors(lambda choice: (choice.picks, choice.pool.normal))

    @cached_property
    def described(self) -> FloatArray:
        """Errors of the full description, shape (n, d) [mm]."""
        return self._errors(_described)

    def seen_in(self, group: Sequence[Candidate]) -> int:
        """Return how many folds choose something of a group too.

        Parameters
        ----------
        group : sequence of Candidate
            Compared by cause and subject: another order of the same joint's wave counts.

        Returns
        -------
        int
        """
        asked = {(pick.effect, pick.subject) for pick in group}
        return sum(
            any((pick.effect, pick.subject) in asked for pick in fold.choice.picks) for fold in self._folds
        )

    def _errors(self, model: Callable[[Choice], tuple[Sequence[Candidate], NormalEquations]]) -> FloatArray:
        """Return the errors of the model that each fold chooses, shape (n, d); of no fold, 0."""
        result = self._fit.results[0]
        errors = np.zeros_like(result.residual)
        for fold in self._folds:
            picks, normal = model(fold.choice)
            # In the order of the normal equations: the fitted parameters first, then those that were added
            # beside them.
            motion = np.concatenate([result.jacobian, *candidate_motions(self._fit, picks)])
            errors[fold.out] = _left(result.residual[fold.out], motion[:, fold.out], normal)
        return errors


def _described(choice: Choice) -> tuple[Sequence[Candidate], NormalEquations]:
    """Return all cells that a choice asks for, and the normal equations with them."""
    whole = signatures_in_data(choice.pool, choice.picks)
    # Beside the start, where the picks are not fitted: they are among the cells, each by itself.
    return whole.candidates, whole.fitted(choice.first)


def _likely(first: Choice) -> Pool:
    """Return the candidates that readings may choose which are four fifths of all.

    What is chance with all of them, at the start and beside the picks, is not beyond it a thousand times over
    without a fifth of them.
    """
    alone = [screen(pool.view()).alone for pool in (first.first, first.pool)]
    return first.first.of(np.flatnonzero(np.minimum(*alone) < _CHANCE).tolist())


def as_found(
    fit: RobustFit, parts: Sequence[IntArray], groups: Sequence[tuple[str, ...]]
) -> tuple[Errors, ...]:
    """Return the errors of a fitted model without each group of its parameters, and with all.

    Parameters
    ----------
    fit : RobustFit
    parts : sequence of ndarray of int
        Configurations of each fold.
    groups : sequence of tuple of str
        Names of parameters.

    Returns
    -------
    tuple of Errors
        One a group: `before` without it, `after` with all.
    """
    result = fit.results[0]
    errors = tuple(Errors(*np.zeros((2, *result.residual.shape))) for _ in groups)
    for held, out in _held(fit, parts) if groups else ():
        normal = normal_of(fit, _others(fit, held))
        readings = result.residual[out], result.jacobian[:, out]
        after = _left(*readings, normal)
        for into, without in zip(errors, groups, strict=True):
            into.before[out], into.after[out] = _left(*readings, normal, without), after
    return errors


def _held(fit: RobustFit, parts: Sequence[IntArray]) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield the configurations of each part, and their readings in the first block."""
    for held in parts:
        out = np.flatnonzero(np.isin(_sites(fit), held))
        if out.size:
            yield held, out


def _left(
    residual: FloatArray, motion: FloatArray, normal: NormalEquations, without: tuple[str, ...] = ()
) -> FloatArray:
    """Return residuals (o, d) once the parameters took their step, those of motion (P, o, d).

    Parameters that are left out go to zero, which is the expectation of what a cause adds.
    """
    past = normal.past(without)
    step = np.where(past.kept, 0.0, -normal.values)
    step[past.kept] = past.step()
    return np.asarray(residual - np.tensordot(step, motion, 1))


def _sites(fit: RobustFit) -> IntArray:
    """Return the configuration of each reading of the first block, shape (n,); revisits have the first's."""
    return sites(fit.blocks[0].targets.stops)


def _others(fit: RobustFit, held: IntArray) -> BoolArray:
    """Return the stacked observations that are not of the configurations held out, shape (m,)."""
    kept = []
    for block, result in zip(fit.blocks, fit.results, strict=True):
        # Fixed nests and certificates stay: they are no readings of the arm, and hold the frame in every
        # fold.
        out = np.isin(sites(block.targets.stops), held) & block.of_arm
        kept.append(np.repeat(~out, result.residual.shape[1]))
    return np.concatenate(kept)
