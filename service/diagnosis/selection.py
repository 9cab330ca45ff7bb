"""Selection: causes are added one at a time, best first, until nothing more is there than noise would give.

Within one linearisation the picks are fitted together; then everything is fitted again, gross readings
included, and screened anew. At the end each pick must still be worth its parameters beside the others.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from service.diagnosis.footing import Footing, footing_of
from service.diagnosis.screening import Pool, Screened, pooled, screen
from service.effects.causes import Candidate
from service.identification.robust import RobustFit, settled

LEVEL = 0.004  # chance that noise alone gives any name, over everything tried
_MOST_REFITS = 6  # each may add several picks; one or two are usual
_ROUNDS = 3  # of decisions about gross readings and discrepancy at each refit, from those before
_READINGS_PER_PARAMETER = 2.0  # observations that each parameter must leave, all counted


Propose = Callable[[RobustFit], tuple[Candidate, ...]]


@dataclass(frozen=True, slots=True)
class Selected:
    """The extended model: picks in the order in which they were found."""

    fit: RobustFit
    picks: tuple[Candidate, ...]
    pool: Pool  # everything that was tried, linearised at `fit`
    full: bool  # more was there, but the readings do not carry more parameters


def select(start: RobustFit, propose: Propose, tell: Callable[[float], None]) -> Selected:
    """Extend a fitted model by what the data show.

    Parameters
    ----------
    start : RobustFit
    propose : callable
        Every way in which a fitted model may still be wrong.
    tell : callable
        Told the fraction done.

    Returns
    -------
    Selected
    """
    fit, picks, full = start, list[Candidate](), False
    pool = pooled(fit, propose(fit))
    for round_number in range(_MOST_REFITS):
        tell(round_number / _MOST_REFITS)
        new, full = _picked(pool)
        if not new:
            break
        picks += new
        fit = refitted(start, fit, picks)
        pool = pooled(fit, (*picks, *propose(fit)))
        kept = _worth(picks, pool)
        if len(kept) < len(picks):
            picks = kept
            fit = refitted(start, fit, picks)
            pool = pooled(fit, (*picks, *propose(fit)))
            if not any(candidate in kept for candidate in new):
                break
    return Selected(fit, tuple(picks), pool, full)


def _picked(pool: Pool) -> tuple[list[Candidate], bool]:
    view, footing = pool.view(), footing_of(pool.fit)
    picks: list[Candidate] = []
    while True:
        best = best_of(screen(view))
        if best is None or pool.all[best] in picks:  # rounding may leave a little of what is fitted
            return picks, False
        if not _carried(footing, pool.all[best]):
            return picks, True
        picks.append(pool.all[best])
        view, footing = view.with_pick(best, footing)


def best_of(screened: Screened) -> int | None:
    """Return the candidate with the best score among those beyond chance; None where there is none."""
    beyond = (screened.p_value <= LEVEL) & (screened.score > 0.0)
    if not beyond.any():
        return None
    return int(np.argmax(np.where(beyond, screened.score, -np.inf)))


def _carried(footing: Footing, candidate: Candidate) -> bool:
    used = footing.basis.shape[1] + len(candidate.specs)
    return bool(footing.observations / footing.alike >= _READINGS_PER_PARAMETER * used)


def refitted(start: RobustFit, previous: RobustFit, picks: Sequence[Candidate]) -> RobustFit:
    """Fit the start model with the picks' parameters, from the values of another fit where it has them."""
    structure = start.structure
    for pick in picks:
        structure = structure.extended(pick.effect, pick.specs)
    known = dict(zip(previous.structure.names, previous.values.tolist(), strict=True))
    values = np.array([known.get(spec.name, spec.prior_mean) for spec in structure.specs])
    return settled(structure, previous.blocks, values, rounds=_ROUNDS)


def _worth(picks: Sequence[Candidate], pool: Pool) -> list[Candidate]:
    """Return the picks that still explain more than their parameters cost, beside all others."""
    kept = []
    for pick in picks:
        screened = screen(pool.view(without=pick.names))
        index = pool.all.index(pick)
        if screened.p_value[index] <= LEVEL and screened.score[index] > 0.0:
            kept.append(pick)
    return kept


def reselected(
    start: RobustFit, selected: Selected, kept: tuple[Candidate, ...], propose: Propose
) -> Selected:
    """Return the selection with some of its picks only, as far as they are worth it, fitted again."""
    while True:
        fit = refitted(start, selected.fit, kept) if kept else start
        pool = pooled(fit, (*kept, *propose(fit)))
        worth = tuple(_worth(kept, pool))
        if worth == kept:
            return Selected(fit, kept, pool, selected.full)
        kept = worth
