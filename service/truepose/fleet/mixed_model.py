r"""The campaigns of a fleet as a linear mixed model, at given variances.

Of campaign c of robot i, measured on visit k (one instrument on one day),

    p_c = m + d_i + sum_e f_ec E_e v_e        scale_c = u_k + sum_e f_ec E_e v_e

m ~ N(stated, 1)              what robots of the type have in common
d_i ~ N(0, diag(robot))       how one robot differs from its type
u_k ~ N(0, J + day I)         the instrument (J: 1 between visits of one instrument) on a day
v_e ~ N(0, 1)                 changes that were named: directions E_e, shape f_ec over the campaigns

all in stated widths; a variance of 1 for m, the instrument and v_e is next to no knowledge beside what a
fleet tells. With g = (m, u, v) and L_c how g acts on campaign c, the d_i are integrated out robot by robot:

    D_i = (N_i + diag(robot)^-1)^-1,  N_i = sum_c A_c,  X_i = sum_c A_c L_c   (rows of the robot's parameters)
    H = sum L'A L + prior - sum X_i' D_i X_i,   g = H^-1 (sum L'b - sum X_i' D_i n_i)

and restricted likelihood and posterior follow; no matrix is larger than robots do not share.

References
----------
H. D. Patterson, R. Thompson, Biometrika 58, 1971, 545-554 (restricted likelihood).
S. R. Searle, G. Casella, C. E. McCulloch, Variance Components, Wiley, 1992, chapter 7 (the equations).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.definite import whitening_root
from truepose.fleet.campaigns import Fleet


@dataclass(frozen=True, slots=True)
class Variances:
    """Variance components, in squared stated widths."""

    robot: FloatArray  # (P,) between robots of the type
    day: float  # of an instrument's scale from day to day


@dataclass(frozen=True, slots=True)
class NamedChange:
    """A change over time: q directions (P + 1, q), and how far it has come at each campaign, shape (C,)."""

    directions: FloatArray
    shape: FloatArray


class Equations:
    """What does not change with the variances: sums over the campaigns of each robot."""

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
        """Sum campaigns (C, ...) robot by robot, shape (R, ...)."""
        summed = np.zeros((n, *each.shape[1:]))
        np.add.at(summed, self.fleet.robot, each)
        return summed

    def prior(self, day: float) -> FloatArray:
        """Return the covariance of g before any reading, shape (G, G)."""
        covariance = np.eye(self.common.shape[0])
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
        """Return where a named change stands in g."""
        before = sum(change.directions.shape[1] for change in self.changes[:number])
        start = self.visits.stop + before
        return slice(start, start + self.changes[number].directions.shape[1])


def _acting(fleet: Fleet, changes: Sequence[NamedChange]) -> FloatArray:
    p, c = len(fleet.specs), len(fleet.day)
    shared = np.zeros((c, p + 1, p + len(fleet.visits)))
    shared[:, :p, :p] = np.eye(p)
    shared[np.arange(c), p, p + fleet.visit] = 1.0
    moved = [change.shape[:, None, None] * change.directions for change in changes]
    return np.concatenate([shared, *moved], axis=2)


class Posterior:
    """What the campaigns tell at given variances."""

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
        """Return the covariance of what is put at a campaign if it is of some robot, (P + 1, P + 1)."""
        p = self.equations.parameters
        acting: FloatArray = self.equations.acting[place].copy()
        acting[:p] -= self.gain[robot]
        spread: FloatArray = acting @ self.covariance @ acting.T
        spread[:p, :p] += self.own[robot]
        return spread

    def robot_now(self, robot: int) -> tuple[FloatArray, FloatArray]:
        """Return mean (P + G,) and covariance of a robot's deviation and of g together."""
        gain = self.gain[robot]
        cross = -gain @ self.covariance
        covariance = np.block([[self.deviation_covariance[robot], cross], [cross.T, self.covariance]])
        return np.concatenate([self.deviation[robot], self.shared]), covariance


def _log_det(matrices: FloatArray) -> float:
    return float(np.linalg.slogdet(matrices)[1].sum())
