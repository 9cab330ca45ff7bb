"""What a fleet says beforehand of a further robot of the type, or of one of its own as it is now."""

from typing import Final

import numpy as np
from scipy.special import stdtrit

from truepose.domain.arrays import FloatArray
from truepose.fleet.changes import Account
from truepose.fleet.components import uncertainties
from truepose.identification.distributions import WITHIN_95
from truepose.identification.problem.belief import Belief

_HELD: Final = 0.95
_SMALLEST: Final = 1e-10  # of stated variances: rounding leaves no variance below 0


def of_a_new_robot(account: Account) -> Belief:
    """Return what is believed of a robot of the type that was never measured.

    Its mean is that of the type. The variances between robots are themselves estimated: each counts with its
    standard uncertainty on top, so that one that came out as nothing by chance is not taken at its word. Of
    R robots a further one lies where Student's t with R - 1 degrees of freedom has it, whose 95 % are six
    times as wide as those of a normal distribution where R is 2, and 7 % wider where it is 20: where that is
    more, the variance is made as wide.
    """
    posterior = account.estimated.posterior
    own = slice(len(account.fleet.specs))
    variances = account.estimated.variances.robot
    between = variances + uncertainties(account.estimated)
    between *= _of_few(len(account.fleet.robots))
    return _belief(account, posterior.shared[own], posterior.covariance[own, own] + np.diag(between))


def _of_few(robots: int) -> float:
    """Return by what a variance of so few robots, with its uncertainty on top, is still too small."""
    degrees = robots - 1.0
    wide = (float(stdtrit(degrees, 0.5 + 0.5 * _HELD)) / WITHIN_95) ** 2
    return float(max(1.0, wide / (1.0 + np.sqrt(2.0 / degrees))))


def of_robot_now(account: Account, robot: str) -> Belief:
    """Return what is known of a robot of the fleet after its last campaign, named changes included."""
    fleet, posterior = account.fleet, account.estimated.posterior
    number = fleet.robots.index(robot)
    mean, covariance = posterior.robot_now(number)
    last = np.flatnonzero(fleet.robot == number)
    last = last[np.argmax(fleet.day[last])]
    p = len(fleet.specs)
    acting = np.concatenate([np.eye(p), posterior.equations.acting[last, :p]], axis=1)
    return _belief(account, acting @ mean, acting @ covariance @ acting.T)


def _belief(account: Account, mean: FloatArray, covariance: FloatArray) -> Belief:
    """Return a mean and covariance in stated widths in the parameters' own units."""
    fleet = account.fleet
    whole = 0.5 * (covariance + covariance.T) + _SMALLEST * np.eye(len(mean))
    return Belief(
        fleet.specs,
        fleet.owners,
        fleet.means + fleet.widths * mean,
        whole * np.outer(fleet.widths, fleet.widths),
    )
