"""Every change over time that is tried of a fleet, with what speaks for it."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.fleet.campaigns import Fleet
from truepose.fleet.causes import AgeingCause, instrument_cause
from truepose.fleet.instrument_scales import InstrumentDays
from truepose.fleet.mixed_model import Posterior
from truepose.fleet.trials import Change, Kind, Scope, Score, Trial, excess_of, shapes

SCOPES: Final = 4  # robots, type, instruments and campaigns: a quarter of the level each
TOGETHER: Final = 2  # changes of instruments are tried alone and in pairs, at half the level each
_FEWEST_OF_A_TYPE: Final = 2  # robots: what one does is its own
_PAIR: Final = 2
_ENOUGH_ROBOTS: Final = 8  # of fewer, one that ages would be its own measure


def trials_of(posterior: Posterior, causes: Sequence[AgeingCause]) -> Iterator[Trial]:
    """Yield every change of each robot and the type by each cause, and of each instrument's scale.

    Parameters
    ----------
    posterior : Posterior
        With the changes that are named already.
    causes : sequence of AgeingCause
        Of robots.

    Yields
    ------
    Trial
    """
    fleet = posterior.equations.fleet
    every = np.ones(len(fleet.day), dtype=bool)
    robots = [
        one
        for number, robot in enumerate(fleet.robots)
        for one in _scores(posterior, "robot", robot, fleet.robot == number)
    ]
    of_type = list(_scores(posterior, "type", "", every))
    for cause in causes:
        seen = [score.of(cause.directions) for *_, score in robots]
        excess = excess_of(seen) if len(fleet.robots) >= _ENOUGH_ROBOTS else 1.0
        for (change, shape, _), one in zip(robots, seen, strict=True):
            yield one.trial(Change(*change[:2], cause, *change[2:], shape), excess)
        for change, shape, score in of_type:
            one = score.of(cause.directions)
            yield one.trial(Change(*change[:2], cause, *change[2:], shape), excess)
    yield from _instrument_trials(posterior)


def _scores(
    posterior: Posterior, scope: Scope, of: str, among: BoolArray
) -> Iterator[tuple[tuple[Scope, str, Kind, float], FloatArray, Score]]:
    """Yield scope, whose, kind and first day, shape and score of the ways in which an arm may change."""
    fleet = posterior.equations.fleet
    for kind, since, shape in shapes(fleet.day, among):
        if scope == "type" and len(np.unique(fleet.robot[shape > 0.0])) < _FEWEST_OF_A_TYPE:
            continue
        yield (scope, of, kind, since), shape, Score(posterior, shape)


def _instrument_trials(posterior: Posterior) -> Iterator[Trial]:
    fleet = posterior.equations.fleet
    days, cause = InstrumentDays(posterior), instrument_cause(fleet)
    instrument, day = (np.array(column) for column in zip(*fleet.visits, strict=True))
    ways = [
        (shape, Change("instrument", name, cause, kind, since, shape[fleet.visit]))
        for number, name in enumerate(fleet.instruments)
        for kind, since, shape in shapes(day, instrument == number)
    ]
    each = [days.of(shape) for shape, _ in ways]
    hidden = _hidden(days, [shape for shape, _ in ways], [ratio for ratio, _ in each])
    for number, ((_, change), (ratio, chance)) in enumerate(zip(ways, each, strict=True)):
        yield Trial(change, ratio, TOGETHER * min(chance, hidden.get(number, 1.0)))


def over_visits(fleet: Fleet, change: Change) -> FloatArray:
    """Return the shape of a change of an instrument over the visits.

    Parameters
    ----------
    fleet : Fleet
    change : Change
        With its shape over the campaigns.

    Returns
    -------
    ndarray, shape (D,)
    """
    shape = np.zeros(len(fleet.visits))
    shape[fleet.visit] = change.shape
    return shape


def _hidden(days: InstrumentDays, ways: Sequence[FloatArray], ratios: Sequence[float]) -> dict[int, float]:
    """Return of the clearest change of an instrument the chance of it and another, over all pairs.

    Of the pairs with the clearest one the largest ratio counts, its chance times (ways - 1) / 2: n (n - 1) /
    2 pairs, counted per way, as the level of single changes is.
    """
    if len(ways) < _PAIR:
        return {}
    first = int(np.argmax(ratios))
    pairs = [days.of(ways[first], other) for k, other in enumerate(ways) if k != first]
    _, chance = max(pairs)
    return {first: chance * (len(ways) - 1) / _PAIR}


def beyond_chance(trials: Sequence[Trial], level: float) -> Trial | None:
    """Return the change with the largest ratio among those that chance does not explain.

    Parameters
    ----------
    trials : sequence of Trial
    level : float
        Chance of any over all scopes where nothing changes.

    Returns
    -------
    Trial or None
        None: chance explains all.
    """
    number = Counter(one.change.scope for one in trials)
    beyond = [
        one for one in trials if one.ratio > 0.0 and one.chance * number[one.change.scope] * SCOPES <= level
    ]
    return max(beyond, key=lambda one: one.ratio, default=None)


def ratio_beside(without: Posterior, change: Change, excess: float) -> float:
    """Return twice the log likelihood ratio of a change that is not in the model.

    It need not be among what is tried: a line may have begun with a campaign that was left out since.

    Parameters
    ----------
    without : Posterior
        Of the model without it.
    change : Change
    excess : float
        By which variances of its cause exceed what readings state.

    Returns
    -------
    float
    """
    if change.scope == "instrument":
        return InstrumentDays(without).of(over_visits(without.equations.fleet, change))[0]
    return Score(without, change.shape).of(change.cause.directions).judged(excess)[0]
