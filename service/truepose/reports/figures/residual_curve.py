"""Residuals along one variable, with what was fitted to them."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.diagnosis import Curve
from truepose.reports.causes import printed_unit
from truepose.reports.figures.canvas import (
    PAGE,
    PLAIN,
    Colours,
    Drawing,
    label,
    new_figure,
    page_style,
    plain_style,
    to_svg,
)

_MOST_POINTS = 400  # dots with whiskers; more make no one wiser and the file heavy
_FEWEST_FOR_MEANS = 60  # readings; below, every one is seen by itself
_MEANS = 20
_FEW_VALUES = 12  # of a variable that counts: mountings, nests
_NEARLY_ALL = 0.99  # of the readings, by weight
_MOST_BENDS = 8  # of the line; a mean over a tenth of a wave would flatten it
_WIDEST_LABEL, _TALLEST_LABEL = 90, 40  # letters that fit along the axes
_BESIDE = 0.1  # of the step between two numbers, so that the value does not hide the mean


@dataclass(frozen=True, slots=True)
class CurveFigure:
    """The picture, and what its caption must say."""

    picture: Markup
    caption: str
    line: bool  # one is drawn
    values: bool  # one value is drawn for each number


@dataclass(frozen=True, slots=True)
class _Means:
    x: FloatArray
    value: FloatArray
    standard_uncertainty: FloatArray
    of: int  # readings in each, at most


def residual_curve(curve: Curve, prefix: str, *, line: str, whole: bool = False) -> CurveFigure | None:
    """Draw residuals with their standard uncertainty and the line with its band.

    Parameters
    ----------
    curve : Curve
    prefix : str
        Keeps the ids of this picture apart from those of others.
    line : str
        What the line is, e.g. "fitted effect".
    whole : bool
        Show the farthest reading too; else a few far ones are said and not shown.

    Returns
    -------
    CurveFigure or None
        None where there is no finite reading.
    """
    shown = _shown(curve, whole=whole)
    if shown is None:
        return None
    with page_style():
        picture = to_svg(_drawn(shown, line, PAGE), prefix, f"{curve.quantity} against {curve.variable}")
    drawn, counts = bool(shown.curve.line_x.size), _counts(shown.curve)
    caption = " ".join(_caption(shown))
    if shown.unseen is not None:
        caption = f"{caption} {_unseen_caption(shown.unseen)}"
    return CurveFigure(picture, caption, drawn and not counts, drawn and counts)


def plain_residual_curve(curve: Curve, *, line: str) -> Drawing | None:
    """Return the same as a figure that a program may change; None where there is no finite reading."""
    shown = _shown(curve, whole=False)
    if shown is None:
        return None
    with plain_style():
        return _drawn(shown, line, PLAIN)


@dataclass(frozen=True, slots=True)
class _Shown:
    """What of a curve fits in the picture."""

    curve: Curve  # its finite readings, and its line
    means: _Means | None
    unseen: Curve | None
    limit: float  # half height
    blind: BoolArray  # (n,) readings that hardly feel the cause
    chosen: IntArray  # rows that are drawn
    beyond: int  # readings outside the picture


def _shown(curve: Curve, *, whole: bool) -> _Shown | None:
    finite = _finite(curve)
    if not finite.x.size:
        return None
    limit = _limit(finite, whole)
    blind = finite.standard_uncertainty > limit
    return _Shown(
        finite,
        _means(finite),
        _unseen(curve, limit),
        limit,
        blind,
        _chosen(finite.x, ~blind),
        beyond=int(((np.abs(finite.residual) > limit) & ~blind).sum()),
    )


def _drawn(shown: _Shown, line: str, colours: Colours) -> Drawing:
    curve = shown.curve
    figure = new_figure(8.0, 3.1)
    axes = figure.add_subplot()
    _readings(axes, curve, shown.chosen, colours, faint=shown.means is not None)
    _line(axes, curve, line, colours)
    if shown.means is not None:
        _draw_means(axes, shown.means, colours)
    if shown.unseen is not None:
        _draw_unseen(axes, shown.unseen, colours)
    axes.set_ylim(-shown.limit, shown.limit)
    axes.set_xlabel(label(curve.variable, _WIDEST_LABEL, printed_unit(curve.variable_unit)))
    axes.set_ylabel(label(curve.quantity, _TALLEST_LABEL, printed_unit(curve.quantity_unit)))
    figure.legend(loc="outside upper left", ncols=4)
    return figure


def _finite(curve: Curve) -> Curve:
    known = np.isfinite(curve.x) & np.isfinite(curve.residual)
    drawn = np.isfinite(curve.line_x) & np.isfinite(curve.line)
    return replace(
        curve,
        x=curve.x[known],
        residual=curve.residual[known],
        standard_uncertainty=np.nan_to_num(curve.standard_uncertainty[known]),
        line_x=curve.line_x[drawn],
        line=curve.line[drawn],
        line_band=np.nan_to_num(curve.line_band[drawn]),
    )


def _unseen(curve: Curve, limit: float) -> Curve | None:
    """Return the validation readings in the place of those that were fitted; None where none says much."""
    points = curve.unseen
    if points is None:
        return None
    x, u = points.x - _BESIDE if _counts(curve) else points.x, points.standard_uncertainty
    worth = u <= limit
    told = replace(curve, x=x[worth], residual=points.residual[worth], standard_uncertainty=u[worth])
    shown = _finite(told)
    return shown if shown.x.size else None


def _draw_unseen(axes: Axes, unseen: Curve, colours: Colours) -> None:
    rows, means = _chosen(unseen.x, np.ones(len(unseen.x), dtype=bool)), _means(unseen)
    x, y = unseen.x[rows], unseen.residual[rows]
    if means is None:
        axes.plot(
            x, y, "x", color=colours.noise, markersize=4.0, markeredgewidth=0.9, label="validation readings"
        )
        return
    axes.plot(x, y, "x", color=colours.noise, markersize=3.0, markeredgewidth=0.7, alpha=0.35)
    axes.errorbar(
        means.x,
        means.value,
        means.standard_uncertainty,
        fmt="s",
        color=colours.noise,
        markerfacecolor="none",
        markersize=5.0,
        linewidth=1.1,
        label="means of validation readings",
    )


def _unseen_caption(unseen: Curve) -> str:
    means = "" if _means(unseen) is None else ", squares their means"
    one = len(unseen.x) == 1
    readings = "validation reading, which was" if one else "validation readings, which were"
    return f"Crosses{means}: {len(unseen.x):,} {readings} never fitted, in the same way."


def _limit(curve: Curve, whole: bool) -> float:
    """Return the half height: neither a few gross readings nor blind ones may flatten everything else.

    Where a reading hardly feels the cause, its residual divided by next to nothing is huge, and as uncertain.
    """
    sizes = np.abs(curve.residual)
    farthest = float(sizes.max()) if whole else _weighted_quantile(sizes, _weights(curve))
    line = float((np.abs(curve.line) + curve.line_band).max(initial=0.0))
    return 1.2 * max(farthest, line, 1e-9)


def _weights(curve: Curve) -> FloatArray:
    u = curve.standard_uncertainty
    return np.asarray(1.0 / u**2) if (u > 0.0).all() else np.ones(len(u))


def _weighted_quantile(sizes: FloatArray, weights: FloatArray) -> float:
    order = np.argsort(sizes)
    reached = np.cumsum(weights[order]) / weights.sum()
    return float(sizes[order][min(int(np.searchsorted(reached, _NEARLY_ALL)), len(order) - 1)])


def _chosen(x: FloatArray, worth: BoolArray) -> IntArray:
    """Return the rows to draw, evenly chosen along x from those worth it."""
    order = np.argsort(x, kind="stable")
    order = order[worth[order]]
    if len(order) <= _MOST_POINTS:
        return order
    return order[np.linspace(0, len(order) - 1, _MOST_POINTS).astype(np.int64)]


def _readings(axes: Axes, curve: Curve, rows: IntArray, colours: Colours, *, faint: bool) -> None:
    strength = 0.55 if faint else 0.9
    x, y, u = curve.x[rows], curve.residual[rows], curve.standard_uncertainty[rows]
    axes.axhline(0.0, color=colours.muted, linewidth=0.8)
    axes.vlines(x, y - u, y + u, color=colours.muted, linewidth=0.7, alpha=0.5 * strength)
    axes.plot(
        x, y, ".", color=colours.muted, markersize=5.0, alpha=strength, markeredgewidth=0.0, label="readings"
    )


def _line(axes: Axes, curve: Curve, name: str, colours: Colours) -> None:
    if not curve.line_x.size:
        return
    if _counts(curve):
        _steps(axes, curve, name, colours)
        return
    low, high = curve.line - curve.line_band, curve.line + curve.line_band
    if (curve.line_band > 0.0).any():
        axes.fill_between(
            curve.line_x, low, high, color=colours.after, alpha=0.22, linewidth=0.0, label="its 95 % band"
        )
    axes.plot(curve.line_x, curve.line, color=colours.after, linewidth=1.8, label=name)


def _steps(axes: Axes, curve: Curve, name: str, colours: Colours) -> None:
    """Draw a value for each number: between the first mounting and the second there is nothing."""
    numbers, first = np.unique(curve.line_x, return_index=True)
    band = curve.line_band[first]
    label = f"{name}, 95 % interval" if (band > 0.0).any() else name
    axes.errorbar(
        numbers + _BESIDE,
        curve.line[first],
        band,
        fmt="D",
        color=colours.after,
        markersize=5.0,
        linewidth=2.0,
        label=label,
    )
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))


def _draw_means(axes: Axes, means: _Means, colours: Colours) -> None:
    axes.errorbar(
        means.x,
        means.value,
        means.standard_uncertainty,
        fmt="o",
        color=colours.ink,
        markersize=4.0,
        linewidth=1.1,
        label="means of readings",
    )


def _means(curve: Curve) -> _Means | None:
    """Return weighted means of neighbours: they show what single readings hide in their noise."""
    u = curve.standard_uncertainty
    if len(curve.x) < _FEWEST_FOR_MEANS or not (u > 0.0).all() or _bends(curve.line) > _MOST_BENDS:
        return None
    groups = list(_groups(curve.x))
    weights = [1.0 / u[rows] ** 2 for rows in groups]
    return _Means(
        x=np.array([np.average(curve.x[rows], weights=w) for rows, w in zip(groups, weights, strict=True)]),
        value=np.array([
            np.average(curve.residual[rows], weights=w) for rows, w in zip(groups, weights, strict=True)
        ]),
        standard_uncertainty=np.array([w.sum() ** -0.5 for w in weights]),
        of=max(map(len, groups)),
    )


def _groups(x: FloatArray) -> Iterator[IntArray]:
    values = np.unique(x)
    if len(values) <= _FEW_VALUES:
        yield from (np.flatnonzero(x == value) for value in values)
    else:
        yield from np.array_split(np.argsort(x, kind="stable"), _MEANS)


def _counts(curve: Curve) -> bool:
    return not curve.variable_unit and len(np.unique(curve.x)) <= _FEW_VALUES


def _bends(line: FloatArray) -> int:
    """Return how often the line turns from rising to falling or back."""
    slope = np.sign(np.diff(line))
    slope = slope[slope != 0.0]
    return int((slope[1:] != slope[:-1]).sum())


def _caption(shown: _Shown) -> Iterator[str]:
    curve, chosen, blind = shown.curve, shown.chosen, shown.blind
    worth = int((~blind).sum())
    if worth:
        evenly = "" if len(chosen) == worth else f"{len(chosen)} of "
        whiskers = (curve.standard_uncertainty[chosen] > 0.0).any()
        yield f"Dots: {evenly}{worth:,} readings{', evenly chosen,' if evenly else ''}"
        stated = ", with their standard uncertainty" if whiskers else ""
        yield f"as the model without this cause leaves them{stated}."
    if shown.means is not None:
        yield f"Large dots: weighted means of up to {shown.means.of} neighbours each, with their own."
    if shown.beyond:
        farthest = float(np.abs(curve.residual[~blind]).max())
        lies = "reading lies" if shown.beyond == 1 else "readings lie"
        unit = printed_unit(curve.quantity_unit)
        yield f"{shown.beyond} {lies} beyond the picture, the farthest at {farthest:.2g} {unit}."
    if blind.any():
        count = int(blind.sum())
        feels = "feels" if count == 1 else "feel"
        more = "more " if worth else ""
        yield f"{count:,} {more}hardly {feels} it: the uncertainty is larger than the picture."
