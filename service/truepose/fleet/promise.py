"""How accurate a new robot will be with few readings and what its type says, before it is measured.

The promise is that of plans (`planning.promise`): the configurations that tell most beside what is believed,
and the errors over the work volume that are then left. Without the type, what the usual effects cannot
express (waves and gaps) is what no parameter expresses; its size is what robots of the type show. What the
type itself is worth, apart from that its waves and gaps are parameters at all, say as many readings of the
same parameters from what is stated of any robot, and how many of these promise as much.
"""

from bisect import bisect_left
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.campaign import Campaign, Stops
from truepose.fleet.information import fleet_effects
from truepose.identification.model.derivatives import position_jacobian
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.problem.belief import Belief, with_belief
from truepose.identification.problem.build import automatic_effects, build
from truepose.planning.promise.knowledge import ArmKnowledge, Knowns, Told
from truepose.planning.promise.order import most_informative_first
from truepose.planning.promise.spread import Discrepancy, mean_norms, spread
from truepose.planning.promise.volume import VOLUME_CONFIGURATIONS, WorkVolume, sample
from truepose.planning.work_volume.candidates import draw_candidates
from truepose.planning.work_volume.work_space import WorkSpace

MOST: Final = 100  # readings without the type up to which is looked for as much
_CANDIDATES: Final = 400
_KNOWN_TO: Final = 0.1  # robots of one type differ by so much in what the usual effects lack


@dataclass(frozen=True, slots=True)
class Promised:
    """Norms of position errors over the work volume after so many configurations."""

    n: int
    mean_mm: float
    interval_90_mm: tuple[float, float]  # nine calibrations of ten have their mean error within
    joints_rad: FloatArray  # (n, J) to measure, in the order of choice
    nest: IntArray  # (n,)


@dataclass(frozen=True, slots=True)
class Promise:
    """What ways of measuring a new robot promise."""

    pooled: Promised  # with what the type says
    alone: Promised  # more readings, as a robot of no known type
    lacking_mm: float  # per axis: what the usual effects cannot express of this type
    same_mm: float  # mean error of as many readings and the same parameters, from what was stated of them
    needed: int | None  # of these readings for what the type promises; None: more than `MOST`

    @property
    def is_worth(self) -> bool:
        """Whether the type saves any reading."""
        return self.needed is None or self.needed > self.pooled.n


def promise(
    space: WorkSpace,
    belief: Belief,
    typical: Campaign,
    *,
    readings: int = 15,
    without: int = 50,
    knowns: Knowns | None = None,
    seed: int = 0,
) -> Promise:
    """Say what few readings with the type's belief promise, and more of them without.

    Parameters
    ----------
    space : WorkSpace
    belief : Belief
        Of a new robot of the type.
    typical : Campaign
        Of a robot of the type, at whose configurations is seen what the usual effects lack.
    readings, without : int
        Configurations measured with the belief, and without it.
    knowns : Knowns, optional
    seed : int
    """
    known = knowns or Knowns()
    lacking = lacking_mm(belief, typical)
    more = replace(known, discrepancy=Discrepancy(lacking, _KNOWN_TO), believed=None)
    pooled = _Measuring(space, known.believing(belief), readings, seed).promised(readings)
    same = _Measuring(space, known.believing(as_stated(belief)), MOST, seed)
    return Promise(
        pooled,
        _Measuring(space, more, without, seed).promised(without),
        lacking,
        same.mean_mm(readings),
        same.needed(pooled.mean_mm),
    )


def as_stated(belief: Belief) -> Belief:
    """Return the same parameters as they are stated of any robot."""
    means = np.array([spec.prior_mean for spec in belief.specs])
    widths = np.array([spec.prior_width for spec in belief.specs])
    return Belief(belief.specs, belief.owners, means, np.diag(widths**2))


class _Measuring:
    """Configurations in the order of choice, each the one that tells most beside those before it."""

    def __init__(self, space: WorkSpace, knowns: Knowns, most: int, seed: int) -> None:
        rng = np.random.default_rng(seed)
        candidates = draw_candidates(space, _CANDIDATES, rng)
        self._knowledge = ArmKnowledge(space, candidates, knowns)
        place = sample(space, WorkVolume(), VOLUME_CONFIGURATIONS, rng)
        self._places = self._knowledge.places(place.joints_rad, place.nest)
        told = self._knowledge.told(candidates.joints_rad, candidates.nest)
        order = most_informative_first(told.rows, most, self._knowledge.prior())
        self._told, self._chosen = Told(told.rows[order], told.held[order]), candidates.subset(order)

    def promised(self, n: int) -> Promised:
        """Return what the first n promise."""
        found = spread(self._errors(n), self._knowledge.discrepancy)
        joints_rad, nest = self._chosen.joints_rad[:n], self._chosen.nest[:n]
        return Promised(len(nest), found.mean_mm, found.interval_90_mm, joints_rad, nest)

    def mean_mm(self, n: int) -> float:
        """Return the mean error to expect of the first n."""
        return float(mean_norms(self._errors(n), self._knowledge.discrepancy.per_axis_mm).mean())

    def needed(self, mean_mm: float) -> int | None:
        """Return how many come to a mean error; None: all together do not. Each further one lowers it."""
        numbers = range(1, len(self._chosen) + 1)
        found = bisect_left(numbers, -mean_mm, key=lambda n: -self.mean_mm(n))
        return numbers[found] if found < len(numbers) else None

    def _errors(self, n: int) -> FloatArray:
        return self._knowledge.errors(Told(self._told.rows[:n], self._told.held[:n]), self._places)


def lacking_mm(belief: Belief, campaign: Campaign) -> float:
    """Return what robots of the type do that the usual effects cannot express, RMS per axis.

    Of the motions by what is believed of the other parameters, what the usual ones take up at many
    configurations (least squares) is no part of it.
    """
    problem = with_belief(build(campaign, fleet_effects(campaign)), belief)
    readings = campaign.calibration
    if readings is None:
        return 0.0
    stops: Stops = readings.stops
    state = evaluate(problem.structure, problem.start, Targets(stops, readings.nest))
    motion = position_jacobian(state).reshape(len(problem.structure.specs), -1)  # (P, 3 n)
    usual = np.isin(problem.structure.owners, automatic_effects(campaign))
    place = [problem.structure.index_of(name) for name in belief.names]
    second = belief.covariance + np.outer(belief.mean, belief.mean)
    others = [k for k, at in enumerate(place) if not usual[at]]
    basis, _ = np.linalg.qr((motion[usual] * problem.structure.prior_widths[usual, None]).T)
    moved = motion[[place[k] for k in others]]
    left = moved - (moved @ basis) @ basis.T
    freedom = max(motion.shape[1] - basis.shape[1], 1)
    return float(
        np.sqrt(max(np.einsum("pm,pq,qm->", left, second[np.ix_(others, others)], left), 0.0) / freedom)
    )
