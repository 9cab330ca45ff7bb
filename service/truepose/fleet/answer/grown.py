r"""What a check of a robot says: whether anything that ages in it has grown since it was last measured.

The robot is known as it was after its last campaign, p ~ N(m, V). The check tells A p = b, its set-up
integrated out, and each of the other causes may have grown by about as much as was asked, with E_j its
directions in units of what moves the tool by 1 mm. Then the score and the information of a cause,

    U = E' (I + A W)^-1 (b - A m)    F = E' (I + A W)^-1 A E    W = V + g^2 sum_j E_j E_j'

give the chance of U' F^-1 U, chi-square where it has not grown. The level is that of `fleet.quick_check`,
over all causes together.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.fleet.answer.check import asked_of
from truepose.fleet.causes import AgeingCause
from truepose.fleet.changes import Account
from truepose.fleet.information import Information
from truepose.fleet.least import noncentrality
from truepose.fleet.pooled import of_robot_now
from truepose.fleet.quick_check import LEVEL, of_one_mm
from truepose.identification.distributions import chi2_exceeded


@dataclass(frozen=True, slots=True)
class Grown:
    """What a check says of one cause."""

    cause: AgeingCause
    size_mm: float  # root mean square at the fleet's configurations
    u_mm: float  # standard uncertainty
    chance: float  # of so much where it has not grown
    is_told: bool  # beyond chance, over all causes together
    least_mm: float  # from which on it would have been told with 95 %; inf: at no size


def grown(account: Account, robot: str, told: Information, asked_mm: float) -> tuple[Grown, ...]:
    """Judge a check.

    Parameters
    ----------
    account : Account
        Without the campaign of the check.
    robot : str
    told : Information
        Of the check, without its instrument's scale.
    asked_mm : float
        Growth that it was planned for.

    Returns
    -------
    tuple of Grown
        One for each cause that is asked, the least likely to be chance first.
    """
    belief, causes = of_robot_now(account, robot), asked_of(account)
    widths = account.fleet.widths
    normal, right = _over(told, belief.names, widths)
    normal, right = normal / account.birge_ratio, right / account.birge_ratio
    left = right - normal @ (belief.mean / widths)
    known = belief.covariance / np.outer(widths, widths)
    motion = account.fleet.motion_mm2[:-1, :-1]
    ways = [of_one_mm(cause.directions[:-1], motion) for cause in causes]
    spread = known + asked_mm**2 * sum(way @ way.T for way in ways)
    each = _judged(causes, ways, (normal, left), spread, asked_mm)
    return tuple(sorted(each, key=lambda one: one.chance))


def _over(told: Information, names: Sequence[str], widths: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return what a check tells over parameters of these names, in widths; nothing of those it has not."""
    place = [k for k, name in enumerate(names) if name in told.names]
    at = [told.names.index(names[k]) for k in place]
    normal, right = np.zeros((len(names), len(names))), np.zeros(len(names))
    normal[np.ix_(place, place)] = told.normal[np.ix_(at, at)]
    right[place] = told.right[at]
    return normal * np.outer(widths, widths), right * widths


def _judged(
    causes: Sequence[AgeingCause],
    ways: Sequence[FloatArray],
    told: tuple[FloatArray, FloatArray],
    spread: FloatArray,
    asked_mm: float,
) -> Iterator[Grown]:
    normal, left = told
    for cause, way in zip(causes, ways, strict=True):
        others = spread - asked_mm**2 * way @ way.T
        held = np.linalg.inv(np.eye(len(left)) + normal @ others)
        score, information = way.T @ held @ left, way.T @ held @ normal @ way
        yield _of(cause, score, 0.5 * (information + information.T), LEVEL / len(causes))


def _of(cause: AgeingCause, score: FloatArray, information: FloatArray, level: float) -> Grown:
    least = float(np.linalg.eigvalsh(information)[0])
    if least <= 0.0:
        return Grown(cause, 0.0, np.inf, 1.0, is_told=False, least_mm=np.inf)
    covariance = np.linalg.inv(information)
    amount = covariance @ score
    size = float(np.linalg.norm(amount))
    chance = chi2_exceeded(float(score @ amount), float(len(score)))
    u = float(np.sqrt(amount @ covariance @ amount)) / max(size, 1e-300)
    shown = float(np.sqrt(noncentrality(level, len(score)) / least))
    return Grown(cause, size, u, chance, chance <= level, shown)
