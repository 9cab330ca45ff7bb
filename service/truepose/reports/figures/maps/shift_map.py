"""By how much targets are shifted, where they are: arrows from above and from the side, exaggerated."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from truepose.domain.arrays import FloatArray
from truepose.domain.results.corrections import CorrectedTargets
from truepose.reports.figures.canvas import AFTER, INK, MUTED, name_axes, new_figure, page_style, to_svg
from truepose.reports.figures.maps.work_space import exaggeration
from truepose.words.catalogue import Catalogue

_MOST_ARROWS: Final = 400
_VIEWS: Final = ((0, 1, "space.from_above"), (0, 2, "space.from_the_front"))


@dataclass(frozen=True, slots=True)
class ShiftMap:
    """The picture and what its caption must state."""

    picture: Markup
    exaggeration: float
    shown: int
    total: int


def shift_map(targets: CorrectedTargets, words: Catalogue) -> ShiftMap | None:
    """Draw the shifts of corrected targets, of many an even selection; None where nothing was corrected."""
    known = np.flatnonzero(np.isfinite(targets.shift_mm).all(axis=1))
    if not len(known):
        return None
    rows = known[:: -(-len(known) // _MOST_ARROWS)]
    place, shift = targets.place_mm[rows], targets.shift_mm[rows]
    # With the base in the picture a single target has its place too.
    scale = exaggeration(np.vstack([place, np.zeros(3)]), shift)
    with page_style():
        figure = new_figure(8.0, 3.9)
        for axes, (across, up, name) in zip(figure.subplots(1, 2), _VIEWS, strict=True):
            _view(axes, place[:, [across, up]], scale * shift[:, [across, up]])
            axes.set_title(words.say(name))
            name_axes(axes, words, "xyz"[across], "xyz"[up])
        picture = to_svg(figure, "shifts", words.say("shifts.picture"))
    return ShiftMap(picture, scale, len(rows), len(known))


def _view(axes: Axes, place: FloatArray, shift: FloatArray) -> None:
    axes.quiver(
        *place.T, *shift.T, color=AFTER, angles="xy", scale_units="xy", scale=1.0, width=0.004, headwidth=4
    )
    axes.plot(*place.T, ".", color=MUTED, markersize=2.0)
    axes.plot(0.0, 0.0, "+", color=INK, markersize=9.0)
    axes.update_datalim(place + shift)  # quiver itself counts the tails only
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.locator_params(nbins=5)
