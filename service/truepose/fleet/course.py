"""How a cause went over the months: what each campaign or day says of it, with its uncertainty."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.fleet.causes import AgeingCause
from truepose.fleet.changes import Account, Named
from truepose.fleet.components import estimate
from truepose.fleet.mixed_model import Equations, NamedChange, Posterior
from truepose.fleet.trials import InstrumentDays

_SPANS: Final = 12  # of time, into which the days of a whole type are gathered where there are more


@dataclass(frozen=True, slots=True)
class Course:
    """A cause at the n later campaigns of a robot, in stated widths from what it was at the first."""

    day: FloatArray  # (n,) ascending
    amount: FloatArray  # (n, q)
    covariance: FloatArray  # (n, q, q)


@dataclass(frozen=True, slots=True)
class Along:
    """How far a named change had come on n days after the first, along itself; negative: the other way."""

    day: FloatArray  # (n,) ascending
    size_mm: FloatArray  # (n,)
    u_mm: FloatArray  # (n,) standard uncertainties


def course(account: Account, robot: str, cause: AgeingCause, excess: float = 1.0) -> Course:
    """Return by how much each later campaign of a robot sees a cause differ from the first.

    Parameters
    ----------
    account : Account
    robot : str
    cause : AgeingCause
        Whatever of it was named in this robot is taken out of the model first; every campaign is free, to
        within a stated width.
    excess : float
        By which variances of this cause exceed what readings state, as of its trial.
    """
    fleet = account.fleet
    own = np.flatnonzero(fleet.robot == fleet.robots.index(robot))
    later = own[np.argsort(fleet.day[own], kind="stable")][1:]
    alone = np.eye(len(fleet.day))[later]
    return _course(account, robot, cause, fleet.day[later], alone, excess)


def along(account: Account, named: Named) -> Along:
    """Return how a named change went: each campaign of a robot, day of an instrument, span of the type."""
    if named.change.scope == "instrument":
        return _of_instrument(account, named)
    if named.change.scope == "robot":
        found = course(account, named.change.of, named.change.cause, named.trial.excess)
    else:
        found = _of_type(account, named)
    way = named.amount / float(named.amount @ named.amount)
    u = np.sqrt(np.einsum("p,npq,q->n", way, found.covariance, way))
    return Along(found.day, named.size_mm * found.amount @ way, named.size_mm * u)


def _of_type(account: Account, named: Named) -> Course:
    day = account.fleet.day
    known = np.unique(day)
    if len(known) > _SPANS:
        ends = np.linspace(known[0], known[-1], _SPANS + 1)[1:-1]
        of = np.searchsorted(ends, day)
    else:
        of = np.searchsorted(known, day)
    numbers = np.unique(of)[1:]
    shapes = np.array([(of == number).astype(float) for number in numbers])
    days = np.array([day[of == number].mean() for number in numbers])
    return _course(account, "", named.change.cause, days, shapes, named.trial.excess)


def _of_instrument(account: Account, named: Named) -> Along:
    """Return how the lengths of an instrument differ from those of its first day."""
    fleet = account.fleet
    others = [one.change.named for one in account.named if not one.change.same_as(named.change)]
    posterior = estimate(Equations(fleet, others), account.estimated.variances).posterior
    days = InstrumentDays(posterior)
    number = fleet.instruments.index(named.change.of)
    own = [k for k, visit in enumerate(fleet.visits) if visit[0] == number and days.told[k]]
    less = np.eye(len(days.scale))[own[1:]] - np.eye(len(days.scale))[own[0]]
    unit_mm = float(np.sqrt(fleet.motion_mm2[-1, -1])) * float(np.sign(named.amount[0]))
    spread = np.einsum("nd,de,ne->n", less, days.covariance, less)
    return Along(
        np.array([fleet.visits[k][1] for k in own[1:]]),
        unit_mm * less @ days.scale,
        abs(unit_mm) * np.sqrt(spread),
    )


def _course(
    account: Account, of: str, cause: AgeingCause, days: FloatArray, shapes: FloatArray, excess: float
) -> Course:
    """Return what is seen where each of n shapes over the campaigns, (n, C), is free to within a width."""
    others = [one.change.named for one in account.named if not one.change.is_of(of, cause)]
    free = [NamedChange(cause.directions, shape) for shape in shapes]
    equations = Equations(account.fleet, [*others, *free])
    posterior = Posterior(equations, account.estimated.variances)
    places = [equations.of_change(len(others) + number) for number in range(len(free))]
    return Course(
        days,
        np.array([posterior.shared[place] for place in places]),
        excess * np.array([posterior.covariance[place, place] for place in places]),
    )
