"""Mean and largest errors by distance from the measured zone and from axis 1, before and after."""

from collections.abc import Sequence
from functools import partial

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from truepose.domain.results.identification import Statistics
from truepose.domain.results.validation import ErrorsByPlace, Shell
from truepose.reports.figures.canvas import Colours, Drawing, marked_in, new_figure, on_page, plain
from truepose.words.catalogue import IN_ENGLISH, Catalogue


def place_errors(places: ErrorsByPlace, words: Catalogue = IN_ENGLISH) -> Markup:
    """Draw the errors over both distances on logarithmic axes: before and after differ by decades."""
    return on_page(partial(_drawn, places, words=words), "places", words.say("places.picture"))


def plain_place_errors(places: ErrorsByPlace) -> Drawing:
    """Return the same as a figure that a program may change."""
    return plain(partial(_drawn, places, words=IN_ENGLISH))


def _drawn(places: ErrorsByPlace, colours: Colours, words: Catalogue) -> Drawing:
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
        marked_in(axes, words.units.conversion("mm"))
    axis.set_xlabel(words.say("places.from_axis"))
    handles, labels = zone.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=3)
    return figure


def _panel(axes: Axes, shells: Sequence[Shell], colours: Colours, words: Catalogue) -> None:
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
    axes: Axes, shells: Sequence[Shell], values: Sequence[float], label: str, colour: str, style: str
) -> None:
    """Draw a level over each shell; shells without a reading leave a gap."""
    ends = [end for shell in shells for end in (shell.from_mm, shell.to_mm, np.nan)]
    levels = [level for value in values for level in (value, value, np.nan)]
    axes.plot(ends, levels, color=colour, linestyle=style, linewidth=1.6, label=label)
