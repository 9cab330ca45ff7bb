"""Rivals: causes that these data cannot tell from the one that was picked.

Each pick is taken out of the final model in turn. What explains its place nearly as well, by BIC, is a
rival; causes that differ only in the shape of one curve must be beaten by more.
"""

from dataclasses import dataclass

import numpy as np

from truepose.diagnosis.screening.explained import screen
from truepose.diagnosis.screening.groups import names_of
from truepose.diagnosis.screening.selection import Selected
from truepose.domain.results.causes import Cause
from truepose.effects.causes import Candidate
from truepose.effects.cells import Cell, cell_of
from truepose.effects.unnamed.cause import NAME as UNNAMED

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
class Weighed:
    """A pick group beside its rivals."""

    p_value: float  # corrected
    explained: float  # sum of squares that it alone explains beside the others
    rivals: tuple[Cause, ...]  # closest first


def weighed(selected: Selected, group: tuple[Candidate, ...], *, structure_left: bool) -> Weighed:
    """Weigh the picks of one cause and subject against everything else that was tried."""
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
    return Weighed(
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
    return _SHAPE_MARGIN if _differ_in_shape(pick, other) else _MARGIN


def _differ_in_shape(pick: Candidate, other: Candidate) -> bool:
    one, another = cell_of(pick), cell_of(other)
    if {one.over, another.over} <= _RUN_TOGETHER:
        return one.shape != another.shape and not {one.shape, another.shape} <= _SLOW
    if UNNAMED in (pick.effect, other.effect) and one.over == another.over:
        return False  # the same place and the same variable: whichever shape is told, these are right
    angles = all(cell.over.startswith("angle") for cell in (one, another))
    return angles and one.where == another.where and _is_slow(pick, one) and _is_slow(other, another)


def _is_slow(candidate: Candidate, cell: Cell) -> bool:
    return cell.shape == "line" or candidate.variant <= _SLOW_ORDER
