"""Which robot, the type, or which instrument changes over months, since when, and what else it may be.

Every cause of every robot, of the type as a whole and of every instrument is tried as a line over time, since
the first campaign or a later one, as a step at every campaign, and as a single day. No robot is otherwise on
one day alone: such a campaign, and one that is unlike its robot in everything, is left out instead. The
level, 1 % of fleets in which nothing changes, is held over everything that is tried: a quarter each for
robots, type, instruments and campaigns, divided evenly (Bonferroni). How far the scores of a cause scatter
beyond what readings state, all robots tell together. Of what is beyond chance the largest likelihood ratio is
taken into the model, all variances are estimated anew, and all is tried again until nothing is beyond chance;
what later changes explain is taken out again. Rivals of a change explain what it explains, without it, at
odds of no worse than twenty to one. What grows began before anybody measured, unless such odds speak for a
later month: a beginning is one thing more to choose.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.robot import Robot
from truepose.fleet.campaigns import Fleet
from truepose.fleet.candidate_changes import (
    SCOPES,
    TOGETHER,
    beyond_chance,
    over_visits,
    ratio_beside,
    trials_of,
)
from truepose.fleet.causes import AgeingCause, robot_causes
from truepose.fleet.instrument_scales import InstrumentDays
from truepose.fleet.mixed_model import Equations, Estimate, Posterior, estimate
from truepose.fleet.outlying_campaigns import (
    OutlyingCampaign,
    best_fitting_robots,
    birge_ratios,
    most_unlike,
    unlike,
)
from truepose.fleet.trials import Change, Scope, Score, Trial, seen_of
from truepose.identification.distributions import chi2_exceeded

LEVEL: Final = 0.01
_RIVAL: Final = 6.0  # twice the log of odds of twenty to one
_SAME_RATIO: Final = 0.05  # of variances
_MOST: Final = 40  # changes; a fleet with more has another trouble


@dataclass(frozen=True, slots=True)
class RealChange:
    """A change that is beyond chance.

    Attributes
    ----------
    trial : Trial
    amount : ndarray, shape (q,)
        At the end, in stated widths along its directions.
    covariance : ndarray, shape (q, q)
    size_mm : float
        Root mean square of what it moves at the measured configurations; of a scale at them too.
    size_u_mm : float
        Standard uncertainty.
    rivals : tuple of Trial
        Best first.
    """

    trial: Trial
    amount: FloatArray
    covariance: FloatArray
    size_mm: float
    size_u_mm: float
    rivals: tuple[Trial, ...]

    @property
    def change(self) -> Change:
        """What changed."""
        return self.trial.change


@dataclass(frozen=True, slots=True)
class AlternativesTried:
    """What was tried beside the changes that are named."""

    causes: tuple[AgeingCause, ...]  # of robots and the type
    excess: tuple[float, ...]  # of each: by which its variances exceed what the readings state
    number: Mapping[Scope, int]
    level: float

    def chance(self, scope: Scope) -> float:
        """Return the chance up to which one try is beyond what chance gives over all.

        level / (scopes x tries of the scope), of an instrument half of that (Bonferroni): its changes are
        tried in pairs too.

        Parameters
        ----------
        scope : str
            "robot", "type" or "instrument".

        Returns
        -------
        float
        """
        together = TOGETHER if scope == "instrument" else 1
        return self.level / (together * SCOPES * max(self.number.get(scope, 0), 1))


@dataclass(frozen=True, slots=True)
class Account:
    """What the campaigns of a fleet say."""

    fleet: Fleet  # with its information as it counts
    estimated: Estimate  # with the named changes in the model
    birge_ratios: FloatArray  # (R,) of variances; 1: campaigns of a robot scatter as their readings say
    named: tuple[RealChange, ...]
    tries: AlternativesTried
    unlike: tuple[OutlyingCampaign, ...] = ()  # campaigns that were left out; places as they were given

    @property
    def birge_ratio(self) -> float:
        """Ratio of variances of the middle robot: none is divided by less."""
        return float(self.birge_ratios.min())

    @property
    def tried(self) -> int:
        """How many ways of changing were tried."""
        return sum(self.tries.number.values())


def account_of(fleet: Fleet, robot: Robot | None = None, level: float = LEVEL) -> Account:
    """Return what is shared, what differs, and what changes.

    Parameters
    ----------
    fleet : Fleet
    robot : Robot, optional
        Nominal; with it, growth of all lengths is among what a robot may do.
    level : float
        Chance that something is named in a fleet in which nothing changes.

    Returns
    -------
    Account
        Places of campaigns that were left out are those of `fleet`.
    """
    estimated = estimate(Equations(fleet))
    plain, ratios = fleet, birge_ratios(estimated.posterior)
    # Variances between robots were estimated with readings taken for better than they were.
    if ratios.max() > 1.0:
        fleet = plain.divided(ratios)
        estimated = estimate(Equations(fleet), estimated.variances)
    causes = robot_causes(fleet, robot)
    sought = _Sought(plain, ratios, estimated, causes, level)
    while len(sought.found) < _MOST and sought.take_the_best():
        pass
    # Only once all is named: what robots do is scatter of the days until it is in the model.
    sought.drop_instruments_by_chance()
    estimated, found = sought.estimated, sought.found
    named = tuple(_named(estimated, found, number, causes) for number in range(len(found)))
    others = best_fitting_robots(fleet, sought.unlike, estimated.variances)
    tries = _tries(causes, sought.trials, level)
    return Account(sought.fleet, estimated, sought.ratios, named, tries, others)


def _tries(causes: tuple[AgeingCause, ...], trials: Sequence[Trial], level: float) -> AlternativesTried:
    number = Counter[Scope](one.change.scope for one in trials)
    excess = {one.change.cause.key: one.excess for one in trials}
    return AlternativesTried(causes, tuple(excess.get(cause.key, 1.0) for cause in causes), number, level)


class _Sought:
    """What was found so far, and all that may be found next."""

    def __init__(
        self,
        plain: Fleet,
        ratios: FloatArray,
        estimated: Estimate,
        causes: Sequence[AgeingCause],
        level: float,
    ) -> None:
        self._plain, self.ratios = plain, ratios  # with information as readings say, and over what it counts
        self.estimated, self._causes, self._level = estimated, causes, level
        self.found: list[Trial] = []
        self.unlike: list[OutlyingCampaign] = []
        self._dropped: set[tuple[str | float, ...]] = set()
        self._kept = np.arange(len(self.fleet.day))
        self.trials = tuple(trials_of(estimated.posterior, causes))

    @property
    def fleet(self) -> Fleet:
        """Campaigns that are compared."""
        return self.estimated.posterior.equations.fleet

    def take_the_best(self) -> bool:
        """Take what explains most into the model: a change, or a campaign out of it; False: nothing does."""
        best = self._since_the_first(beyond_chance(self.trials, self._level))
        other = most_unlike(self.estimated.posterior, self._level / SCOPES, self._changing)
        # Whatever explains more goes first: a campaign of another robot was named as fourteen changes
        # where changes went first.
        if other is not None and (best is None or other.ratio > best.ratio):
            self._leave_out((other,))
        # No robot is otherwise on one day alone (docs/decisions/0064).
        elif best is not None and best.change.scope == "robot" and best.change.kind == "day":
            self._take_out(best)
        elif best is not None:
            self._take_in(best)
        else:
            return False
        return True

    def _since_the_first(self, best: Trial | None) -> Trial | None:
        """Return the same growth since the first campaign where nothing much speaks for a later beginning."""
        if best is None or best.change.kind != "linear":
            return best
        alike = (one for one in self.trials if one.change.grows_as(best.change))
        first = min(alike, key=lambda one: one.change.since)
        # Without it 3 of 20 planted changes, all of them waves, began a month late
        # (docs/decisions/0064).
        return first if first.ratio >= best.ratio - _RIVAL else best

    def _take_in(self, best: Trial) -> None:
        """Take a change into the model, if it stands out from what other causes still show there."""
        self.found.append(_of_its_size(self.estimated.posterior, best))
        self._estimate()
        if best.change.scope != "instrument" and not self._stands_out(best):
            self._drop(len(self.found) - 1)
        self._drop_the_explained()

    def _take_out(self, best: Trial) -> None:
        """Leave out what a robot showed on one day only, if it stands out from what other causes show there.

        A cause that is named already does not go evenly; that is no fault of a campaign.
        """
        change = best.change
        if self._changing(change.of)[change.cause.directions.any(axis=1)].any() or not self._stands_out(best):
            self._dropped.add(change.key)
            self.trials = self._untried(self.trials)
        else:
            places = np.flatnonzero(change.shape).tolist()
            self._leave_out([unlike(self.fleet, place, best.ratio, best.excess) for place in places])

    def drop_instruments_by_chance(self) -> None:
        """Take changes of instruments out of the model again that are none beside the others, for good."""
        # Backwards: to drop one leaves the numbers of those before it.
        for number in reversed(range(len(self.found))):
            if self.found[number].change.scope == "instrument" and not self._is_beside(number):
                self._drop(number)

    def _is_beside(self, number: int) -> bool:
        """Return whether a change of an instrument is beyond chance beside all other changes."""
        others = [one.named for k, one in enumerate(self.found) if k != number]
        days = InstrumentDays(estimate(Equations(self.fleet, others), self.estimated.variances).posterior)
        _, chance = days.of(over_visits(self.fleet, self.found[number].change))
        return self._is_beyond(TOGETHER * chance, "instrument")

    def _stands_out(self, trial: Trial) -> bool:
        """Return whether a change is beyond chance even where its campaigns scatter as other causes show."""
        change = trial.change
        beside = (one for one in self.trials if one.change.beside(change))
        others = [one for one in beside if one.change.cause.key != change.cause.key]
        return self._is_beyond(trial.chance_beside(others), change.scope)

    def _changing(self, robot: str) -> BoolArray:
        """Return which parameters named changes of a robot or the type concern, the scale last, (P + 1,)."""
        own = [one.change.cause.directions.any(axis=1) for one in self.found if one.change.of in {robot, ""}]
        return np.asarray(np.any([np.zeros(len(self.fleet.specs) + 1, dtype=bool), *own], axis=0))

    def _drop(self, number: int) -> None:
        # For good: tried again it would be the best again.
        self._dropped.add(self.found.pop(number).change.key)
        self._estimate()

    def _drop_the_explained(self) -> None:
        """Take changes that others explain out of the model again, the least certain first, for good."""
        while (least := self._least_certain()) is not None:
            self._drop(least)

    def _least_certain(self) -> int | None:
        """Return which change of a robot or the type chance explains best beside the others, if it does."""
        places = [k for k, one in enumerate(self.found) if one.change.scope != "instrument"]
        chances = [_chance_beside(self.estimated.posterior, k, self.found[k]) for k in places]
        if not places:
            return None
        chance, least = max(zip(chances, places, strict=True))
        return None if self._is_beyond(chance, self.found[least].change.scope) else least

    def _is_beyond(self, chance: float, scope: Scope) -> bool:
        """Return whether a try has too small a chance to be one over all that is tried."""
        tried = sum(one.change.scope == scope for one in self.trials)
        return chance * tried * SCOPES <= self._level

    def _leave_out(self, others: Sequence[OutlyingCampaign]) -> None:
        self.unlike += [replace(one, place=int(self._kept[one.place])) for one in others]
        kept = np.delete(np.arange(len(self._kept)), [one.place for one in others])
        self.found = _over_campaigns(self.found, kept, self.fleet.day)
        self._kept = self._kept[kept]
        self._plain = self._plain.of_campaigns(kept)
        self._estimate()
        self._drop_the_explained()

    def _estimate(self) -> None:
        """Estimate anew, by how much each robot scatters as well: what is named is no scatter."""
        self._estimate_at(self.ratios)
        ratios = birge_ratios(self.estimated.posterior, self.ratios)
        # All variances are estimated once more: not for ratios that hardly moved.
        if np.any(np.abs(ratios / self.ratios - 1.0) > _SAME_RATIO):
            self._estimate_at(ratios)
        self.trials = self._untried(trials_of(self.estimated.posterior, self._causes))

    def _estimate_at(self, ratios: FloatArray) -> None:
        self.ratios = ratios
        equations = Equations(self._plain.divided(ratios), [one.named for one in self.found])
        self.estimated = estimate(equations, self.estimated.variances)

    def _untried(self, trials: Iterable[Trial]) -> tuple[Trial, ...]:
        """Return what is neither in the model nor was taken out of it for good."""
        tried = self._dropped | {one.change.key for one in self.found}
        return tuple(one for one in trials if one.change.key not in tried)


def _of_its_size(posterior: Posterior, trial: Trial) -> Trial:
    """Return a change with the variance of its size before any reading: a stated width's, or its own.

    A change of many widths would be held back by a width's, and what is left of it be named once more.
    """
    seen = Score(posterior, trial.change.shape).of(trial.change.cause.directions)
    return replace(trial, variance=max(1.0, seen.likeliest_variance(trial.excess)))


def _chance_beside(posterior: Posterior, number: int, named: Trial) -> float:
    """Return the chance of as much of a named change as is left beside the others.

    With its posterior N(v, C) at a prior of variance s, the readings alone say (C^-1 - I / s) with the score
    C^-1 v.
    """
    place = posterior.equations.of_change(number)
    told = np.linalg.inv(posterior.covariance[place, place])
    alone = told - np.eye(len(told)) / named.variance  # without what was believed beforehand
    squares = seen_of(told @ posterior.shared[place], alone).squares
    return chi2_exceeded(float(squares.sum()) / named.excess, float(len(squares))) if len(squares) else 1.0


def _over_campaigns(found: Sequence[Trial], kept: IntArray, day: FloatArray) -> list[Trial]:
    """Return changes over the campaigns that are kept, but those that none of them saw.

    `day` is that of all campaigns, (C,).
    """
    seen = (one for one in found if one.change.shape[kept].any())
    each = [replace(one, change=_over(one.change, kept, day[kept])) for one in seen]
    # Two steps are one where all campaigns between them are left out.
    return list({one.change.key: one for one in each}.values())


def _over(change: Change, kept: IntArray, day: FloatArray) -> Change:
    shape = change.shape[kept]
    # A line began when it began, whether or not that campaign counts; a step is seen first where it is seen.
    since = change.since if change.kind == "linear" else float(day[shape > 0.0].min())
    return replace(change, since=since, shape=shape / shape.max())


def _named(
    estimated: Estimate, found: Sequence[Trial], number: int, causes: Sequence[AgeingCause]
) -> RealChange:
    """Return a change with its size, sqrt(v' E' M E v), and the size's uncertainty, to first order.

    M is the mean of products of motions; the slope of the size by v is E' M E v / size.
    """
    posterior = estimated.posterior
    place = posterior.equations.of_change(number)
    amount = posterior.shared[place]
    covariance = found[number].excess * posterior.covariance[place, place]
    motion = posterior.equations.fleet.motion_mm2
    directions = found[number].change.cause.directions
    size = float(np.sqrt(max(amount @ directions.T @ motion @ directions @ amount, 0.0)))
    slope = directions.T @ motion @ directions @ amount / max(size, 1e-300)
    spread = float(np.sqrt(slope @ covariance @ slope))
    return RealChange(
        found[number], amount, covariance, size, spread, _rivals(estimated, found, number, causes)
    )


def _rivals(
    estimated: Estimate, found: Sequence[Trial], number: int, causes: Sequence[AgeingCause]
) -> tuple[Trial, ...]:
    """Return what else explains a change nearly as well, the others staying in the model."""
    others = [one.named for k, one in enumerate(found) if k != number]
    own = found[number].change
    equations = Equations(estimated.posterior.equations.fleet, others)
    # An instrument's days are free again without its change.
    without = (
        estimate(equations, estimated.variances).posterior
        if own.scope == "instrument"
        else Posterior(equations, estimated.variances)
    )
    trials = tuple(trials_of(without, causes))
    # What it explains without itself in the model: beside itself it would explain nothing.
    alike = (one.excess for one in trials if one.change.cause.key == own.cause.key)
    best = ratio_beside(without, own, next(alike, found[number].excess))
    close = (one for one in trials if one.ratio >= best - _RIVAL and not one.change.same_as(own))
    return tuple(sorted(close, key=lambda one: -one.ratio))
