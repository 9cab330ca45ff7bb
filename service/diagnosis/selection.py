"""Selection: causes are added one at a time, best first, until nothing more is there than noise would give.

Within one linearisation the picks are fitted together; then everything is fitted again, gross readings
included, and screened anew. At the end each pick must still be worth its parameters beside the others.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from service.diagnosis.footing import Footing, footing_of
from service.diagnosis.screening import Pool, Screened, View, pooled, screen
from service.effects.causes import Candidate
from service.identification.robust import RobustFit, settled

LEVEL = 0.004  # chance that noise alone gives any name, over everything tried
_MOST_REFITS = 6  # each may add several picks; one or two are usual
_ROUNDS = 3  # of decisions about gross readings and discrepancy at each refit, from those before
_RESIZED = 0.2  # logarithm of the size of a function: a step of the grid on which it is searched
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
        if _differ(kept, picks):
            picks = kept
            fit = refitted(start, fit, picks)
            pool = pooled(fit, (*picks, *propose(fit)))
            if not any(_same_as(candidate, other) for candidate in new for other in kept):
                break
    return Selected(fit, tuple(picks), pool, full)


def _differ(kept: Sequence[Candidate], picks: Sequence[Candidate]) -> bool:
    """Whether some picks went, or are functions of clearly another size now."""
    if len(kept) < len(picks):
        return True
    sizes = [one.size / other.size for one, other in zip(kept, picks, strict=True)]
    return bool(np.abs(np.log(sizes)).max(initial=0.0) > _RESIZED)


def _same_as(one: Candidate, other: Candidate) -> bool:
    return (one.effect, one.subject, one.names) == (other.effect, other.subject, other.names)


def _picked(pool: Pool) -> tuple[list[Candidate], bool]:
    view, footing = pool.view(), footing_of(pool.fit)
    picks: list[Candidate] = []
    while True:
        screened = screen(view)
        best = best_of(screened)
        if best is None or pool.all[best] in picks:  # rounding may leave a little of what is fitted
            return picks, False
        if not _carried(footing, float(screened.size[best])):
            return picks, True
        if pool.all[best].function:  # what it leaves to others is told once it is fitted
            return [*picks, *_parts_or_whole(view, footing, screened, best)], False
        picks.append(pool.all[best])
        view, footing = view.with_pick(best, footing)


def _parts_or_whole(view: View, footing: Footing, screened: Screened, whole: int) -> list[Candidate]:
    """Return a few single parts of a function where they are the better story, else the function."""
    function = view.pool.all[whole]
    parts, score = list[Candidate](), 0.0
    while True:
        now = screen(view)
        now.score[[not _is_part(candidate, function, parts) for candidate in view.pool.all]] = -np.inf
        best = best_of(now)
        if best is None or not _carried(footing, float(now.size[best])):
            break
        parts.append(view.pool.all[best])
        score += float(now.score[best])
        view, footing = view.with_pick(best, footing)
    return parts if score >= screened.score[whole] else [_sized(function, screened, whole)]


def _is_part(candidate: Candidate, function: Candidate, taken: Sequence[Candidate]) -> bool:
    same = (candidate.effect, candidate.subject) == (function.effect, function.subject)
    return same and not candidate.function and candidate not in taken


def _sized(candidate: Candidate, screened: Screened, index: int) -> Candidate:
    """Return a candidate as large as the data ask for, where they tell it."""
    return candidate.sized(float(screened.width[index])) if candidate.function else candidate


def best_of(screened: Screened) -> int | None:
    """Return the candidate with the best score among those beyond chance; None where there is none."""
    beyond = (screened.p_value <= LEVEL) & (screened.score > 0.0)
    if not beyond.any():
        return None
    return int(np.argmax(np.where(beyond, screened.score, -np.inf)))


def _carried(footing: Footing, parameters: float) -> bool:
    used = footing.basis.shape[1] + parameters
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
            kept.append(_sized(pick, screened, index))
    return kept


def reselected(
    start: RobustFit, selected: Selected, kept: tuple[Candidate, ...], propose: Propose
) -> Selected:
    """Return the selection with some of its picks only, as far as they are worth it, fitted again."""
    resized = 0
    while True:
        fit = refitted(start, selected.fit, kept) if kept else start
        pool = pooled(fit, (*kept, *propose(fit)))
        worth = tuple(_worth(kept, pool))
        settled_down = resized == _MOST_REFITS or not _differ(worth, kept)
        if len(worth) == len(kept) and settled_down:
            return Selected(fit, kept, pool, selected.full)
        resized += len(worth) == len(kept)
        kept = worth
