r"""Campaigns that scatter more than their readings say, or are unlike the others of their robot.

With m_c the parameters that the model of a fleet puts at campaign c and V_c their covariance, what a campaign
says otherwise is b_c - A_c m_c, of covariance A_c - A_c V_c A_c; so

    sum_c (b_c - A_c m_c)' A_c^+ (b_c - A_c m_c)    is expected to be    sum_c rank A_c - tr(A_c V_c)

over the campaigns of a robot. The ratio of the two is about 1; where it is larger, the robot comes back from
one campaign to the next less equal than its readings are precise (mountings, temperature, what no parameter
says), and its information is divided by it: by that of its middle campaign, which one campaign that is out of
order does not move, and by no less than that of the middle robot, which a few that age do not move.

A campaign c that differs by v from what the model of the fleet puts there, v ~ N(0, s diag(robot)) as robots
of the type differ from one another, is judged like any change (`fleet.trials`), along all parameters at once.
Whose else it may be: with x_j the parameters of robot j as the model has them at c, and V_j their covariance,

    (b_c - A_c x_j)' (A_c + A_c V_j A_c)^+ (b_c - A_c x_j)

is chi-square with as many degrees of freedom as A_c has rank, if it was robot j.

References
----------
R. T. Birge, Phys. Rev. 40, 1932, 207-227.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.fleet.campaigns import Fleet
from truepose.fleet.mixed_model import Equations, Posterior, Variances
from truepose.fleet.trials import Evidence, Score, excess_of
from truepose.identification.distributions import chi2_exceeded

_RANK: Final = 1e-9  # of the largest eigenvalue
_FEWEST_CAMPAIGNS: Final = 10.0  # degrees of freedom: in fewer, a robot that ages would be its own measure


def birge_ratios(posterior: Posterior, given: FloatArray | None = None) -> FloatArray:
    """Return the ratio of variances of each robot, (R,); 1: none scatters more than its readings say.

    Parameters
    ----------
    posterior : Posterior
    given : ndarray, shape (R,), optional
        By which the information of each robot is divided already.

    Returns
    -------
    ndarray, shape (R,)
        1 or more, none below that of the middle robot.

    References
    ----------
    R. T. Birge, Phys. Rev. 40, 1932, 207-227.
    """
    fleet = posterior.equations.fleet
    left = fleet.right - np.einsum("cpq,cq->cp", fleet.normal, posterior.fitted)
    squares, expected = (np.zeros(len(fleet.day)) for _ in range(2))
    for c, robot in enumerate(fleet.robot.tolist()):
        values, vectors = np.linalg.eigh(fleet.normal[c])
        seen = values > _RANK * values[-1]
        squares[c] = float(((vectors[:, seen].T @ left[c]) ** 2 / values[seen]).sum())
        put = posterior.put_at(c, robot)
        expected[c] = float(seen.sum()) - float(np.einsum("pq,pq->", fleet.normal[c], put))
    own = [fleet.robot == number for number in range(len(fleet.robots))]
    # Squares are over divided variances: the ratio wanted is that of the readings as stated.
    squares *= 1.0 if given is None else given[fleet.robot]
    whole = [squares[mine].sum() / max(expected[mine].sum(), 1.0) for mine in own]
    middle = [_of_the_middle_campaign(squares[mine], expected[mine]) for mine in own]
    return np.maximum(np.minimum(whole, middle), max(1.0, float(np.median(whole))))


def _of_the_middle_campaign(squares: FloatArray, expected: FloatArray) -> float:
    telling = expected >= _FEWEST_CAMPAIGNS
    return float(np.median(squares[telling] / expected[telling])) if telling.any() else 1.0


Changing: TypeAlias = Callable[[str], BoolArray]

_FEWEST: Final = 10  # directions; in fewer the two look alike
_IS_IT: Final = 1e-3  # chance of so bad a fit of the right robot


@dataclass(frozen=True, slots=True)
class OutlyingCampaign:
    """A campaign that is none of its robot as the others saw it."""

    place: int  # among the campaigns of the fleet
    robot: str  # that it is said to be of
    day: float
    ratio: float  # twice the log likelihood ratio
    excess: float  # by which variances exceed what readings state
    resembles: str = ""  # another robot that it fits; empty: none


def most_unlike(posterior: Posterior, level: float, changing: Changing) -> OutlyingCampaign | None:
    """Return the campaign with the largest ratio where chance does not explain it; None: it explains all.

    Parameters
    ----------
    posterior : Posterior
        With the named changes in the model.
    level : float
        Chance that a campaign is found where all are of their robots.
    changing : callable
        From a robot to which of its parameters change, the scale last, (P + 1,): those do not make it
        another.

    Returns
    -------
    OutlyingCampaign or None
    """
    fleet = posterior.equations.fleet
    counts = np.bincount(fleet.robot, minlength=len(fleet.robots))
    # A robot's only campaign differs from no other.
    tried = np.flatnonzero(counts[fleet.robot] > 1)
    if not len(tried):
        return None
    # A robot that ages is still the same robot: what of it is known to change does not count.
    still = {robot: ~changing(robot)[:-1] for robot in fleet.robots}
    seen = [_seen(posterior, place, still[fleet.robots[fleet.robot[place]]]) for place in tried.tolist()]
    excess = excess_of(seen)
    judged = [one.judged(excess) if _is_another(one, excess) else (0.0, 1.0) for one in seen]
    best = int(np.argmax([ratio for ratio, _ in judged]))
    ratio, chance = judged[best]
    if chance * len(tried) > level or ratio <= 0.0:
        return None
    return unlike(fleet, int(tried[best]), ratio, excess)


def unlike(fleet: Fleet, place: int, ratio: float, excess: float) -> OutlyingCampaign:
    """Return a campaign of a fleet as one that is none of its robot.

    Parameters
    ----------
    fleet : Fleet
    place : int
        Of the campaign.
    ratio : float
        Twice the log likelihood ratio that speaks for it.
    excess : float
        By which variances exceed what readings state.

    Returns
    -------
    OutlyingCampaign
        Whose it is instead has not been asked.
    """
    return OutlyingCampaign(
        place, fleet.robots[int(fleet.robot[place])], float(fleet.day[place]), ratio, excess
    )


def _seen(posterior: Posterior, place: int, still: BoolArray) -> Evidence:
    """Return what is seen of one campaign that differs as robots do, along all parameters that do not change.

    Directions diag(robot)^1/2: a unit along each is one standard deviation between robots.
    """
    size = np.sqrt(posterior.variances.robot) * still
    alone = (np.arange(len(posterior.equations.fleet.day)) == place).astype(float)
    return Score(posterior, alone).of(np.vstack([np.diag(size), np.zeros(len(size))]))


def _is_another(seen: Evidence, excess: float) -> bool:
    """Return whether it differs as robots do, rather than in all directions as worse readings do."""
    few = len(seen.squares) < _FEWEST
    return few or seen.judged(excess)[0] > seen.scattered(excess)


def best_fitting_robots(
    fleet: Fleet, others: Sequence[OutlyingCampaign], variances: Variances
) -> tuple[OutlyingCampaign, ...]:
    """Return campaigns that are none of their robots with the robot that each fits best, if it fits one.

    Parameters
    ----------
    fleet : Fleet
        With those campaigns.
    others : sequence of OutlyingCampaign
    variances : Variances
        Of the fleet without them.

    Returns
    -------
    tuple of OutlyingCampaign
        Each with the robot that it fits best, empty where it fits none.
    """
    if not others:
        return ()
    # Without their information, but in their places: the model says there what it expects of each robot
    # on that day.
    counts = np.ones(len(fleet.day))
    counts[[one.place for one in others]] = 0.0
    silent = replace(fleet, normal=fleet.normal * counts[:, None, None], right=fleet.right * counts[:, None])
    posterior = Posterior(Equations(silent), variances)
    return tuple(replace(one, resembles=_resembled(posterior, fleet, one)) for one in others)


def _resembled(posterior: Posterior, fleet: Fleet, of: OutlyingCampaign) -> str:
    others = (number for number, name in enumerate(fleet.robots) if name != of.robot)
    each = {number: _chance_of(posterior, fleet, of, number) for number in others}
    best = max(each, key=lambda number: each[number])
    return fleet.robots[best] if each[best] > _IS_IT else ""


def _chance_of(posterior: Posterior, fleet: Fleet, of: OutlyingCampaign, robot: int) -> float:
    """Return the chance that a campaign of some robot fits no better than this.

    In the r directions that the campaign sees, A = V diag(l) V': z = l^-1/2 V' (b - A x) has the covariance I
    + l^1/2 V' V_j V l^1/2, and z' cov^-1 z is chi-square of r degrees of freedom.
    """
    p, normal = posterior.equations.parameters, fleet.normal[of.place]
    put = posterior.equations.acting[of.place] @ posterior.shared
    put[:p] += posterior.deviation[robot]
    values, vectors = np.linalg.eigh(normal)
    seen = values > _RANK * values[-1]
    root = vectors[:, seen] * np.sqrt(values[seen])
    off = (vectors[:, seen].T @ (fleet.right[of.place] - normal @ put)) / np.sqrt(values[seen])
    covariance = np.eye(len(off)) + root.T @ posterior.put_at(of.place, robot) @ root
    return chi2_exceeded(float(off @ np.linalg.solve(covariance, off)) / of.excess, float(len(off)))
