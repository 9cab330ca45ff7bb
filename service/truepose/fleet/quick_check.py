r"""The fewest configurations that show, each month, whether what ages in a robot has grown.

Parameters are known as they were after the robot's last campaign (a belief); the set-up is found anew, and
each cause may have grown by about as much as is to be told, d ~ N(0, diag(g^2)). With rows J of the readings
and E the directions of the causes,

    C = [ M + sum J'J    sum J'J E       ]^-1
        [ E' sum J'J     E' sum J'J E + g^-2 ]

is the covariance of parameters and changes. Each cause is taken in units of what moves the tool by 1 mm (root
mean square over the candidates), whichever way it goes: a wave in any phase. Configurations are taken one
after another, each the one that lowers most the sum over the causes of their variance over what is asked
(what is known well enough counts little); it is enough where a growth of the asked size would be told with
95 %, at a level of 5 % over all causes together. That is asked of the readings alone: the precision of d,
less that of its prior, times the squared growth is the noncentrality of a chi-square with as many degrees of
freedom as the cause has directions.

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
from truepose.fleet.least import noncentrality
from truepose.identification.problem.belief import Belief
from truepose.planning.promise.knowledge import ArmKnowledge, Knowns
from truepose.planning.work_volume.candidates import Candidates
from truepose.planning.work_volume.work_space import WorkSpace

LEVEL: Final = 0.05  # of checks of robots in which nothing has grown: those that tell anything
_MOST: Final = 60
_WELL: Final = 0.7  # of its goal: a way of a cause that is known so well need not be known better
_SMALL: Final = 1e-9  # of the largest: a cause that moves next to nothing one way is not asked that way
_STILL_MM2: Final = 1e-300  # of a cause that moves nothing


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
    moved = np.einsum("ndp,ndr->pr", motion, motion, optimize=True) / len(motion)
    each = []
    for cause in causes:
        across = np.zeros((len(widths), cause.directions.shape[1]))
        across[place] = cause.directions[:-1] * (stated / widths[place])[:, None]
        each.append(of_one_mm(across, moved))
    directions = np.concatenate(each, axis=1)  # (P, q), each moves 1 mm
    parts = _parts([one.shape[1] for one in each])
    needed = np.array([noncentrality(LEVEL / len(causes), part.stop - part.start) for part in parts])
    rows = np.concatenate([told, told @ directions], axis=2)
    p, q = directions.shape
    known = np.zeros((p + q, p + q))
    known[:p, :p] = knowledge.prior()
    known[p:, p:] = np.eye(q) / grown_mm**2
    # With the prior; of the readings alone that is the squared growth over what is needed.
    goal = np.repeat(grown_mm**2 / (needed + 1.0), [one.shape[1] for one in each])
    order, reached = _chosen(rows, np.linalg.inv(known), parts, goal, most)
    told_mm = grown_mm * np.array([_told(one, needed) for one in reached])
    chosen = candidates.subset(order)
    return QuickCheck(chosen.joints_rad, chosen.nest, told_mm, bool(reached and reached[-1].max() <= 1.0))


def of_one_mm(across: FloatArray, motion_mm2: FloatArray) -> FloatArray:
    """Return directions (P, q) of a cause as such that are at right angles and move the tool by 1 mm each.

    Parameters
    ----------
    across : ndarray, shape (P, q)
    motion_mm2 : ndarray, shape (P, P)
        Mean over configurations of products of motions per unit of each parameter.
    """
    values, turns = np.linalg.eigh(across.T @ motion_mm2 @ across)
    moving = values >= _SMALL * values[-1]
    values = np.maximum(values, _STILL_MM2)
    return np.asarray(across @ (turns[:, moving] / np.sqrt(values[moving])))


def _parts(sizes: Sequence[int]) -> tuple[slice, ...]:
    ends = np.cumsum(sizes).tolist()
    return tuple(slice(end - size, end) for end, size in zip(ends, sizes, strict=True))


def _told(ratio: FloatArray, needed: FloatArray) -> FloatArray:
    """Return which growths (K,) readings alone tell, over the asked one; `ratio` of variances to goals."""
    precision = np.maximum((needed + 1.0) / ratio - 1.0, 0.0)  # of readings alone, in those of the prior
    with np.errstate(divide="ignore"):
        return np.asarray(np.sqrt(needed / precision))


def _chosen(
    rows: FloatArray, covariance: FloatArray, parts: Sequence[slice], goal: FloatArray, most: int
) -> tuple[IntArray, list[FloatArray]]:
    """Return candidates in the order of choice, and each cause's variance over its goal after each, (K,)."""
    q = len(goal)
    free = np.ones(len(rows), dtype=bool)
    order: list[int] = []
    reached: list[FloatArray] = []
    while (not reached or reached[-1].max() > 1.0) and len(order) < min(most, len(rows)):
        seen = rows @ covariance  # (N, d, P + q)
        own = np.eye(rows.shape[1]) + seen @ np.swapaxes(rows, 1, 2)
        part = seen[:, :, -q:]
        lowered = (part * np.linalg.solve(own, part)).sum(axis=1)  # (N, q)
        after = np.maximum((np.diag(covariance)[-q:] - lowered) / goal, _WELL).sum(axis=1)
        best = int(np.argmin(np.where(free, after, np.inf)))
        free[best] = False
        order.append(best)
        covariance = covariance - seen[best].T @ np.linalg.solve(own[best], seen[best])
        reached.append(_worst(covariance[-q:, -q:], parts, goal))
    return np.array(order, dtype=np.int64), reached


def _worst(covariance: FloatArray, parts: Sequence[slice], goal: FloatArray) -> FloatArray:
    """Return the variance of each cause over its goal where it is largest: whichever way it goes."""
    largest = [float(np.linalg.eigvalsh(covariance[part, part])[-1]) / goal[part.start] for part in parts]
    return np.array(largest)
