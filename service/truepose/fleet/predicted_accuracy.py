"""What a fleet says beforehand of a robot, and how accurate a new one will be with few readings.

A further robot of the type is believed to be

    p ~ N(m, C_m + diag((v + u(v)) t))        t = max(1, (t_95 / 1.96)^2 / (1 + sqrt(2 / (R - 1))))

with m and C_m of the type, variances v between its R robots and their standard uncertainties u(v), and t_95
the 95 % of Student's t with R - 1 degrees of freedom. With J the motions by parameters that the usual effects
lack, what those cannot take up is J - U U' J, U a basis of the motions by the usual ones.

The promise is that of plans (`planning.prediction`): the configurations that tell most beside what is
believed, and the errors over the work volume that are then left. Without the type, what the usual effects
cannot express (waves and gaps) is what no parameter expresses; its size is what robots of the type show. What
the type itself is worth, apart from that its waves and gaps are parameters at all, say as many readings of
the same parameters from what is stated of any robot, and how many of these promise as much.
"""

from bisect import bisect_left
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.special import stdtrit

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Campaign, Stops
from truepose.fleet.campaigns import fleet_effects
from truepose.fleet.changes import Account
from truepose.fleet.mixed_model import uncertainties
from truepose.identification.distributions import WITHIN_95
from truepose.identification.model.derivatives import position_jacobian
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.problem.build import JointPrior, automatic_effects, build, with_belief
from truepose.planning.observability import most_informative_first
from truepose.planning.prediction.errors import Discrepancy, error_distribution, mean_norms
from truepose.planning.prediction.expected_covariance import ArmKnowledge, PriorKnowledge, ReadingInformation
from truepose.planning.prediction.plan import VOLUME_CONFIGURATIONS, WorkVolume, sample
from truepose.planning.workspace.candidates import draw_candidates
from truepose.planning.workspace.space import WorkSpace

_HELD: Final = 0.95
_SMALLEST: Final = 1e-10  # of stated variances: rounding leaves no variance below 0


def of_a_new_robot(account: Account) -> JointPrior:
    """Return what is believed of a robot of the type that was never measured.

    Its mean is that of the type. The variances between robots are themselves estimated: each counts with its
    standard uncertainty on top, so that one that came out as nothing by chance is not taken at its word. Of R
    robots a further one lies where Student's t with R - 1 degrees of freedom has it, whose 95 % are six times
    as wide as those of a normal distribution where R is 2, and 7 % wider where it is 20: where that is more,
    the variance is made as wide.

    Parameters
    ----------
    account : Account

    Returns
    -------
    JointPrior
        In the parameters' own units.
    """
    posterior = account.estimated.posterior
    own = slice(len(account.fleet.specs))
    variances = account.estimated.variances.robot
    # Plain variances of two robots that happened to be alike promised 0.036 mm where 0.117 and 0.305 came
    # out.
    between = variances + uncertainties(account.estimated)
    between *= _of_few(len(account.fleet.robots))
    return _belief(account, posterior.shared[own], posterior.covariance[own, own] + np.diag(between))


def _of_few(robots: int) -> float:
    """Return by what a variance of so few robots, with its uncertainty on top, is still too small.

    A variance of n = R - 1 degrees of freedom has the relative uncertainty sqrt(2 / n), which is on top
    already.
    """
    degrees = robots - 1.0
    wide = (float(stdtrit(degrees, 0.5 + 0.5 * _HELD)) / WITHIN_95) ** 2
    return float(max(1.0, wide / (1.0 + np.sqrt(2.0 / degrees))))


def of_robot_now(account: Account, robot: str) -> JointPrior:
    """Return what is known of a robot of the fleet after its last campaign, named changes included.

    Parameters
    ----------
    account : Account
    robot : str
        Of the fleet.

    Returns
    -------
    JointPrior
        In the parameters' own units.
    """
    fleet, posterior = account.fleet, account.estimated.posterior
    number = fleet.robots.index(robot)
    mean, covariance = posterior.robot_now(number)
    last = np.flatnonzero(fleet.robot == number)
    last = last[np.argmax(fleet.day[last])]
    p = len(fleet.specs)
    acting = np.concatenate([np.eye(p), posterior.equations.acting[last, :p]], axis=1)
    return _belief(account, acting @ mean, acting @ covariance @ acting.T)


def _belief(account: Account, mean: FloatArray, covariance: FloatArray) -> JointPrior:
    """Return a mean and covariance in stated widths in the parameters' own units."""
    fleet = account.fleet
    whole = 0.5 * (covariance + covariance.T) + _SMALLEST * np.eye(len(mean))
    return JointPrior(
        fleet.specs,
        fleet.owners,
        fleet.means + fleet.widths * mean,
        whole * np.outer(fleet.widths, fleet.widths),
    )


MOST: Final = 100  # readings without the type up to which is looked for as much
_CANDIDATES: Final = 400
_KNOWN_TO: Final = 0.1  # robots of one type differ by so much in what the usual effects lack


@dataclass(frozen=True, slots=True)
class ErrorForecast:
    """Norms of position errors over the work volume after so many configurations."""

    n: int
    mean_mm: float
    interval_90_mm: tuple[float, float]  # nine calibrations of ten have their mean error within
    joints_rad: FloatArray  # (n, J) to measure, in the order of choice
    nest: IntArray  # (n,)


@dataclass(frozen=True, slots=True)
class PredictedAccuracy:
    """What ways of measuring a new robot promise."""

    pooled: ErrorForecast  # with what the type says
    alone: ErrorForecast  # more readings, as a robot of no known type
    same_mm: float  # mean error of as many readings and the same parameters, from what was stated of them
    needed: int | None  # of these readings for what the type promises; None: more than `MOST`

    @property
    def is_worth(self) -> bool:
        """Whether the type saves any reading."""
        return self.needed is None or self.needed > self.pooled.n


def promise(
    space: WorkSpace,
    belief: JointPrior,
    typical: Campaign,
    *,
    readings: int = 15,
    without: int = 50,
    knowns: PriorKnowledge | None = None,
    seed: int = 0,
) -> PredictedAccuracy:
    """Say what few readings with the type's belief promise, and more of them without.

    Parameters
    ----------
    space : WorkSpace
    belief : JointPrior
        Of a new robot of the type.
    typical : Campaign
        Of a robot of the type, at whose configurations is seen what the usual effects lack.
    readings, without : int
        Configurations measured with the belief, and without it.
    knowns : PriorKnowledge, optional
    seed : int

    Returns
    -------
    PredictedAccuracy

    Raises
    ------
    WorkSpaceError, TooFewCandidatesError
        As `draw_candidates` and `planning.prediction.plan.sample`.
    """
    known = knowns or PriorKnowledge()
    # As a robot of no known type: what waves and gaps do is then expressed by nothing.
    lacking = Discrepancy(lacking_mm(belief, typical), _KNOWN_TO)
    more = replace(known, discrepancy=lacking, believed=None)
    pooled = _Measuring(space, known.believing(belief), readings, seed).promised(readings)
    # With the same parameters, so that what is compared is what the type knows, not that waves and gaps
    # are in the model.
    same = _Measuring(space, known.believing(as_stated(belief)), MOST, seed)
    return PredictedAccuracy(
        pooled,
        _Measuring(space, more, without, seed).promised(without),
        same.mean_mm(readings),
        same.needed(pooled.mean_mm),
    )


def as_stated(belief: JointPrior) -> JointPrior:
    """Return the same parameters as they are stated of any robot.

    Parameters
    ----------
    belief : JointPrior

    Returns
    -------
    JointPrior
        Independent, with the stated means and widths.
    """
    means = np.array([spec.prior_mean for spec in belief.specs])
    widths = np.array([spec.prior_width for spec in belief.specs])
    return JointPrior(belief.specs, belief.owners, means, np.diag(widths**2))


class _Measuring:
    """Configurations in the order of choice, each the one that tells most beside those before it."""

    def __init__(self, space: WorkSpace, knowns: PriorKnowledge, most: int, seed: int) -> None:
        rng = np.random.default_rng(seed)
        candidates = draw_candidates(space, _CANDIDATES, rng)
        self._knowledge = ArmKnowledge(space, candidates, knowns)
        place = sample(space, WorkVolume(), VOLUME_CONFIGURATIONS, rng)
        self._places = self._knowledge.places(place.joints_rad, place.nest)
        told = self._knowledge.told(candidates.joints_rad, candidates.nest)
        before = self._knowledge.covariance(told.rows[:0, 0])
        order = most_informative_first(told.rows, most, before)
        self._told, self._chosen = (
            ReadingInformation(told.rows[order], told.held[order]),
            candidates.subset(order),
        )

    def promised(self, n: int) -> ErrorForecast:
        """Return what the first n promise."""
        found = error_distribution(self._errors(n), self._knowledge.discrepancy)
        joints_rad, nest = self._chosen.joints_rad[:n], self._chosen.nest[:n]
        return ErrorForecast(len(nest), found.mean_mm, found.interval_90_mm, joints_rad, nest)

    def mean_mm(self, n: int) -> float:
        """Return the mean error to expect of the first n."""
        return float(mean_norms(self._errors(n), self._knowledge.discrepancy.per_axis_mm).mean())

    def needed(self, mean_mm: float) -> int | None:
        """Return how many come to a mean error; None: all together do not. Each further one lowers it."""
        numbers = range(1, len(self._chosen) + 1)
        found = bisect_left(numbers, -mean_mm, key=lambda n: -self.mean_mm(n))
        return numbers[found] if found < len(numbers) else None

    def _errors(self, n: int) -> FloatArray:
        return self._knowledge.errors(
            ReadingInformation(self._told.rows[:n], self._told.held[:n]), self._places
        )


def lacking_mm(belief: JointPrior, campaign: Campaign) -> float:
    """Return what robots of the type do that the usual effects cannot express, RMS per axis.

    Of the motions by what is believed of the other parameters, what the usual ones take up at many
    configurations (least squares) is no part of it: sqrt(tr(L S L') / (3 n - r)), with L the motions that are
    left, r parameters that took part and S = C + m m' the second moments of the belief.

    Parameters
    ----------
    belief : JointPrior
    campaign : Campaign
        With n positions; without any nothing is said.

    Returns
    -------
    float
        [mm]; 0 without positions.
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
    # About 0: a model without these parameters has them at 0, whatever their mean in the type.
    second = belief.covariance + np.outer(belief.mean, belief.mean)
    others = [k for k, at in enumerate(place) if not usual[at]]
    basis, _ = np.linalg.qr((motion[usual] * problem.structure.prior_widths[usual, None]).T)
    moved = motion[[place[k] for k in others]]
    left = moved - (moved @ basis) @ basis.T
    # What the usual effects take up is no longer free: few configurations would look better than they
    # are.
    freedom = max(motion.shape[1] - basis.shape[1], 1)
    return float(
        np.sqrt(max(np.einsum("pm,pq,qm->", left, second[np.ix_(others, others)], left), 0.0) / freedom)
    )
