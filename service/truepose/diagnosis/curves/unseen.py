"""Readings that were never fitted, in the curves of findings: a line that holds goes through them too."""

from dataclasses import dataclass, replace

import numpy as np

from truepose.diagnosis.circumstances import scene_at
from truepose.diagnosis.curves.drawn import finding_curve
from truepose.diagnosis.evidence.held_out import validation_block
from truepose.diagnosis.screening.selection import Selected
from truepose.diagnosis.start import Start
from truepose.domain.results.diagnosis import Curve, CurvePoints
from truepose.effects.causes import Candidate, Scene
from truepose.effects.cells import drawn_as
from truepose.identification.observations.blocks import linearise_blocks

# Other readings give the quantity of their curves another size or zero: they cannot stand in one picture.
_MEASURED_BY_THEIR_READINGS = frozenset({"shift", "level"})


@dataclass(frozen=True, slots=True)
class Unseen:
    """The extended model at the validation readings instead of those that it was fitted to."""

    selected: Selected
    scene: Scene

    def added_to(self, curve: Curve, group: tuple[Candidate, ...]) -> Curve:
        """Return a curve with these readings in it, where they can be drawn on the same axes."""
        if drawn_as(group[0].effect) in _MEASURED_BY_THEIR_READINGS:
            return curve
        there = finding_curve(self.selected, self.scene, group)
        if there is None or (there.variable, there.quantity) != (curve.variable, curve.quantity):
            return curve
        return replace(curve, unseen=CurvePoints(there.x, there.residual, there.standard_uncertainty))


def unseen_of(start: Start, selected: Selected) -> Unseen | None:
    """Return the extended model at the validation readings; None where there are none."""
    block = validation_block(start.campaign, selected.fit.structure)
    if block is None:
        return None
    fit = selected.fit
    there = linearise_blocks(fit.structure, (block,), fit.values, None)
    moved = replace(fit, blocks=(block,), solution=replace(fit.solution, final=there), gross=fit.gross[:1])
    scene = scene_at(start.problem, there.results[0].state, np.zeros(0))
    return Unseen(replace(selected, fit=moved), scene)


def curve_with_unseen(
    curve: Curve | None, unseen: Unseen | None, group: tuple[Candidate, ...]
) -> Curve | None:
    """Return the curve of a finding with the validation readings, where both are there."""
    return curve if curve is None or unseen is None else unseen.added_to(curve, group)
