"""Moments of jumps: of many readings only some gaps are tried; what jumped is then placed in the very gap.

A moment that is off by some readings leaves these on the wrong side: they would pass for bad ones. So they
weigh here as they did before any jump was known. A jump between two tried moments is often chosen at both of
them, one after the other: two that meet in one gap are one jump.
"""

from dataclasses import replace

import numpy as np

from truepose.diagnosis.screening.candidates import pooled
from truepose.diagnosis.screening.explained import screen
from truepose.diagnosis.screening.selection import Propose, Selected, reselected
from truepose.effects.causes import Candidate, Scene
from truepose.effects.cells import cell_of
from truepose.effects.registry import CAUSES
from truepose.identification.fit.robust import RobustFit, fit


def with_exact_moments(start: RobustFit, selected: Selected, propose: Propose, scene: Scene) -> Selected:
    """Return the selection with every jump in the gap between two stops that explains most."""
    jumps = [pick for pick in selected.picks if cell_of(pick).shape == "jump"]
    if not jumps:
        return selected
    solution = fit(selected.fit.structure, start.blocks, selected.fit.values)
    weighed = replace(selected.fit, blocks=start.blocks, solution=solution, gross=start.gross)
    placed = {pick.names: _placed(weighed, selected, pick, scene) for pick in jumps}
    found = (placed.get(pick.names, pick) for pick in selected.picks)
    picks = tuple({pick.names: pick for pick in found}.values())
    return selected if picks == selected.picks else reselected(start, selected, picks, propose)


def _placed(weighed: RobustFit, selected: Selected, jump: Candidate, scene: Scene) -> Candidate:
    """Return a jump in the gap that explains most between the moments that were tried beside it."""
    tried = [
        one.variant for one in selected.pool.all if (one.effect, one.subject) == (jump.effect, jump.subject)
    ]
    before = max((moment for moment in tried if moment < jump.variant), default=-np.inf)
    after = min((moment for moment in tried if moment > jump.variant), default=np.inf)
    others = replace(scene, present=scene.present - set(jump.names), between_s=(before, after))
    found = [one for one in CAUSES[jump.effect].candidates(others) if _same_place(one, jump)]
    if not found:
        return jump
    view = pooled(weighed, found).view(without=jump.names)
    return found[int(np.argmax(screen(view).explained))]


def _same_place(one: Candidate, jump: Candidate) -> bool:
    return one.subject == jump.subject and cell_of(one).shape == "jump"
