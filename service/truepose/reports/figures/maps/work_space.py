"""Error vectors where the tool stood, exaggerated: before in space, after in space and in three views."""

from dataclasses import dataclass
from typing import Any  # matplotlib's 3D axes carry no types

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from truepose.domain.arrays import FloatArray
from truepose.identification.verdict.judge import Judged
from truepose.reports.figures.canvas import (
    AFTER,
    BEFORE,
    MUTED,
    marked_in,
    name_axes,
    new_figure,
    page_style,
    to_svg,
)
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_MOST_VECTORS = 250
_SHARE_OF_SPACE = 0.12  # length of a large (95 %) error, of the extent of the work space
_VIEWS = ((0, 1, "space.from_above"), (0, 2, "space.from_the_front"), (1, 2, "space.from_the_side"))


@dataclass(frozen=True, slots=True)
class WorkSpaceFigures:
    """The pictures and what their captions must state."""

    in_space: Markup
    views: Markup
    exaggeration_before: float
    exaggeration_after: float
    shown: int
    total: int


def work_space(judged: Judged, words: Catalogue = IN_ENGLISH) -> WorkSpaceFigures:
    """Draw the errors of `judged`; where there are too many, an even selection of them."""
    total = len(judged.position_mm)
    shown = slice(None, None, -(-total // _MOST_VECTORS))
    points = judged.position_mm[shown]
    before = judged.vectors_mm(judged.nominal_mm)[shown]
    after = judged.vectors_mm(judged.identified_mm)[shown]
    scales = exaggeration(points, before), exaggeration(points, after)
    return WorkSpaceFigures(
        in_space=_in_space(points, before * scales[0], after * scales[1], scales, words),
        views=views(points, after * scales[1], "views", words),
        exaggeration_before=scales[0],
        exaggeration_after=scales[1],
        shown=len(points),
        total=total,
    )


def exaggeration(points_mm: FloatArray, vectors_mm: FloatArray) -> float:
    """Return a factor of 1, 2 or 5 times a power of ten that makes large errors visible in the space."""
    extent = float(np.ptp(points_mm, axis=0).max())
    large = float(np.quantile(np.linalg.norm(vectors_mm, axis=1), 0.95))
    if extent <= 0.0 or large <= 0.0:
        return 1.0
    wanted = max(_SHARE_OF_SPACE * extent / large, 1.0)
    decade = 10.0 ** np.floor(np.log10(wanted))
    return float(max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= wanted * (1.0 + 1e-9)))


def _in_space(
    points: FloatArray,
    before: FloatArray,
    after: FloatArray,
    scales: tuple[float, float],
    words: Catalogue,
) -> Markup:
    with page_style():
        figure = new_figure(8.0, 4.4)
        panels = ((before, BEFORE, "before", scales[0]), (after, AFTER, "after", scales[1]))
        for column, (vectors, colour, name, scale) in enumerate(panels, start=1):
            axes = figure.add_subplot(1, 2, column, projection="3d")
            _space_panel(axes, points, vectors, colour, words)
            axes.set_title(words.say("space.larger", name=words.say(name), times=scale))
        return to_svg(figure, "space", words.say("space.picture"))


def _space_panel(axes: Any, points: FloatArray, vectors: FloatArray, colour: str, words: Catalogue) -> None:
    axes.quiver(*points.T, *vectors.T, color=colour, linewidth=0.9, arrow_length_ratio=0.25)
    axes.plot(*points.T, ".", color=MUTED, markersize=1.2)
    conversion = words.units.conversion("mm")
    axes.set_xlabel(f"x [{conversion.symbol}]")
    axes.set_ylabel(f"y [{conversion.symbol}]")
    axes.set_zlabel(f"z [{conversion.symbol}]")
    axes.set_box_aspect(np.maximum(np.ptp(points, axis=0), 1.0), zoom=0.88)
    axes.locator_params(nbins=4)
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        marked_in(axis, conversion)
        axis.set_pane_color((0.0, 0.0, 0.0, 0.0))


def views(points: FloatArray, vectors: FloatArray, ident: str, words: Catalogue) -> Markup:
    """Draw vectors (n, 3) at points (n, 3) from above, from the front and from the side."""
    with page_style():
        figure = new_figure(8.0, 3.1)
        for axes, (across, up, name) in zip(figure.subplots(1, 3), _VIEWS, strict=True):
            _view(axes, points[:, [across, up]], vectors[:, [across, up]])
            axes.set_title(words.say(name))
            name_axes(axes, words, "xyz"[across], "xyz"[up])
        return to_svg(figure, ident, words.say("space.views"))


def _view(axes: Axes, points: FloatArray, vectors: FloatArray) -> None:
    axes.quiver(
        *points.T, *vectors.T, color=AFTER, angles="xy", scale_units="xy", scale=1.0, width=0.005, headwidth=4
    )
    axes.plot(*points.T, ".", color=MUTED, markersize=1.2)
    axes.update_datalim(points + vectors)  # quiver itself counts the tails only
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.locator_params(nbins=4)
