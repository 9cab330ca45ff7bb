r"""The fewest configurations that show, each month, whether what ages in a robot has grown.

Parameters are known as they were after the robot's last campaign (a belief); the set-up is found anew, and
each cause may have grown by about as much as is to be told, d ~ N(0, diag(g^2)). With rows J of the readings
and E the directions of the causes,

    C = [ M + sum J'J    sum J'J E       ]^-1
        [ E' sum J'J     E' sum J'J E + g^-2 ]

is the covariance of parameters and changes. Configurations are taken one after another, each the one that
lowers most the sum over the causes of their variance over what is asked (a cause that is known well enough
counts 1); it is enough where a growth of the asked size would be told with 95 % at a level of 5 %. That is
asked of the readings alone: the precision of d, less that of its prior, which is a part of each diagonal
element of the inverse by itself.

References
----------
V. V. Fedorov, Theory of Optimal Experiments, 1972, chapter 2 (part of the parameters).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.fleet.causes import AgeingCause
from truepose.identification.problem.belief import Belief
from truepose.planning.promise.knowledge import ArmKnowledge, Knowns
from truepose.planning.work_volume.candidates import Candidates
from truepose.planning.work_volume.work_space import WorkSpace

TOLD: Final = 3.2897  # standard uncertainties: 5 % on either side
_MOST: Final = 60


@dataclass(frozen=True, slots=True)
class QuickCheck:
    """Configurations to measure each month."""

    joints_rad: FloatArray  # (n, J) in the order of choice
    nest: IntArray  # (n,)
    told_mm: FloatArray  # (n, K) growth of each cause that is told after so many; inf: none yet
    enough: bool  # whether the last row is within what was asked


def quick_check(
    space: WorkSpace,
    candidates: Candidates,
    belief: Belief,
    causes: Sequence[AgeingCause],
    grown_mm: float,
    knowns: Knowns,
    most: int = _MOST,
) -> QuickCheck:
    """Choose the configurations.

    Parameters
    ----------
    space : WorkSpace
    candidates : Candidates
        To choose from.
    belief : Belief
        Of the robot as it is now.
    causes : sequence of AgeingCause
        K causes that age, over the belief's parameters and the scale.
    grown_mm : float
        Growth that is to be told, root mean square over the candidates.
    knowns : Knowns
        Of instrument and artefacts; what it believes is replaced.
    most : int
        Configurations at most.

    Returns
    -------
    QuickCheck

    Raises
    ------
    ConfigurationError
        No cause was given, one is an instrument's, or the growth is not above 0.
    """
    if not causes or not grown_mm > 0.0:
        raise ConfigurationError("A quick check is of at least one cause, and of a growth above 0 mm.")
    if not all(cause.directions[:-1].any() for cause in causes):
        raise ConfigurationError("A quick check is of what ages in a robot, not of an instrument's scale.")
    knowledge = ArmKnowledge(space, candidates, knowns.believing(belief))
    told = knowledge.told(candidates.joints_rad, candidates.nest).rows
    motion = knowledge.places(candidates.joints_rad, candidates.nest).motion
    place = [knowledge.structure.index_of(name) for name in belief.names]
    widths = knowledge.structure.prior_widths
    stated = np.array([spec.prior_width for spec in belief.specs])
    columns, owner = [], []
    for number, cause in enumerate(causes):
        across = np.zeros((len(widths), cause.directions.shape[1]))
        across[place] = cause.directions[:-1] * (stated / widths[place])[:, None]
        columns.append(across)
        owner += [number] * across.shape[1]
    directions = np.concatenate(columns, axis=1)  # (P, q)
    size = ((motion @ directions) ** 2).sum(axis=1).mean(axis=0)  # mm2 per squared unit of each
    prior = grown_mm**2 / np.maximum(size, 1e-300)
    goal = prior / (TOLD**2 + 1.0)  # with the prior; of the readings alone that is prior / TOLD**2
    rows = np.concatenate([told, told @ directions], axis=2)
    p, q = directions.shape
    known = np.zeros((p + q, p + q))
    known[:p, :p] = knowledge.prior()
    known[p:, p:] = np.diag(1.0 / prior)
    order, reached = _chosen(rows, np.linalg.inv(known), p, goal, most)
    of = np.array(owner)
    told_mm = grown_mm * np.array([
        [_told(float(one[of == k].max())) for k in range(len(causes))] for one in reached
    ])
    chosen = candidates.subset(order)
    return QuickCheck(chosen.joints_rad, chosen.nest, told_mm, bool(reached and reached[-1].max() <= 1.0))


def _told(ratio: float) -> float:
    """Return which growth the readings alone tell, over the asked one; `ratio` of a variance to its goal."""
    precision = (TOLD**2 + 1.0) / ratio - 1.0  # of the readings alone, in those of the prior
    return TOLD / np.sqrt(precision) if precision > 0.0 else np.inf


def _chosen(
    rows: FloatArray, covariance: FloatArray, p: int, goal: FloatArray, most: int
) -> tuple[IntArray, list[FloatArray]]:
    """Return candidates in the order of choice, and the variances over their goals after each."""
    free = np.ones(len(rows), dtype=bool)
    order: list[int] = []
    reached: list[FloatArray] = []
    ratio = np.diag(covariance)[p:] / goal
    while ratio.max() > 1.0 and len(order) < min(most, len(rows)):
        seen = rows @ covariance  # (N, d, P + q)
        own = np.eye(rows.shape[1]) + seen @ np.swapaxes(rows, 1, 2)
        part = seen[:, :, p:]
        lowered = (part * np.linalg.solve(own, part)).sum(axis=1)  # (N, q)
        after = np.maximum((np.diag(covariance)[p:] - lowered) / goal, 1.0).sum(axis=1)
        best = int(np.argmin(np.where(free, after, np.inf)))
        free[best] = False
        order.append(best)
        covariance = covariance - seen[best].T @ np.linalg.solve(own[best], seen[best])
        ratio = np.diag(covariance)[p:] / goal
        reached.append(ratio)
    return np.array(order, dtype=np.int64), reached
