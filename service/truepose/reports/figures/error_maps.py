"""Errors where the tool stood: as exaggerated vectors in space and in views, and as maps at one scale."""

from dataclasses import dataclass
from typing import Any  # matplotlib's 3D axes carry no types

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from truepose.domain.arrays import FloatArray
from truepose.domain.correction import CorrectedTargets
from truepose.domain.diagnosis import HeldOutErrors
from truepose.identification.verdict.judge import Assessment
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.reports.figures.svg_rendering import (
    AFTER,
    BEFORE,
    INK,
    MUTED,
    mark_axis,
    name_axes,
    new_figure,
    page_style,
    to_svg,
)

_MOST_IN_SPACE = 250
_SHARE_OF_SPACE = 0.12  # length of a large (95 %) error, of the extent of the work space
_VIEWS_OF_SPACE = ((0, 1, "space.from_above"), (0, 2, "space.from_the_front"), (1, 2, "space.from_the_side"))


@dataclass(frozen=True, slots=True)
class WorkSpaceFigures:
    """The pictures and what their captions must state."""

    in_space: Markup
    views: Markup
    exaggeration_before: float
    exaggeration_after: float
    shown: int
    total: int


def work_space(judged: Assessment, words: Catalogue = IN_ENGLISH) -> WorkSpaceFigures:
    """Draw the errors of `judged`; where there are too many, an even selection of them."""
    total = len(judged.position_mm)
    shown = slice(None, None, -(-total // _MOST_IN_SPACE))
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
        return to_svg(figure, "space", words.say("space.picture"), words)


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
        mark_axis(axis, conversion)
        axis.set_pane_color((0.0, 0.0, 0.0, 0.0))


def views(points: FloatArray, vectors: FloatArray, ident: str, words: Catalogue) -> Markup:
    """Draw vectors (n, 3) at points (n, 3) from above, from the front and from the side."""
    with page_style():
        figure = new_figure(8.0, 3.1)
        for axes, (across, up, name) in zip(figure.subplots(1, 3), _VIEWS_OF_SPACE, strict=True):
            _view(axes, points[:, [across, up]], vectors[:, [across, up]])
            axes.set_title(words.say(name))
            name_axes(axes, words, "xyz"[across], "xyz"[up])
        return to_svg(figure, ident, words.say("space.views"), words)


def _view(axes: Axes, points: FloatArray, vectors: FloatArray) -> None:
    _arrows(axes, points, vectors, AFTER)
    axes.update_datalim(points + vectors)  # quiver itself counts the tails only
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.locator_params(nbins=4)


_MOST_SHIFTS = 400


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
    rows = known[:: -(-len(known) // _MOST_SHIFTS)]
    place, shift = targets.place_mm[rows], targets.shift_mm[rows]
    # With the base in the picture a single target has its place too.
    scale = exaggeration(np.vstack([place, np.zeros(3)]), shift)
    with page_style():
        figure = new_figure(8.0, 3.9)
        for axes, (across, up, name) in zip(figure.subplots(1, 2), _VIEWS_OF_SPACE[:2], strict=True):
            axes.plot(0.0, 0.0, "+", color=INK, markersize=9.0)
            _view(axes, place[:, [across, up]], scale * shift[:, [across, up]])
            axes.set_title(words.say(name))
            name_axes(axes, words, "xyz"[across], "xyz"[up])
        return ShiftMap(
            to_svg(figure, "shifts", words.say("shifts.picture"), words), scale, len(rows), len(known)
        )


_MOST_VECTORS = 250
_VIEWS = ((0, 1, "maps.from_above"), (0, 2, "maps.along_y"))
_PANEL_IN = 3.5
_MOST_HEIGHT_IN = 6.0  # both rows; a page holds them with their caption
_LEAST_SHARE = 0.25  # of the longest side, for the shortest: a flat campaign is still a picture
_MARGIN = 0.06
_LARGEST_DOT = 80.0  # area [pt2] of a large error of a length


@dataclass(frozen=True, slots=True)
class ErrorMaps:
    """The picture and what its caption must state."""

    picture: Markup
    exaggeration: float  # 1 where dots stand for lengths
    largest_mm: float  # error of the largest dot of lengths
    shown: int
    total: int
    lengths: bool


def error_maps(errors: HeldOutErrors, words: Catalogue = IN_ENGLISH) -> ErrorMaps | None:
    """Draw errors where the tool stood; None where nothing finite is held out."""
    errors = _finite(errors)
    total = len(errors.position_mm)
    if total == 0:
        return None
    rows = slice(None, None, -(-total // _MOST_VECTORS))
    points, before, after = errors.position_mm[rows], errors.before_mm[rows], errors.after_mm[rows]
    lengths = before.shape[1] == 1
    scale = 1.0 if lengths else exaggeration(errors.position_mm, errors.before_mm)
    large = float(np.quantile(np.abs(np.concatenate([errors.before_mm, errors.after_mm])), 0.99))
    tips = [] if lengths else [points + scale * before, points + scale * after]
    limits = _limits(np.concatenate([points, *tips]))
    panels = ((before * scale, BEFORE, words.say("before")), (after * scale, AFTER, words.say("after")))
    with page_style():
        picture = _picture(points, panels, limits, large if lengths else None, scale, words)
    return ErrorMaps(picture, scale, large, len(points), total, lengths)


def _finite(errors: HeldOutErrors) -> HeldOutErrors:
    together = np.concatenate([errors.position_mm, errors.before_mm, errors.after_mm], axis=1)
    known = np.isfinite(together).all(axis=1)
    return HeldOutErrors(
        errors.config[known], errors.position_mm[known], errors.before_mm[known], errors.after_mm[known]
    )


def _limits(points: FloatArray) -> FloatArray:
    """Return lower and upper limits of x, y, z, shape (2, 3)."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, extent = (low + high) / 2.0, high - low
    longest = max(float(extent.max()), 1.0)
    half = np.maximum(extent * (1.0 + _MARGIN), _LEAST_SHARE * longest) / 2.0
    return np.stack([middle - half, middle + half])


def _picture(
    points: FloatArray,
    panels: tuple[tuple[FloatArray, str, str], ...],
    limits: FloatArray,
    large_mm: float | None,
    scale: float,
    words: Catalogue,
) -> Markup:
    width, shown = limits[1] - limits[0], words.units.conversion("mm")
    heights = [float(np.clip(width[up] / width[across], 0.3, 1.4)) for across, up, _ in _VIEWS]
    panel_in = min(_PANEL_IN, _MOST_HEIGHT_IN / sum(heights))
    figure = new_figure(8.0, panel_in * sum(heights) + 1.3)
    grid = figure.subplots(2, 2, gridspec_kw={"height_ratios": heights}, sharex=True, sharey="row")
    for row, (across, up, view) in enumerate(_VIEWS):
        for axes, (errors, colour, name) in zip(grid[row], panels, strict=True):
            _frame(axes, limits, across, up)
            if large_mm is None:
                _arrows(axes, points[:, [across, up]], errors[:, [across, up]], colour)
            else:
                _dots(axes, points[:, [across, up]], errors[:, 0] / max(large_mm, 1e-9), colour)
            axes.set_title(words.between.join((name, words.say(view))))
        grid[row][0].set_ylabel(f"{'xyz'[up]} [{shown.symbol}]")
    for axes in grid[1]:
        axes.set_xlabel(f"x [{shown.symbol}]")
    for axes in grid.flat:
        mark_axis(axes.xaxis, shown)
        mark_axis(axes.yaxis, shown)
    if large_mm is None:
        _scale_bar(grid[0][0], limits, scale, words)
    return to_svg(figure, "maps", words.say("maps"), words)


def _frame(axes: Axes, limits: FloatArray, across: int, up: int) -> None:
    axes.set_xlim(*limits[:, across])
    axes.set_ylim(*limits[:, up])
    axes.set_aspect("equal", adjustable="box")
    axes.locator_params(nbins=5)


def _arrows(axes: Axes, points: FloatArray, vectors: FloatArray, colour: str) -> None:
    axes.quiver(
        *points.T,
        *vectors.T,
        color=colour,
        angles="xy",
        scale_units="xy",
        scale=1.0,
        width=0.004,
        headwidth=4,
    )
    axes.plot(*points.T, ".", color=MUTED, markersize=1.5)


def _dots(axes: Axes, points: FloatArray, share: FloatArray, colour: str) -> None:
    size = np.clip(np.abs(share), 0.002, 1.0) * _LARGEST_DOT
    for rows, face in ((share > 0.0, colour), (share <= 0.0, "none")):
        x, y = points[rows].T
        axes.scatter(x, y, s=size[rows], facecolors=face, edgecolors=colour, linewidths=0.9)


def _scale_bar(axes: Axes, limits: FloatArray, scale: float, words: Catalogue) -> None:
    """Draw a length below the panel that errors can be compared with: a round one of about a fifth of it."""
    factor = words.units.conversion("mm").factor
    wanted = 0.2 * float(limits[1, 0] - limits[0, 0]) / scale * factor
    decade = 10.0 ** np.floor(np.log10(wanted))
    length = max(step * decade for step in (1.0, 2.0, 5.0) if step * decade <= wanted * (1.0 + 1e-9)) / factor
    start, low = float(limits[0, 0]), float(limits[0, 1] - 0.10 * np.ptp(limits[:, 1]))
    axes.plot(
        [start, start + length * scale],
        [low, low],
        color=INK,
        linewidth=2.5,
        solid_capstyle="butt",
        clip_on=False,
    )
    axes.annotate(
        words.say("maps.scale", length_mm=length),
        (start + length * scale, low),
        (6, 0),
        textcoords="offset points",
        va="center",
        fontsize=9.0,
        annotation_clip=False,
    )
