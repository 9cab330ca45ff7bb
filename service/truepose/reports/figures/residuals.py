"""Residuals along one variable, with what was fitted to them."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.diagnosis import Curve
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import Message, message, together
from truepose.reports.cause_words import printed_unit
from truepose.reports.figures.svg_rendering import (
    Colours,
    Drawing,
    label,
    mark_axis,
    new_figure,
    on_page,
    plain,
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


def residual_curve(
    curve: Curve, prefix: str, *, of_cause: bool = True, whole: bool = False, words: Catalogue = IN_ENGLISH
) -> CurveFigure | None:
    """Draw residuals with their standard uncertainty and the line with its band.

    Parameters
    ----------
    curve : Curve
    prefix : str
        Keeps the ids of this picture apart from those of others.
    of_cause : bool
        The line is a fitted effect; else a smooth curve that stands for no cause.
    whole : bool
        Show the farthest reading too; else a few far ones are said and not shown.
    words : Catalogue
        The language of labels and caption.

    Returns
    -------
    CurveFigure or None
        None where there is no finite reading.
    """
    shown = _shown(curve, whole=whole)
    if shown is None:
        return None
    described = words.say("curve", quantity=curve.quantity, variable=curve.variable)
    picture = on_page(partial(_drawn, shown, words, of_cause=of_cause), prefix, described, words)
    drawn, counts = bool(shown.curve.line_x.size), _counts(shown.curve)
    caption = words.spoken(together(*_caption(shown, words, of_cause=of_cause)))
    return CurveFigure(picture, caption, drawn and not counts, drawn and counts)


def plain_residual_curve(curve: Curve) -> Drawing | None:
    """Return the same as a figure that a program may change; None where there is no finite reading."""
    shown = _shown(curve, whole=False)
    if shown is None:
        return None
    return plain(partial(_drawn, shown, IN_ENGLISH, of_cause=True))


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


def _drawn(shown: _Shown, words: Catalogue, colours: Colours, *, of_cause: bool) -> Drawing:
    curve = shown.curve
    figure = new_figure(8.0, 3.1)
    axes = figure.add_subplot()
    _readings(axes, curve, shown.chosen, colours, words, faint=shown.means is not None)
    line = "curve.fitted_effect" if of_cause else "curve.smooth"
    _line(axes, curve, line, colours, words)
    if shown.means is not None:
        _draw_means(axes, shown.means, colours, words)
    if shown.unseen is not None:
        _draw_unseen(axes, shown.unseen, colours, words)
    axes.set_ylim(-shown.limit, shown.limit)
    across, up = map(words.units.conversion, (curve.variable_unit, curve.quantity_unit))
    axes.set_xlabel(label(words.name(curve.variable), _WIDEST_LABEL, printed_unit(across.symbol)))
    axes.set_ylabel(label(words.name(curve.quantity), _TALLEST_LABEL, printed_unit(up.symbol)))
    mark_axis(axes.xaxis, across)
    mark_axis(axes.yaxis, up)
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


def _draw_unseen(axes: Axes, unseen: Curve, colours: Colours, words: Catalogue) -> None:
    rows, means = _chosen(unseen.x, np.ones(len(unseen.x), dtype=bool)), _means(unseen)
    x, y = unseen.x[rows], unseen.residual[rows]
    if means is None:
        name = words.say("curve.validation")
        axes.plot(
            x,
            y,
            "x",
            color=colours.noise,
            markersize=4.0,
            markeredgewidth=0.9,
            label=name,
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
        label=words.say("curve.validation_means"),
    )


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


def _readings(
    axes: Axes, curve: Curve, rows: IntArray, colours: Colours, words: Catalogue, *, faint: bool
) -> None:
    strength = 0.55 if faint else 0.9
    x, y, u = curve.x[rows], curve.residual[rows], curve.standard_uncertainty[rows]
    axes.axhline(0.0, color=colours.muted, linewidth=0.8)
    name = words.say("curve.readings")
    axes.vlines(x, y - u, y + u, color=colours.muted, linewidth=0.7, alpha=0.5 * strength)
    axes.plot(
        x,
        y,
        ".",
        color=colours.muted,
        markersize=5.0,
        alpha=strength,
        markeredgewidth=0.0,
        label=name,
    )


def _line(axes: Axes, curve: Curve, key: str, colours: Colours, words: Catalogue) -> None:
    if not curve.line_x.size:
        return
    if _counts(curve):
        _steps(axes, curve, words.say(key), colours, words)
        return
    low, high = curve.line - curve.line_band, curve.line + curve.line_band
    if (curve.line_band > 0.0).any():
        band = words.say("curve.band")
        axes.fill_between(
            curve.line_x,
            low,
            high,
            color=colours.after,
            alpha=0.22,
            linewidth=0.0,
            label=band,
        )
    axes.plot(curve.line_x, curve.line, color=colours.after, linewidth=1.8, label=words.say(key))


def _steps(axes: Axes, curve: Curve, name: str, colours: Colours, words: Catalogue) -> None:
    """Draw a value for each number: between the first mounting and the second there is nothing."""
    numbers, first = np.unique(curve.line_x, return_index=True)
    band = curve.line_band[first]
    label = words.say("curve.with_interval", name=name) if (band > 0.0).any() else name
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


def _draw_means(axes: Axes, means: _Means, colours: Colours, words: Catalogue) -> None:
    axes.errorbar(
        means.x,
        means.value,
        means.standard_uncertainty,
        fmt="o",
        color=colours.ink,
        markersize=4.0,
        linewidth=1.1,
        label=words.say("curve.means"),
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


def _caption(shown: _Shown, words: Catalogue, *, of_cause: bool) -> Iterator[Message]:
    if not shown.blind.all():
        yield _dots(shown, of_cause=of_cause)
    if shown.means is not None:
        yield message("curve.caption.means", readings=shown.means.of)
    if shown.beyond:
        yield _outside(shown, words)
    if shown.blind.any():
        yield _hardly_felt(shown)
    if shown.unseen is not None:
        yield _unseen_caption(shown.unseen)


def _dots(shown: _Shown, *, of_cause: bool) -> Message:
    worth, drawn = int((~shown.blind).sum()), len(shown.chosen)
    whiskers = (shown.curve.standard_uncertainty[shown.chosen] > 0.0).any()
    return message(
        "curve.caption.all" if drawn == worth else "curve.caption.chosen",
        chosen=drawn,
        readings=worth,
        left=message("curve.caption.left_by_cause" if of_cause else "curve.caption.left"),
        stated=message("curve.caption.stated") if whiskers else "",
    )


def _outside(shown: _Shown, words: Catalogue) -> Message:
    farthest = float(np.abs(shown.curve.residual[~shown.blind]).max())
    key = "curve.caption.one_beyond" if shown.beyond == 1 else "curve.caption.beyond"
    conversion = words.units.conversion(shown.curve.quantity_unit)
    unit = printed_unit(conversion.symbol)
    return message(key, readings=shown.beyond, farthest=conversion.of(farthest), unit=unit)


def _hardly_felt(shown: _Shown) -> Message:
    count = int(shown.blind.sum())
    if shown.blind.all():
        return message("curve.caption.one_blind" if count == 1 else "curve.caption.blind", readings=count)
    key = "curve.caption.one_more_blind" if count == 1 else "curve.caption.more_blind"
    return message(key, readings=count)


def _unseen_caption(unseen: Curve) -> Message:
    means = "" if _means(unseen) is None else message("curve.caption.squares")
    key = "curve.caption.one_unseen" if len(unseen.x) == 1 else "curve.caption.unseen"
    return message(key, means=means, readings=len(unseen.x))
