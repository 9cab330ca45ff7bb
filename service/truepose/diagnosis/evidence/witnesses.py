"""Fixed nests as witnesses: they stand still, so what moves them in time is the instrument.

A model that they contradict lacks something that runs or happens in time, and what it says of the base or of
a joint over time may be that. Such a finding is not certain, and the same of the instrument is its rival.
"""

from truepose.diagnosis.screening.selection import Selected
from truepose.domain.results.causes import Cause
from truepose.effects.cells import Cell, cell_of
from truepose.identification.fit.robust import RobustFit

LEVEL = 1e-3  # chance that nests which stand still are taken for contradicting
_SLOW = frozenset({"drift", "settling"})


def speak_against(fit: RobustFit, cell: Cell) -> bool:
    """Return whether fixed nests contradict a model and, with it, what it says of a cell."""
    return cell.over == "time" and chance_of_nests(fit) < LEVEL


def chance_of_nests(fit: RobustFit) -> float:
    """Return the chance that nests which stand still read as they do; 1 where none was read."""
    return min(block.contradiction(result) for block, result in zip(fit.blocks, fit.results, strict=True))


def accused(selected: Selected, cell: Cell) -> tuple[Cause, ...]:
    """Return what of the instrument would look like a cell, as far as it was tried and not found."""
    found = {Cause(pick.effect, pick.subject) for pick in selected.picks}
    tried = dict.fromkeys(
        Cause(candidate.effect, candidate.subject)
        for candidate in selected.pool.all
        if _alike(cell_of(candidate), cell)
    )
    return tuple(cause for cause in tried if cause not in found)


def _alike(other: Cell, cell: Cell) -> bool:
    same = other.shape == cell.shape or {other.shape, cell.shape} <= _SLOW
    return other.where == "tracker" and other.over == cell.over and same
