r"""The campaigns of a fleet as a linear mixed model, and its variance components.

Of campaign c of robot i, measured on visit k (one instrument on one day),

    p_c = m + d_i + sum_e f_ec E_e v_e        scale_c = u_k + sum_e f_ec E_e v_e

m ~ N(stated, 1) what robots of the type have in common d_i ~ N(0, diag(robot)) how one robot differs from its
type u_k ~ N(0, J + day I) the instrument (J: 1 between visits of one instrument) on a day v_e ~ N(0, s_e I)
changes that were named: directions E_e, shape f_ec over the campaigns

all in stated widths; a variance of 1 for m and the instrument is next to no knowledge beside what a fleet
tells, and so is s_e, 1 or as large as the change is (`fleet.changes`).

With g = (m, u, v) and L_c how g acts on campaign c, the d_i are integrated out robot by robot:

    D_i = (N_i + diag(robot)^-1)^-1,  N_i = sum_c A_c,  X_i = sum_c A_c L_c   (rows of the robot's parameters)
    H = sum L'A L + prior - sum X_i' D_i X_i,   g = H^-1 (sum L'b - sum X_i' D_i n_i)

and restricted likelihood and posterior follow; no matrix is larger than robots do not share.

Variance components are those of restricted maximum likelihood, each with its standard uncertainty. With d_i
and S_i a robot's deviation and its covariance, the steps that may be taken are

    EM         v <- mean_i (d_i^2 + S_i)                 raises the likelihood always, slowly near 0
    evidence   v <- sum_i d_i^2 / sum_i (1 - S_i / v)    has the same fixed points, and is faster

The faster one is taken where it raises the restricted likelihood, otherwise the safe one. A component whose
likelihood falls from 0 on ends there. Uncertainties are of Fisher's information, 1/2 tr(P V_p P V_q).

With R = diag(robot)^1/2 the d_i are taken from I + R N_i R, which is never singular, also where variances are
0: D_i = R (I + R N_i R)^-1 R.

References
----------
H. D. Patterson, R. Thompson, Biometrika 58, 1971, 545-554 (restricted likelihood).
S. R. Searle, G. Casella, C. E. McCulloch, Variance Components, Wiley, 1992, chapter 7 (the equations).
N. M. Laird, J. H. Ware, Biometrics 38, 1982, 963-974 (EM).
D. J. C. MacKay, Neural Computation 4(3), 1992, 415-447 (evidence).
D. A. Harville, J. American Statistical Association 72, 1977, 320-338 (Fisher's information).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.singular_covariance import whitening_root
from truepose.fleet.campaigns import Fleet


@dataclass(frozen=True, slots=True)
class Variances:
    """Variance components, in squared stated widths."""

    robot: FloatArray  # (P,) between robots of the type
    day: float  # of an instrument's scale from day to day


@dataclass(frozen=True, slots=True)
class NamedChange:
    """A change over time.

    Attributes
    ----------
    directions : ndarray, shape (P + 1, q)
        In stated widths, the scale last.
    shape : ndarray, shape (C,)
        How far it has come at each campaign; 1 at the end.
    variance : float
        Of its size along each direction before any reading, in squared stated widths.
    """

    directions: FloatArray
    shape: FloatArray
    variance: float = 1.0


class Equations:
    """What does not change with the variances: sums over the campaigns of each robot.

    G unknowns g = (m, u, v): P of the type, one a visit, q a named change.

    Parameters
    ----------
    fleet : Fleet
    changes : sequence of NamedChange
    """

    def __init__(self, fleet: Fleet, changes: Sequence[NamedChange] = ()) -> None:
        self.fleet, self.changes = fleet, tuple(changes)
        self.parameters = len(fleet.specs)
        self.acting = _acting(fleet, self.changes)  # (C, P + 1, G)
        self.seen = fleet.normal @ self.acting  # (C, P + 1, G)
        p, n = self.parameters, len(fleet.robots)
        self.normal = self.by_robot(fleet.normal[:, :p, :p], n)  # (R, P, P)
        self.right = self.by_robot(fleet.right[:, :p], n)  # (R, P)
        self.cross = self.by_robot(self.seen[:, :p], n)  # (R, P, G)
        self.common = np.einsum("cpg,cph->gh", self.acting, self.seen, optimize=True)  # (G, G)
        self.common_right = np.einsum("cpg,cp->g", self.acting, fleet.right)  # (G,)

    def by_robot(self, each: FloatArray, n: int) -> FloatArray:
        """Sum what campaigns have robot by robot.

        Parameters
        ----------
        each : ndarray, shape (C, ...)
        n : int
            R, number of robots.

        Returns
        -------
        ndarray, shape (R, ...)
            Zeros of a robot without a campaign.
        """
        summed = np.zeros((n, *each.shape[1:]))
        np.add.at(summed, self.fleet.robot, each)
        return summed

    def prior(self, day: float) -> FloatArray:
        """Return the covariance of g before any reading.

        Parameters
        ----------
        day : float
            Variance of an instrument's scale from day to day, in squared stated widths.

        Returns
        -------
        ndarray, shape (G, G)
            I, J + day I between the visits of one instrument, and the variance of each change.
        """
        covariance = np.eye(self.common.shape[0])
        for number, change in enumerate(self.changes):
            covariance[self.of_change(number), self.of_change(number)] *= change.variance
        visits = slice(self.parameters, self.parameters + len(self.fleet.visits))
        instrument = np.array([visit[0] for visit in self.fleet.visits])
        same = (instrument[:, None] == instrument[None, :]).astype(float)
        covariance[visits, visits] = same + day * np.eye(len(instrument))
        return covariance

    @property
    def visits(self) -> slice:
        """Where the visits stand in g."""
        return slice(self.parameters, self.parameters + len(self.fleet.visits))

    def of_change(self, number: int) -> slice:
        """Return where a named change stands in g.

        Parameters
        ----------
        number : int
            Its place among the changes, from 0.

        Returns
        -------
        slice
        """
        before = sum(change.directions.shape[1] for change in self.changes[:number])
        start = self.visits.stop + before
        return slice(start, start + self.changes[number].directions.shape[1])


def _acting(fleet: Fleet, changes: Sequence[NamedChange]) -> FloatArray:
    """Return L_c, how g acts on the parameters and the scale of each campaign, shape (C, P + 1, G)."""
    p, c = len(fleet.specs), len(fleet.day)
    shared = np.zeros((c, p + 1, p + len(fleet.visits)))
    shared[:, :p, :p] = np.eye(p)
    shared[np.arange(c), p, p + fleet.visit] = 1.0
    moved = [change.shape[:, None, None] * change.directions for change in changes]
    return np.concatenate([shared, *moved], axis=2)


class Posterior:
    """What the campaigns tell at given variances; all in stated widths.

    Parameters
    ----------
    equations : Equations
    variances : Variances

    Attributes
    ----------
    own : ndarray, shape (R, P, P)
        D_i, covariance of each robot's deviation at known g.
    gain : ndarray, shape (R, P, G)
        D_i X_i: how a deviation follows g, with the opposite sign.
    information : ndarray, shape (G, G)
        Of g, by the readings alone.
    root : ndarray, shape (G, G)
        W with W W' the covariance of g.
    covariance : ndarray, shape (G, G)
        Of g.
    shared : ndarray, shape (G,)
        g.
    deviation : ndarray, shape (R, P)
        d_i.
    log_likelihood : float
        Restricted, up to a constant.
    """

    def __init__(self, equations: Equations, variances: Variances) -> None:
        self.equations, self.variances = equations, variances
        size = np.sqrt(variances.robot)
        wound = np.eye(len(size)) + size[:, None] * equations.normal * size
        root = whitening_root(wound) * size  # (R, P, P)
        self.own = np.swapaxes(root, 1, 2) @ root  # (R, P, P) D_i
        self.gain = self.own @ equations.cross  # (R, P, G)
        half = root @ equations.cross
        told = root @ equations.right[:, :, None]
        prior = equations.prior(variances.day)
        # No prior in it: days and instruments are judged by what readings alone say of them.
        information = equations.common - np.einsum("rpg,rph->gh", half, half, optimize=True)
        right = equations.common_right - np.einsum("rpg,rp->g", half, told[:, :, 0], optimize=True)
        self.information, self.information_right = information, right
        total = information + np.linalg.inv(prior)
        self.root = whitening_root(0.5 * (total + total.T)).T  # (G, G)
        self.covariance = self.root @ self.root.T  # (G, G) of g
        self.shared = self.covariance @ right  # (G,)
        self.deviation = np.einsum(
            "rpq,rq->rp", self.own, equations.right - equations.cross @ self.shared
        )  # (R, P)
        inside = float((told**2).sum() + right @ self.shared)
        self.log_likelihood = 0.5 * (
            inside - _log_det(wound) - float(np.linalg.slogdet(total)[1]) - float(np.linalg.slogdet(prior)[1])
        )

    @cached_property
    def deviation_covariance(self) -> FloatArray:
        """Covariance of each robot's deviation from its type, shape (R, P, P)."""
        return np.asarray(self.own + self.gain @ self.covariance @ np.swapaxes(self.gain, 1, 2))

    @cached_property
    def fitted(self) -> FloatArray:
        """Parameters at each campaign, the scale last, shape (C, P + 1)."""
        found = self.equations.acting @ self.shared
        found[:, : self.equations.parameters] += self.deviation[self.equations.fleet.robot]
        return np.asarray(found)

    def put_at(self, place: int, robot: int) -> FloatArray:
        """Return the covariance of what is put at a campaign if it is of some robot.

        (L_c - D_i X_i) C (L_c - D_i X_i)' + D_i, with C the covariance of g; rows of the robot's parameters
        only.

        Parameters
        ----------
        place : int
            Of the campaign.
        robot : int
            Its index, or that of another one.

        Returns
        -------
        ndarray, shape (P + 1, P + 1)
        """
        p = self.equations.parameters
        acting: FloatArray = self.equations.acting[place].copy()
        acting[:p] -= self.gain[robot]
        spread: FloatArray = acting @ self.covariance @ acting.T
        spread[:p, :p] += self.own[robot]
        return spread

    def robot_now(self, robot: int) -> tuple[FloatArray, FloatArray]:
        """Return mean and covariance of a robot's deviation and of g together.

        Parameters
        ----------
        robot : int

        Returns
        -------
        mean : ndarray, shape (P + G,)
        covariance : ndarray, shape (P + G, P + G)
        """
        gain = self.gain[robot]
        cross = -gain @ self.covariance
        covariance = np.block([[self.deviation_covariance[robot], cross], [cross.T, self.covariance]])
        return np.concatenate([self.deviation[robot], self.shared]), covariance


def _log_det(matrices: FloatArray) -> float:
    return float(np.linalg.slogdet(matrices)[1].sum())


_START: Final = 0.05  # of the stated variances: most widths are stated generously
_MOST_STEPS: Final = 200
_SETTLED: Final = 1e-3  # of log likelihood
_NONE: Final = 1e-8  # of the stated variance: 1e-4 of a width is nothing


@dataclass(frozen=True, slots=True)
class Estimate:
    """Variances, and the posterior at them.

    Attributes
    ----------
    variances : Variances
    posterior : Posterior
    steps : int
        That were taken.
    settled : bool
        False where they ran out.
    """

    variances: Variances
    posterior: Posterior
    steps: int
    settled: bool

    @property
    def log_likelihood(self) -> float:
        """Restricted, up to a constant."""
        return self.posterior.log_likelihood


def estimate(equations: Equations, start: Variances | None = None) -> Estimate:
    """Return the variances of the largest restricted likelihood.

    Parameters
    ----------
    equations : Equations
    start : Variances, optional
        Of a model that is nearly this one.

    Returns
    -------
    Estimate
        `settled` is False where the steps ran out.
    """
    # Both steps multiply: from 0 none of them leads away.
    variances = _opened(start) if start else Variances(np.full(equations.parameters, _START), _START)
    now, step = Posterior(equations, variances), 0
    while step < _MOST_STEPS:
        step += 1
        faster = Posterior(equations, _evidence(now))
        following = faster if faster.log_likelihood > now.log_likelihood else Posterior(equations, _em(now))
        gained = following.log_likelihood - now.log_likelihood
        now = following
        # Of log likelihood, not of the variances: those that nothing tells of may wander without end.
        if gained < _SETTLED:
            break
    return Estimate(now.variances, now, step, step < _MOST_STEPS)


def _opened(start: Variances) -> Variances:
    """Return variances of which none is so small that no step leads away from it."""
    return Variances(np.maximum(start.robot, 1e2 * _NONE), max(start.day, 1e2 * _NONE))


def _em(at: Posterior) -> Variances:
    """Return the variances after a step of EM: v <- mean_i (d_i^2 + S_i), of days likewise.

    At most 1, as with a step of the evidence.
    """
    spread = np.diagonal(at.deviation_covariance, axis1=1, axis2=2)
    robot = (at.deviation**2 + spread).mean(axis=0)
    days, left = _days(at)
    return _within_stated(robot, float((days + left).mean()))


def _evidence(at: Posterior) -> Variances:
    """Return the variances after a step of the evidence.

    v <- sum_i d_i^2 / sum_i (1 - S_i / v), of days likewise. At most 1, what was stated of any robot.
    """
    spread = np.diagonal(at.deviation_covariance, axis1=1, axis2=2)
    before = at.variances.robot
    told = np.maximum((1.0 - spread / before).sum(axis=0), _NONE)
    days, left = _days(at)
    told_days = max(float((1.0 - left / at.variances.day).sum()), _NONE)
    # Where the readings tell nothing, nothing is told of the size either: it stays.
    robot = np.where(told > 1e-6, (at.deviation**2).sum(axis=0) / told, before)
    day = float(days.sum()) / told_days if told_days > 1e-6 else at.variances.day
    return _within_stated(robot, day)


def _within_stated(robot: FloatArray, day: float) -> Variances:
    return Variances(np.clip(robot, _NONE, 1.0), float(np.clip(day, _NONE, 1.0)))


def _days(at: Posterior) -> tuple[FloatArray, FloatArray]:
    """Return squares and variances of what each visit differs by from its instrument, both (K,).

    Of a visit u = level + day, the day's part is S u with S = v K^-1, K = J + v I; its variance is S C S' + v
    I - v S, what the readings leave and what u itself does not tell of it.
    """
    here, day = at.equations.visits, at.variances.day
    prior = at.equations.prior(day)[here, here]
    share = day * np.linalg.inv(prior)
    own = share @ at.shared[here]
    left = share @ at.covariance[here, here] @ share.T + day * np.eye(len(own)) - day * share
    return own**2, np.diag(left)


def uncertainties(estimated: Estimate) -> FloatArray:
    """Return the standard uncertainty of each variance between robots.

    It is at least what it were if all others were known, and at most what was stated: of a parameter that no
    campaign shows, nothing else is known. From Fisher's information 1/2 tr(P V_p P V_q), robot by robot.

    Parameters
    ----------
    estimated : Estimate

    Returns
    -------
    ndarray, shape (P,)
        In squared stated widths.

    References
    ----------
    D. A. Harville, J. American Statistical Association 72, 1977, 320-338.
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
    # Scaled to a unit diagonal first: variances that are told by forty robots and by none differ by
    # orders.
    unit = np.linalg.pinv(information * np.outer(scale, scale), rcond=1e-10, hermitian=True)
    return np.minimum(scale * np.sqrt(np.maximum(np.diag(unit), 1.0)), 1.0)
