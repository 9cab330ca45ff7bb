"""How a cause of a robot went over the months: what each campaign says of it, with its uncertainty."""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.fleet.causes import AgeingCause
from truepose.fleet.changes import Account
from truepose.fleet.mixed_model import Equations, NamedChange, Posterior
from truepose.fleet.trials import Change


@dataclass(frozen=True, slots=True)
class Course:
    """A cause at the n later campaigns of a robot, in stated widths from what it was at the first."""

    day: FloatArray  # (n,) ascending
    amount: FloatArray  # (n, q)
    covariance: FloatArray  # (n, q, q)


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
    others = [one.change.named for one in account.named if not _is_of(one.change, robot, cause)]
    own = np.flatnonzero(fleet.robot == fleet.robots.index(robot))
    later = own[np.argsort(fleet.day[own], kind="stable")][1:]
    alone = np.eye(len(fleet.day))[later]
    equations = Equations(fleet, [*others, *(NamedChange(cause.directions, shape) for shape in alone)])
    posterior = Posterior(equations, account.estimated.variances)
    places = [equations.of_change(len(others) + number) for number in range(len(later))]
    return Course(
        fleet.day[later],
        np.array([posterior.shared[place] for place in places]),
        excess * np.array([posterior.covariance[place, place] for place in places]),
    )


def _is_of(change: Change, robot: str, cause: AgeingCause) -> bool:
    named = (change.of, change.cause.effect, change.cause.subject, change.cause.order)
    return named == (robot, cause.effect, cause.subject, cause.order)
