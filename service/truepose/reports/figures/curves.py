"""Errors over the number of configurations, over the reach, and over the distance from the measured zone."""

from collections.abc import Sequence
from functools import partial
from typing import Final

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter

from truepose.domain.arrays import FloatArray
from truepose.domain.identification import Statistics
from truepose.domain.validation import DistanceBin, ErrorsByPlace
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.planning.prediction.plan import PromisedPlan
from truepose.reports.figures.svg_rendering import Colours, Drawing, mark_axis, new_figure, on_page, plain

_STEEP: Final = 20.0  # times the error at the end: what follows would lie on the axis


def promise_curve(plan: PromisedPlan, words: Catalogue = IN_ENGLISH) -> Markup:
    """Return the curve of a plan, its band and the number that is planned, for a page."""
    return on_page(partial(_draw_promise, plan, words), "promise", words.say("plans.figure"), words)


def plain_promise_curve(plan: PromisedPlan) -> Drawing:
    """Return the same in ordinary colours, for a program."""
    return plain(partial(_draw_promise, plan, IN_ENGLISH))


def _draw_promise(plan: PromisedPlan, words: Catalogue, colours: Colours) -> Drawing:
    say = words.say
    figure = new_figure(7.0, 3.6)
    axes = figure.add_subplot()
    numbers = [point.n for point in plan.curve]
    low, high = zip(*(point.interval_90_mm for point in plan.curve), strict=True)
    axes.fill_between(
        numbers, low, high, color=colours.after, alpha=0.2, linewidth=0.0, label=say("plans.head.interval")
    )
    means = [point.mean_mm for point in plan.curve]
    axes.plot(numbers, means, "o-", color=colours.after, markersize=3.5, label=say("plans.head.mean"))
    worst = [point.worst_mm for point in plan.curve]
    axes.plot(numbers, worst, "--", color=colours.before, label=say("plans.head.worst"))
    axes.axvline(plan.total, color=colours.ink, linewidth=1.0, label=say("plans.figure.planned"))
    if plan.advised != plan.total:
        axes.axvline(
            plan.advised, color=colours.ink, linewidth=1.0, linestyle=":", label=say("plans.figure.knee")
        )
    axes.set_xlabel(say("plans.head.n"))
    axes.set_ylabel(words.units.conversion("mm").symbol)
    if means[0] > _STEEP * means[-1]:
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=0.0)
    mark_axis(axes.yaxis, words.units.conversion("mm"))
    axes.legend()
    return figure


_MOST_POINTS = 400  # dots of one colour


def reach_figure(
    reach_mm: FloatArray, before_mm: FloatArray, after_mm: FloatArray, words: Catalogue = IN_ENGLISH
) -> Markup:
    """Draw sizes of errors (n,) over the distance from axis 1 (n,); of many an even selection."""
    draw = partial(_draw_reach, reach_mm, before_mm, after_mm, words)
    return on_page(draw, "reach", words.say("reach.picture"), words)


def _draw_reach(
    reach_mm: FloatArray, before_mm: FloatArray, after_mm: FloatArray, words: Catalogue, colours: Colours
) -> Drawing:
    figure = new_figure(8.0, 2.8)
    axes = figure.add_subplot()
    shown = slice(None, None, -(-len(reach_mm) // _MOST_POINTS))
    of_models = (("before", before_mm, colours.before), ("after", after_mm, colours.after))
    for name, sizes, colour in of_models:
        axes.plot(
            reach_mm[shown], sizes[shown], ".", color=colour, markersize=4.0, label=words.say(name), alpha=0.7
        )
    if min(float(np.min(before_mm)), float(np.min(after_mm))) > 0.0:
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    mark_axis(axes.xaxis, words.units.conversion("mm"))
    mark_axis(axes.yaxis, words.units.conversion("mm"))
    axes.set_xlabel(words.say("places.from_axis"))
    axes.set_ylabel(words.say("histogram.error"))
    figure.legend(loc="outside upper left", ncols=2, markerscale=2.0)
    return figure


def place_errors(places: ErrorsByPlace, words: Catalogue = IN_ENGLISH) -> Markup:
    """Draw the errors over both distances on logarithmic axes: before and after differ by decades."""
    return on_page(
        partial(_draw_place_errors, places, words=words), "places", words.say("places.picture"), words
    )


def plain_place_errors(places: ErrorsByPlace) -> Drawing:
    """Return the same as a figure that a program may change."""
    return plain(partial(_draw_place_errors, places, words=IN_ENGLISH))


def _draw_place_errors(places: ErrorsByPlace, colours: Colours, words: Catalogue) -> Drawing:
    figure = new_figure(8.0, 2.9)
    zone, axis = figure.subplots(1, 2, sharey=True)
    _panel(zone, places.from_zone, colours, words)
    zone.set_xlabel(words.say("places.from_zone"))
    zone.set_ylabel(words.say("histogram.error"))
    if places.zone_stated:
        label = words.say("places.edge")
        zone.axvline(places.zone_radius_mm, color=colours.muted, linestyle=":", label=label)
    _panel(axis, places.from_axis, colours, words)
    for axes in (zone.xaxis, axis.xaxis, zone.yaxis):
        mark_axis(axes, words.units.conversion("mm"))
    axis.set_xlabel(words.say("places.from_axis"))
    handles, labels = zone.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=3)
    return figure


def _panel(axes: Axes, shells: Sequence[DistanceBin], colours: Colours, words: Catalogue) -> None:
    before, after = ([getattr(s.errors, name) for s in shells] for name in ("nominal", "identified"))
    nominal, identified = words.say("model.nominal"), words.say("model.identified")
    for name, figures, colour in ((nominal, before, colours.before), (identified, after, colours.after)):
        mean, largest = words.say("places.mean", name=name), words.say("places.largest", name=name)
        _steps(axes, shells, [s.mean_mm for s in figures], mean, colour, "-")
        _steps(axes, shells, [s.max_mm for s in figures], largest, colour, "--")
    if any(_above_zero(figures) for figures in (before, after)):
        axes.set_yscale("log")


def _above_zero(figures: Sequence[Statistics]) -> bool:
    return any(s.mean_mm > 0.0 for s in figures)


def _steps(
    axes: Axes, shells: Sequence[DistanceBin], values: Sequence[float], label: str, colour: str, style: str
) -> None:
    """Draw a level over each shell; shells without a reading leave a gap."""
    ends = [end for shell in shells for end in (shell.from_mm, shell.to_mm, np.nan)]
    levels = [level for value in values for level in (value, value, np.nan)]
    axes.plot(ends, levels, color=colour, linestyle=style, linewidth=1.6, label=label)
