"""How accurate a new robot will be with few readings and what its type says, before it is measured.

The promise is that of plans (`planning.promise`): the configurations that tell most beside what is believed,
and the errors over the work volume that are then left. Without the type, what the usual effects cannot
express (waves and gaps) is what no parameter expresses; its size is what robots of the type show.
"""

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
from truepose.planning.promise.spread import Discrepancy, spread
from truepose.planning.promise.volume import VOLUME_CONFIGURATIONS, WorkVolume, sample
from truepose.planning.work_volume.candidates import draw_candidates
from truepose.planning.work_volume.work_space import WorkSpace

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
    """What two ways of measuring a new robot promise."""

    pooled: Promised  # with what the type says
    alone: Promised  # as a robot of no known type
    lacking_mm: float  # per axis: what the usual effects cannot express of this type


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
    return Promise(
        _promised(space, known.believing(belief), readings, seed),
        _promised(space, more, without, seed),
        lacking,
    )


def _promised(space: WorkSpace, knowns: Knowns, n: int, seed: int) -> Promised:
    """Return what n of many candidates promise, each the one that tells most beside those before it."""
    rng = np.random.default_rng(seed)
    candidates = draw_candidates(space, _CANDIDATES, rng)
    knowledge = ArmKnowledge(space, candidates, knowns)
    place = sample(space, WorkVolume(), VOLUME_CONFIGURATIONS, rng)
    told = knowledge.told(candidates.joints_rad, candidates.nest)
    order = most_informative_first(told.rows, n, knowledge.prior())
    errors = knowledge.errors(
        Told(told.rows[order], told.held[order]), knowledge.places(place.joints_rad, place.nest)
    )
    found = spread(errors, knowledge.discrepancy)
    chosen = candidates.subset(order)
    return Promised(len(order), found.mean_mm, found.interval_90_mm, chosen.joints_rad, chosen.nest)


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
