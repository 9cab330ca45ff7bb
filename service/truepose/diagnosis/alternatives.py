r"""Alternative explanations of findings, and upper limits of causes that were not found.

*Alternatives.* Each pick is taken out of the final model in turn. What explains its place nearly as well, by
BIC, is a rival; causes that differ only in the shape of one curve must be beaten by more.

*Upper limits.* Past the fitted model a candidate's parameters w have the mean m and the covariance C, priors
included. With M the products of the motions that they give the tool, averaged over the readings, its mean
square is the quadratic form w^T M w with the moments

    mean = m^T M m + tr(M C),    variance = 2 tr(M C M C) + 4 m^T M C M m.

The limit is the root of its 95 % quantile, that of the scaled chi-square of these moments.

References
----------
F. E. Satterthwaite, Biometrics Bulletin 2(6), 1946, 110-114 (a chi-square of the same two moments).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from truepose.diagnosis.screening.candidates import View, candidate_motions
from truepose.diagnosis.screening.selection import LEVEL, Selection, names_of
from truepose.diagnosis.screening.significance import Screening, screen
from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Cause, RuledOut
from truepose.effects.causes import Candidate, ErrorSignature, Scene
from truepose.effects.registry import CAUSES
from truepose.effects.signatures import has_trade_name, signature_of
from truepose.identification.distributions import chi2_limit
from truepose.messages.message import message

# In BIC. A name is sure where the odds against each other one are 99 to 1 (R. E. Kass, A. E. Raftery, J.
# American Statistical Association 90, 1995, 773-795). The shape of a slow curve is a formula that nature need
# not follow, so it decides only where it is overwhelming.
_MARGIN = 2.0 * float(np.log(99.0))
_SHAPE_MARGIN = 20.0
# Beside structure that nothing explains, what decides between two causes may be that structure: a rival must
# then fall short by this share of all that the pick explains.
_SHARE_BESIDE_STRUCTURE = 0.15
_RUN_TOGETHER = frozenset({"time", "temperature", "mounting"})  # over a campaign
_SLOW = frozenset({"drift", "settling"})  # one shape: the time constant is part of what is searched
_SLOW_ORDER = 2.5  # a wave so slow that a gain or a coupling can pass for it


@dataclass(frozen=True, slots=True)
class RivalComparison:
    """The picks of a cause beside their rivals.

    Attributes
    ----------
    p_value : float
        Corrected for everything tried.
    explained : float
        Sum of squares that they explain beside the others, each pick by itself.
    rivals : tuple of Cause
        Closest first.
    """

    p_value: float
    explained: float
    rivals: tuple[Cause, ...]


def weigh_alternatives(
    selected: Selection, group: tuple[Candidate, ...], *, structure_left: bool
) -> RivalComparison:
    """Weigh the picks of one cause and subject against everything else that was tried.

    Parameters
    ----------
    selected : Selection
    group : tuple of Candidate
    structure_left : bool
        Whether something is left that nothing explains.

    Returns
    -------
    RivalComparison
    """
    names = names_of(group)
    screened = screen(selected.pool.view(without=names))
    indices = [selected.pool.index_of(pick) for pick in group]
    lead = max(indices, key=lambda index: screened.score[index])
    found: dict[Cause, float] = {}
    best = float(screened.score[lead])
    doubtful = _SHARE_BESIDE_STRUCTURE * best if structure_left else 0.0
    for index in np.argsort(-screened.score):
        other, behind = selected.pool.all[index], float(best - screened.score[index])
        if behind > max(_SHAPE_MARGIN, doubtful):
            break
        cause = Cause(other.effect, other.subject)
        needed = max(_needed(selected.pool.all[lead], other), doubtful)
        if behind <= needed and _differs(group[0], other):
            found.setdefault(cause, behind)
    return RivalComparison(
        p_value=float(min(screened.p_value[index] for index in indices)),
        explained=float(screened.explained[indices].sum()),
        rivals=tuple(found),
    )


def _differs(pick: Candidate, other: Candidate) -> bool:
    """Whether the other is another cause, not a part of the same or the whole that it is part of."""
    if other.effect != pick.effect:
        return True
    plural = {"joints", "links"}
    return other.subject != pick.subject and not plural & {other.subject, pick.subject}


def _needed(pick: Candidate, other: Candidate) -> float:
    """Return by how much, in BIC, another candidate must fall behind to be no rival."""
    return _SHAPE_MARGIN if _differ_in_shape(pick, other) else _MARGIN


def _differ_in_shape(pick: Candidate, other: Candidate) -> bool:
    """Whether two candidates are the same curve over the same variable but for its shape."""
    one, another = signature_of(pick), signature_of(other)
    if {one.over, another.over} <= _RUN_TOGETHER:
        return one.shape != another.shape and not {one.shape, another.shape} <= _SLOW
    if one.over == another.over and not (has_trade_name(pick.effect) and has_trade_name(other.effect)):
        return False  # the same place and the same variable: whichever shape is told, these are right
    # Over less than a turn a gain, a coupling and a slow wave of one joint are the same gently bent line.
    angles = all(cell.over.startswith("angle") for cell in (one, another))
    return angles and one.where == another.where and _is_slow(pick, one) and _is_slow(other, another)


def _is_slow(candidate: Candidate, cell: ErrorSignature) -> bool:
    """Whether a candidate is a line, or a wave that may pass for one over the angles measured."""
    return cell.shape == "line" or candidate.variant <= _SLOW_ORDER


_BEYOND = 0.05  # chance that it is larger all the same


def upper_limits_mm(view: View, chosen: Sequence[int]) -> tuple[float, ...]:
    """Return how large candidates could still be, RMS at the tool over the readings.

    Parameters
    ----------
    view : View
        All candidates beside the fitted model.
    chosen : sequence of int
        Which of them; none of them a function, whose size has no prior.

    Returns
    -------
    tuple of float
        95 % limits [mm], in the order of `chosen`.
    """
    motions = candidate_motions(view.pool.fit, [view.pool.all[index] for index in chosen])
    return tuple(_limit(view, index, motion) for index, motion in zip(chosen, motions, strict=True))


def _limit(view: View, index: int, motion_mm: FloatArray) -> float:
    """Return the 95 % limit of one candidate [mm], motions (k, n, d) per unit of its parameters.

    With S = M C the scaled chi-square of mean s and variance v has 2 s^2 / v degrees of freedom.
    """
    mean, covariance = _posterior(view, index)
    readings = motion_mm.shape[1]
    products = np.einsum("ink,jnk->ij", motion_mm, motion_mm) / readings
    spread = products @ covariance
    size = float(mean @ products @ mean + np.trace(spread))
    variance = float(2.0 * np.trace(spread @ spread) + 4.0 * mean @ spread @ products @ mean)
    if size <= 0.0 or variance <= 0.0:
        return 0.0
    degrees = 2.0 * size**2 / variance
    return float(np.sqrt(size / degrees * chi2_limit(_BEYOND, degrees)))


def _posterior(view: View, index: int) -> tuple[FloatArray, FloatArray]:
    """Mean (k,) and covariance (k, k) of a candidate's parameters past what is fitted."""
    own = view.pool.own(index)
    noise = view.sums.variance * view.sums.alike
    widths = np.array([spec.prior_width for spec in view.pool.all[index].specs])
    # In units of the prior widths, so that shifts and turns are alike.
    information = view.gram(index) * np.outer(widths, widths) / noise
    covariance = np.linalg.inv(information + np.eye(len(widths)))
    mean = covariance @ (view.towards[own] * widths) / noise
    return np.asarray(mean * widths), np.asarray(covariance * np.outer(widths, widths))


def ruled_out(
    scene: Scene, selected: Selection, found: frozenset[Cause], without: tuple[str, ...]
) -> tuple[RuledOut, ...]:
    """Return what was tried and not found, and what cannot be seen.

    Parameters
    ----------
    scene : Scene
    selected : Selection
    found : frozenset of Cause
        What has a finding.
    without : tuple of str
        Causes that are left out of the library.

    Returns
    -------
    tuple of RuledOut
        One entry per cause and subject, smallest p value first; then those that the model absorbs, then those
        that the data cannot show.
    """
    tried = _tried(selected, found) if selected.pool.all else ()
    return (
        *sorted(tried, key=lambda one: (not one.visible, one.p_value or 0.0)),
        *_unseen(scene, without),
    )


def _tried(selected: Selection, found: frozenset[Cause]) -> Iterator[RuledOut]:
    """Yield an entry for each cause that was tried and not found."""
    view = selected.pool.view()
    screened = screen(view)
    order = np.argsort(screened.p_value, kind="stable").tolist()
    best = _first_of_each(selected, found, order)
    # The candidate of the smallest p value may be a curve, which has no limit: the next one then states it.
    limited = _first_of_each(selected, found, [k for k in order if _has_limit(selected, screened, k)])
    limits = dict(zip(limited, upper_limits_mm(view, tuple(limited.values())), strict=True))
    for cause, index in best.items():
        size, p_value = float(screened.size[index]), float(screened.p_value[index])
        entry = _entry(cause, size, p_value)
        yield replace(entry, upper_limit_mm=limits.get(cause) if entry.visible else None)


def _first_of_each(selected: Selection, found: frozenset[Cause], order: Sequence[int]) -> dict[Cause, int]:
    """Return the first candidate of each cause that was not found."""
    first: dict[Cause, int] = {}
    for index in order:
        candidate = selected.pool.all[index]
        first.setdefault(Cause(candidate.effect, candidate.subject), index)
    return {cause: index for cause, index in first.items() if cause not in found}


def _has_limit(selected: Selection, screened: Screening, index: int) -> bool:
    """Whether a candidate can be seen, and has a prior that bounds it."""
    return float(screened.size[index]) > 0.0 and not selected.pool.all[index].function


def _entry(cause: Cause, size: float, p_value: float) -> RuledOut:
    """Return the entry of a cause by its number of visible parameters and its p value."""
    if size == 0.0:
        return RuledOut(
            cause.effect,
            cause.subject,
            message("ruled_out.absorbed"),
            None,
            visible=False,
        )
    reason = message("ruled_out.chance" if p_value > LEVEL else "ruled_out.costs_more")
    return RuledOut(cause.effect, cause.subject, reason, p_value)


def _unseen(scene: Scene, without: tuple[str, ...]) -> tuple[RuledOut, ...]:
    """Return an entry for each cause that these data cannot show, with what would."""
    reasons = ((name, cause.unseen(scene)) for name, cause in CAUSES.items() if name not in without)
    return tuple(
        RuledOut(name, "", reason, None, visible=False) for name, reason in reasons if reason is not None
    )
