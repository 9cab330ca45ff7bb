"""Selection: causes are added one at a time, best first, until nothing more is there than noise would give.

Within one linearisation the picks are fitted together, and each must be worth its parameters beside the
others (`chosen`). Then everything is fitted again, gross readings included, and screened anew. A candidate
is beyond chance where its corrected p value is at most 0.4 %; among those the largest gain in BIC,

    nu ln(R / (R - T)) - k ln n - 2 ln(variants searched),

comes next (decision 0015).
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from truepose.diagnosis.screening.candidates import Pool, View, pool_candidates
from truepose.diagnosis.screening.significance import Screening, screen
from truepose.effects.causes import Candidate
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.effects.signatures import plural_of
from truepose.identification.fit.robust import RobustFit, settled_fit

Group = tuple[str, tuple[Candidate, ...]]  # subject and picks

_MANY = 3  # joints that share a cause from this number on
_ORDERS_APART = 2  # waves of one joint that are told one by one; more are told together


def group_by_subject(picks: Sequence[Candidate]) -> tuple[Group, ...]:
    """Return subjects and their picks, in the order in which they were found.

    Parameters
    ----------
    picks : sequence of Candidate

    Returns
    -------
    tuple of (str, tuple of Candidate)
        One group a cause and subject; "joints" or "links" where three or more share a cause. Waves of one
        joint are separate groups up to two, and one group beyond.
    """
    groups: dict[tuple[str, str, float], list[Candidate]] = {}
    for pick in picks:
        groups.setdefault((pick.effect, _subject(pick, picks), _apart(pick, picks)), []).append(pick)
    return tuple((key[1], tuple(group)) for key, group in groups.items())


def names_of(picks: Iterable[Candidate]) -> tuple[str, ...]:
    """Return the names of all parameters of some picks.

    Parameters
    ----------
    picks : iterable of Candidate

    Returns
    -------
    tuple of str
        In the order of the picks.
    """
    return tuple(name for pick in picks for name in pick.names)


def _subject(pick: Candidate, picks: Sequence[Candidate]) -> str:
    """Return the subject under which a pick is reported: the plural where many share the cause."""
    plural = plural_of(pick.effect)
    if not plural:
        return pick.subject
    subjects = {other.subject for other in picks if other.effect == pick.effect}
    return plural if plural in subjects or len(subjects) >= _MANY else pick.subject


def _apart(pick: Candidate, picks: Sequence[Candidate]) -> float:
    """Tell waves of one joint apart by their order while they are few."""
    if pick.effect not in effects_with(Trait.WAVES):
        return 0.0
    same = [other for other in picks if (other.effect, other.subject) == (pick.effect, pick.subject)]
    return pick.variant if len(same) <= _ORDERS_APART else 0.0


LEVEL = 0.004  # chance that noise alone gives any name, over everything tried
_MOST_REFITS = 6  # each may add several picks; one or two are usual
_ROUNDS = 3  # of decisions about gross readings and discrepancy at each refit, from those before
_RESIZED = 0.2  # logarithm of the size of a function: a step of the grid on which it is searched
_READINGS_PER_PARAMETER = 2.0  # observations that each parameter must leave, all counted


Propose = Callable[[RobustFit], tuple[Candidate, ...]]


@dataclass(frozen=True, slots=True)
class Selection:
    """The extended model.

    Attributes
    ----------
    fit : RobustFit
        Of the initial model and the picks.
    picks : tuple of Candidate
        In the order in which they were found.
    pool : Pool
        Everything that was tried, linearised at `fit`.
    full : bool
        More was there, but the readings do not carry more parameters.
    """

    fit: RobustFit
    picks: tuple[Candidate, ...]
    pool: Pool
    full: bool


@dataclass(frozen=True, slots=True)
class Choice:
    """What one linearisation shows.

    Attributes
    ----------
    first : Pool
        What it was chosen from.
    picks : tuple of Candidate
    pool : Pool
        With the picks fitted, to first order.
    full : bool
        More was there, but the readings do not carry more parameters.
    """

    first: Pool
    picks: tuple[Candidate, ...]
    pool: Pool
    full: bool


def select(choice: Choice, propose: Propose, tell: Callable[[float], None]) -> Selection:
    """Extend a fitted model by what the data show.

    Parameters
    ----------
    choice : Choice
        From everything that is proposed at the fitted model.
    propose : callable
        From a fit to every way in which it may still be wrong.
    tell : callable
        Told the fraction done, from 0 to 1, never falling.

    Returns
    -------
    Selection
    """
    start = fit = choice.first.fit
    picks, pool = list[Candidate](), choice.first
    for round_number in range(_MOST_REFITS):
        tell(round_number / _MOST_REFITS)
        if not choice.picks:
            break
        picks += choice.picks
        fit = refit_picks(start, fit, picks)
        pool = pool_candidates(fit, (*picks, *propose(fit)))
        kept = _worth(picks, pool)
        if _differ(kept, picks):
            picks = kept
            fit = refit_picks(start, fit, picks)
            pool = pool_candidates(fit, (*picks, *propose(fit)))
            # What was chosen in this round went again at once: the next round would only choose it anew.
            if not any(candidate.same_as(other) for candidate in choice.picks for other in kept):
                break
        choice = chosen(pool)
    return Selection(fit, tuple(picks), pool, choice.full)


def _differ(kept: Sequence[Candidate], picks: Sequence[Candidate]) -> bool:
    """Whether some picks went, or are functions of clearly another size now."""
    if len(kept) < len(picks):
        return True
    sizes = [one.size / other.size for one, other in zip(kept, picks, strict=True)]
    return bool(np.abs(np.log(sizes)).max(initial=0.0) > _RESIZED)


def chosen(pool: Pool) -> Choice:
    """Choose what is there beyond chance, each pick still worth its parameters beside the others.

    Parameters
    ----------
    pool : Pool
        Of a fitted model without picks.

    Returns
    -------
    Choice
    """
    refuted = set[int]()
    picks = dict[int, Candidate]()
    while True:
        grown, full = _grown(pool, picks, refuted)
        kept = {index: _judged(index, pick, grown).pick for index, pick in picks.items()}
        # What went may not come back: without this, two causes that resemble each other take turns.
        refuted |= {index for index, pick in kept.items() if pick is None}
        held = {index: pick for index, pick in kept.items() if pick is not None}
        if len(held) == len(picks):
            return Choice(pool, tuple(picks.values()), grown, full)
        picks = held


def _grown(pool: Pool, picks: dict[int, Candidate], refuted: set[int]) -> tuple[Pool, bool]:
    """Add to the picks, best first, what is beyond chance; return the pool with them, and if it is full."""
    for index, pick in picks.items():
        pool = pool.beside(index, pick)
    while True:
        view = pool.view()
        screened = screen(view)
        screened.score[[*(refuted | view.taken)]] = -np.inf  # rounding leaves a little of what is fitted
        best = best_of(screened)
        if best is None:
            return pool, False
        if not _carried(view, float(screened.size[best])):
            return pool, True
        for index, pick in _parts_or_whole(view, screened, best).items():
            picks[index] = pick
            pool = pool.beside(index, pick)


def _parts_or_whole(view: View, screened: Screening, best: int) -> dict[int, Candidate]:
    """Return a few single parts of a function where they are the better story, else what was best."""
    whole = view.pool.all[best]
    if not whole.function:
        return {best: whole}
    parts, score = dict[int, Candidate](), 0.0
    while True:
        now = screen(view)
        # Only pieces of the same cause and subject can replace the function.
        now.score[[not _is_part(candidate, whole, parts.values()) for candidate in view.pool.all]] = -np.inf
        part = best_of(now)
        if part is None or not _carried(view, float(now.size[part])):
            break
        parts[part] = view.pool.all[part]
        score += float(now.score[part])
        view = view.pool.beside(part, parts[part]).view()
    # A few waves have orders and phases that can be checked; a curve has none, so it must explain more.
    return parts if score >= screened.score[best] else {best: _sized(whole, screened, best)}


def _is_part(candidate: Candidate, function: Candidate, taken: Collection[Candidate]) -> bool:
    """Whether a candidate is a single piece of a function, and not taken yet."""
    same = (candidate.effect, candidate.subject) == (function.effect, function.subject)
    return same and not candidate.function and candidate not in taken


def _sized(candidate: Candidate, screened: Screening, index: int) -> Candidate:
    """Return a candidate as large as the data ask for, where they tell it."""
    return candidate.sized(float(screened.width[index])) if candidate.function else candidate


def best_of(screened: Screening) -> int | None:
    """Return the candidate with the best score among those beyond chance.

    Parameters
    ----------
    screened : Screening
        Of C candidates.

    Returns
    -------
    int or None
        None where no candidate is beyond chance with a gain above 0.
    """
    beyond = (screened.p_value <= LEVEL) & (screened.score > 0.0)
    if not beyond.any():
        return None
    return int(np.argmax(np.where(beyond, screened.score, -np.inf)))


def _carried(view: View, parameters: float) -> bool:
    """Whether the readings carry so many more parameters: two observations each, of all that are fitted."""
    used = view.parameters + parameters
    return bool(view.sums.observations / view.sums.alike >= _READINGS_PER_PARAMETER * used)


def refit_picks(start: RobustFit, previous: RobustFit, picks: Sequence[Candidate]) -> RobustFit:
    """Fit the initial model with the picks' parameters.

    Parameters
    ----------
    start : RobustFit
        Of the model that is extended.
    previous : RobustFit
        Whose decisions about readings, and values of the parameters that it has, the fit begins from.
    picks : sequence of Candidate

    Returns
    -------
    RobustFit
    """
    structure = start.structure
    for pick in picks:
        structure = structure.extended(pick.effect, pick.specs)
    # Parameters that the previous fit lacks begin at their prior's mean; the others are nearly there already.
    known = dict(zip(previous.structure.names, previous.values.tolist(), strict=True))
    values = np.array([known.get(spec.name, spec.prior_mean) for spec in structure.specs])
    return settled_fit(structure, previous.blocks, values, rounds=_ROUNDS)


def _worth(picks: Sequence[Candidate], pool: Pool) -> list[Candidate]:
    """Return the picks that still explain more than their parameters cost, beside all others.

    Two that tell one story are each worth nothing beside the other: the worst goes alone, and the others are
    judged again without it.
    """
    placed = [(pool.index_of(pick), pick) for pick in picks]
    gone: tuple[str, ...] = ()
    while True:
        judged = [_judged(index, pick, pool, gone) for index, pick in placed]
        if all(one.pick is not None for one in judged):
            return [one.pick for one in judged if one.pick is not None]
        # One goes at a time, the worst first: both judged beside each other would go together, and with them
        # the cause.
        worst = int(np.argmin([np.inf if one.pick is not None else one.score for one in judged]))
        gone += placed.pop(worst)[1].names


class _Judged(NamedTuple):
    """A fitted pick, as large as it should be; None where it is not worth its parameters."""

    pick: Candidate | None
    score: float


def _judged(index: int, pick: Candidate, pool: Pool, gone: tuple[str, ...] = ()) -> _Judged:
    """Judge a fitted pick beside the others, those left out whose parameters are `gone`."""
    screened = screen(pool.of((index,)).view(without=(*pick.names, *gone)))
    score = float(screened.score[0])
    worth = screened.p_value[0] <= LEVEL and score > 0.0
    return _Judged(_sized(pool.all[index], screened, 0) if worth else None, score)


def reselect(
    start: RobustFit, selected: Selection, kept: tuple[Candidate, ...], propose: Propose
) -> Selection:
    """Return the selection with some of its picks only, as far as they are worth it, fitted again.

    Parameters
    ----------
    start : RobustFit
        Of the model without picks.
    selected : Selection
    kept : tuple of Candidate
        The picks that may stay; others than those of the selection may be among them.
    propose : callable
        From a fit to every way in which it may still be wrong.

    Returns
    -------
    Selection
        `full` as it was.
    """
    resized = 0
    while True:
        fit = refit_picks(start, selected.fit, kept) if kept else start
        pool = pool_candidates(fit, (*kept, *propose(fit)))
        worth = tuple(_worth(kept, pool))
        # A function whose size swings between two steps of its grid would be fitted again for ever.
        settled_down = resized == _MOST_REFITS or not _differ(worth, kept)
        if len(worth) == len(kept) and settled_down:
            return Selection(fit, kept, pool, selected.full)
        resized += len(worth) == len(kept)
        kept = worth
