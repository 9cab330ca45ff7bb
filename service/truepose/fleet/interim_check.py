r"""The interim check of a robot: which configurations show that nothing has grown, and what they said.

*Plan.* The fewest configurations that show, each month, whether what ages has grown. Parameters are known as
they were after the robot's last campaign (a belief); the set-up is found anew, and each cause may have grown
by about as much as is to be told, d ~ N(0, diag(g^2)). With rows J of the readings and E the directions of
the causes,

    C = [ M + sum J'J    sum J'J E       ]^-1
        [ E' sum J'J     E' sum J'J E + g^-2 ]

is the covariance of parameters and changes. Each cause is taken in units of what moves the tool by 1 mm (root
mean square over the candidates), whichever way it goes: a wave in any phase. Configurations are taken one
after another, each the one that lowers most the sum over the causes of their variance over what is asked
(what is known well enough counts little); it is enough where a growth of the asked size would be told with 95
%, at a level of 5 % over all causes together. That is asked of the readings alone: the precision of d, less
that of its prior, times the squared growth is the noncentrality of a chi-square with as many degrees of
freedom as the cause has directions.

*Answer.* Whether anything that ages has grown since the robot was last measured. It is known as it was after
its last campaign, p ~ N(m, V). The check tells A p = b, its set-up integrated out, and each of the other
causes may have grown by about as much as was asked, with E_j its directions in units of what moves the tool
by 1 mm. Then the score and the information of a cause,

    U = E' (I + A W)^-1 (b - A m)    F = E' (I + A W)^-1 A E    W = V + g^2 sum_j E_j E_j'

give the chance of U' F^-1 U, chi-square where it has not grown. The level is that of the plan, over all
causes together.

References
----------
V. V. Fedorov, Theory of Optimal Experiments, 1972, chapter 2 (part of the parameters).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.effects.ports import Trait
from truepose.effects.registry import effect_named, effects_with
from truepose.fleet.campaigns import Information
from truepose.fleet.causes import AgeingCause, robot_causes
from truepose.fleet.changes import Account
from truepose.fleet.minimum_detectable_change import noncentrality
from truepose.fleet.predicted_accuracy import of_robot_now
from truepose.identification.distributions import chi2_exceeded
from truepose.identification.problem.build import JointPrior
from truepose.planning.prediction.expected_covariance import LEAST_MM, ArmKnowledge, PriorKnowledge
from truepose.planning.workspace.candidates import Candidates, draw_candidates
from truepose.planning.workspace.space import WorkSpace

LEVEL: Final = 0.05  # of checks of robots in which nothing has grown: those that tell anything
_MOST: Final = 60
_WELL: Final = 0.7  # of its goal: a way of a cause that is known so well need not be known better
_SMALL: Final = 1e-9  # of the largest: a cause that moves next to nothing one way is not asked that way


@dataclass(frozen=True, slots=True)
class InterimCheck:
    """Configurations to measure each month.

    Attributes
    ----------
    joints_rad : ndarray, shape (n, J)
        In the order of choice.
    nest : ndarray, shape (n,)
        1-based.
    enough : bool
        Whether they tell what was asked.
    """

    joints_rad: FloatArray
    nest: IntArray
    enough: bool


def quick_check(
    space: WorkSpace,
    candidates: Candidates,
    belief: JointPrior,
    causes: Sequence[AgeingCause],
    grown_mm: float,
    knowns: PriorKnowledge,
    most: int = _MOST,
) -> InterimCheck:
    """Choose the configurations.

    Parameters
    ----------
    space : WorkSpace
    candidates : Candidates
        To choose from.
    belief : JointPrior
        Of the robot as it is now.
    causes : sequence of AgeingCause
        K causes that age, over the belief's parameters and the scale.
    grown_mm : float
        Growth that is to be told, root mean square over the candidates.
    knowns : PriorKnowledge
        Of instrument and artefacts; what it believes is replaced.
    most : int
        Configurations at most.

    Returns
    -------
    InterimCheck

    Raises
    ------
    ConfigurationError
        No cause was given, one is an instrument's, or the growth is not above 0.
    """
    if not causes or not grown_mm > 0.0:
        raise ConfigurationError("An interim check needs at least one cause and a growth greater than 0 mm.")
    if not all(cause.directions[:-1].any() for cause in causes):
        raise ConfigurationError(
            "An interim check detects ageing of the robot, not of the scale of an instrument. Choose causes "
            "in the robot."
        )
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
    # In units of 1 mm, so that one growth is asked of springs, waves and zeros alike.
    directions = np.concatenate(each, axis=1)  # (P, q), each moves 1 mm
    parts = _parts([one.shape[1] for one in each])
    needed = np.array([noncentrality(LEVEL / len(causes), part.stop - part.start) for part in parts])
    rows = np.concatenate([told, told @ directions], axis=2)
    p, q = directions.shape
    known = np.zeros((p + q, p + q))
    known[:p, :p] = knowledge.prior()
    # All causes may have grown at once: what one of them does must not be told of another.
    known[p:, p:] = np.eye(q) / grown_mm**2
    # The prior's own precision is 1 of lambda + 1: at the goal the readings alone have the noncentrality
    # lambda.
    goal = np.repeat(grown_mm**2 / (needed + 1.0), [one.shape[1] for one in each])
    order, reached = _chosen(rows, np.linalg.inv(known), parts, goal, most)
    chosen = candidates.subset(order)
    return InterimCheck(chosen.joints_rad, chosen.nest, bool(reached and reached[-1].max() <= 1.0))


def of_one_mm(across: FloatArray, motion_mm2: FloatArray) -> FloatArray:
    """Return directions (P, q) of a cause as such that are at right angles and move the tool by 1 mm each.

    Of a cause that moves nothing beyond rounding, such as a spring about a plumb axis: one, of zeros.

    Z = E V diag(m)^-1/2 with E' M E = V diag(m) V', directions that move next to nothing left out: Z' M Z =
    I.

    Parameters
    ----------
    across : ndarray, shape (P, q)
        E.
    motion_mm2 : ndarray, shape (P, P)
        M, mean over configurations of products of motions per unit of each parameter.

    Returns
    -------
    ndarray, shape (P, r), r <= q
    """
    values, turns = np.linalg.eigh(across.T @ motion_mm2 @ across)
    rounding = LEAST_MM**2 * float((across**2).sum())
    if not values[-1] > rounding:
        return np.zeros((len(across), 1))
    moving = values >= max(_SMALL * values[-1], rounding)
    return np.asarray(across @ (turns[:, moving] / np.sqrt(values[moving])))


def _parts(sizes: Sequence[int]) -> tuple[slice, ...]:
    ends = np.cumsum(sizes).tolist()
    return tuple(slice(end - size, end) for end, size in zip(ends, sizes, strict=True))


def _chosen(
    rows: FloatArray, covariance: FloatArray, parts: Sequence[slice], goal: FloatArray, most: int
) -> tuple[IntArray, list[FloatArray]]:
    """Return candidates in the order of choice, and each cause's variance over its goal after each, (K,).

    With C the covariance and J a candidate's rows, its variances fall by diag(C J' (I + J C J')^-1 J C);
    taken is the one that lowers most the sum over the causes of their variance over the goal, not below 0.7
    of it each.
    """
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
    # The worst way, not the mean: a wave in the phase that no configuration shows would pass unseen.
    largest = [float(np.linalg.eigvalsh(covariance[part, part])[-1]) / goal[part.start] for part in parts]
    return np.array(largest)


_GEAR_LINES: Final = 10.0  # periods per turn from which a wave is a gear's
_CANDIDATES: Final = 300


def needs_both_directions(cause: AgeingCause) -> bool:
    """Return whether a cause shows only where configurations are approached from either side, as a gap.

    Parameters
    ----------
    cause : AgeingCause

    Returns
    -------
    bool
    """
    return "direction" in effect_named(cause.effect).needs


def checked_causes(account: Account) -> tuple[AgeingCause, ...]:
    """Return what ages: the springs and the lines of the gears, and whatever was named of a robot.

    A gap is none of them: configurations that are approached from one side never show it.

    Parameters
    ----------
    account : Account

    Returns
    -------
    tuple of AgeingCause

    Raises
    ------
    ConfigurationError
        The campaigns tell of nothing that ages.
    """
    named = {
        one.change.cause.key
        for one in account.named
        if one.change.scope == "robot" and not needs_both_directions(one.change.cause)
    }
    asked = tuple(
        cause
        for cause in robot_causes(account.fleet)
        if cause.effect in effects_with(Trait.SPRINGS) or cause.order > _GEAR_LINES or cause.key in named
    )
    if not asked:
        raise ConfigurationError(
            "An interim check detects ageing of the robot, but this fleet has no joint compliance, no gear "
            "harmonics and no change of a robot. Compare campaigns identified with such effects."
        )
    return asked


def check_of(
    account: Account, robot: str, space: WorkSpace, knowns: PriorKnowledge, grown_mm: float, seed: int = 0
) -> InterimCheck:
    """Choose the configurations that tell whether a robot's causes have grown.

    Parameters
    ----------
    account : Account
    robot : str
        Of the fleet.
    space : WorkSpace
        As it was measured last.
    knowns : PriorKnowledge
    grown_mm : float
        Growth that is to be told.
    seed : int
        The same seed chooses the same configurations.

    Returns
    -------
    InterimCheck

    Raises
    ------
    ConfigurationError
        The growth is not above 0, or nothing ages.
    WorkSpaceError, TooFewCandidatesError
        As `draw_candidates`.
    """
    candidates = draw_candidates(space, _CANDIDATES, np.random.default_rng(seed))
    belief = of_robot_now(account, robot)
    return quick_check(space, candidates, belief, checked_causes(account), grown_mm, knowns)


@dataclass(frozen=True, slots=True)
class CauseGrowth:
    """What a check says of one cause."""

    cause: AgeingCause
    size_mm: float  # root mean square at the fleet's configurations
    u_mm: float  # standard uncertainty
    chance: float  # of so much where it has not grown
    is_told: bool  # beyond chance, over all causes together
    least_mm: float  # from which on it would have been told with 95 %; inf: at no size


def grown(account: Account, robot: str, told: Information, asked_mm: float) -> tuple[CauseGrowth, ...]:
    """Judge a check.

    Parameters
    ----------
    account : Account
        Without the campaign of the check.
    robot : str
        Of the fleet.
    told : Information
        Of the check, without its instrument's scale.
    asked_mm : float
        Growth that it was planned for.

    Returns
    -------
    tuple of CauseGrowth
        One for each cause that is asked, the least likely to be chance first.

    Raises
    ------
    ConfigurationError
        The campaigns tell of nothing that ages.
    """
    belief, causes = of_robot_now(account, robot), checked_causes(account)
    widths = account.fleet.widths
    normal, right = _over(told, belief.names, widths)
    # Its campaigns count by how much they scatter, and a check is one more of them.
    ratio = account.birge_ratios[account.fleet.robots.index(robot)]
    normal, right = normal / ratio, right / ratio
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
) -> Iterator[CauseGrowth]:
    """Yield what a check says of each cause, from its score and information as in the head of the module."""
    normal, left = told
    for cause, way in zip(causes, ways, strict=True):
        # Its own growth is what is asked, so that it is none of the scatter.
        others = spread - asked_mm**2 * way @ way.T
        held = np.linalg.inv(np.eye(len(left)) + normal @ others)
        score, information = way.T @ held @ left, way.T @ held @ normal @ way
        yield _of(cause, score, 0.5 * (information + information.T), LEVEL / len(causes))


def _of(cause: AgeingCause, score: FloatArray, information: FloatArray, level: float) -> CauseGrowth:
    """Return what a score says of a cause: v = F^-1 U of size |v|, known to sqrt(v' F^-1 v) / |v|.

    Where the check does not see some direction of it, nothing is told.
    """
    least = float(np.linalg.eigvalsh(information)[0])
    # A direction that the check does not see leaves the size open, however well the others are known.
    if least <= 0.0:
        return CauseGrowth(cause, 0.0, np.inf, 1.0, is_told=False, least_mm=np.inf)
    covariance = np.linalg.inv(information)
    amount = covariance @ score
    size = float(np.linalg.norm(amount))
    chance = chi2_exceeded(float(score @ amount), float(len(score)))
    u = float(np.sqrt(amount @ covariance @ amount)) / max(size, 1e-300)
    shown = float(np.sqrt(noncentrality(level, len(score)) / least))
    return CauseGrowth(cause, size, u, chance, chance <= level, shown)
