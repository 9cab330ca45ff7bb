r"""Variance components of a fleet by restricted maximum likelihood, each with its standard uncertainty.

With d_i and S_i a robot's deviation and its covariance, the steps that may be taken are

    EM         v <- mean_i (d_i^2 + S_i)                 raises the likelihood always, slowly near 0
    evidence   v <- sum_i d_i^2 / sum_i (1 - S_i / v)    has the same fixed points, and is faster

The faster one is taken where it raises the restricted likelihood, otherwise the safe one. A component whose
likelihood falls from 0 on ends there. Uncertainties are of Fisher's information, 1/2 tr(P V_p P V_q).

References
----------
N. M. Laird, J. H. Ware, Biometrics 38, 1982, 963-974 (EM).
D. J. C. MacKay, Neural Computation 4(3), 1992, 415-447 (evidence).
D. A. Harville, J. American Statistical Association 72, 1977, 320-338 (Fisher's information).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.fleet.mixed_model import Equations, Posterior, Variances

_START: Final = 0.05  # of the stated variances: most widths are stated generously
_MOST_STEPS: Final = 200
_SETTLED: Final = 1e-3  # of log likelihood
_NONE: Final = 1e-8  # of the stated variance: 1e-4 of a width is nothing


@dataclass(frozen=True, slots=True)
class Estimated:
    """Variances, and the posterior at them."""

    variances: Variances
    posterior: Posterior
    steps: int
    settled: bool

    @property
    def log_likelihood(self) -> float:
        """Restricted, up to a constant."""
        return self.posterior.log_likelihood


def estimate(equations: Equations, start: Variances | None = None) -> Estimated:
    """Return the variances of the largest restricted likelihood.

    Parameters
    ----------
    equations : Equations
    start : Variances, optional
        Of a model that is nearly this one.

    Returns
    -------
    Estimated
        `settled` is False where the steps ran out.
    """
    variances = _opened(start) if start else Variances(np.full(equations.parameters, _START), _START)
    now, step = Posterior(equations, variances), 0
    while step < _MOST_STEPS:
        step += 1
        faster = Posterior(equations, _evidence(now))
        following = faster if faster.log_likelihood > now.log_likelihood else Posterior(equations, _em(now))
        gained = following.log_likelihood - now.log_likelihood
        now = following
        if gained < _SETTLED:
            break
    return Estimated(now.variances, now, step, step < _MOST_STEPS)


def _opened(start: Variances) -> Variances:
    """Return variances of which none is so small that no step leads away from it."""
    return Variances(np.maximum(start.robot, 1e2 * _NONE), max(start.day, 1e2 * _NONE))


def _em(at: Posterior) -> Variances:
    spread = np.diagonal(at.deviation_covariance, axis1=1, axis2=2)
    robot = (at.deviation**2 + spread).mean(axis=0)
    days, left = _days(at)
    return Variances(np.maximum(robot, _NONE), max(float((days + left).mean()), _NONE))


def _evidence(at: Posterior) -> Variances:
    spread = np.diagonal(at.deviation_covariance, axis1=1, axis2=2)
    before = at.variances.robot
    told = np.maximum((1.0 - spread / before).sum(axis=0), _NONE)
    days, left = _days(at)
    told_days = max(float((1.0 - left / at.variances.day).sum()), _NONE)
    # Where the readings tell nothing, nothing is told of the size either: it stays.
    robot = np.where(told > 1e-6, (at.deviation**2).sum(axis=0) / told, before)
    day = float(days.sum()) / told_days if told_days > 1e-6 else at.variances.day
    return Variances(np.clip(robot, _NONE, 1.0), float(np.clip(day, _NONE, 1.0)))


def _days(at: Posterior) -> tuple[FloatArray, FloatArray]:
    """Return squares and variances of what each visit differs by from its instrument, both (K,)."""
    here, day = at.equations.visits, at.variances.day
    prior = at.equations.prior(day)[here, here]
    share = day * np.linalg.inv(prior)
    own = share @ at.shared[here]
    left = share @ at.covariance[here, here] @ share.T + day * np.eye(len(own)) - day * share
    return own**2, np.diag(left)


def uncertainties(estimated: Estimated) -> FloatArray:
    """Return the standard uncertainty of each variance between robots, (P,), in squared stated widths.

    It is at least what it were if all others were known, and at most what was stated: of a parameter that
    no campaign shows, nothing else is known.
    """
    at = estimated.posterior
    normal, cross = at.equations.normal, at.equations.cross
    held = normal - normal @ at.own @ normal
    reach = (cross - normal @ at.gain) @ at.root  # (R, P, G)
    information = np.zeros(normal.shape[1:])
    for robot, mine in enumerate(reach):
        between = mine @ np.swapaxes(reach, 1, 2)  # (R, P, P)
        between[robot] -= held[robot]
        information += 0.5 * (between**2).sum(axis=0)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(information), 1.0))
    unit = np.linalg.pinv(information * np.outer(scale, scale), rcond=1e-10, hermitian=True)
    return np.minimum(scale * np.sqrt(np.maximum(np.diag(unit), 1.0)), 1.0)
