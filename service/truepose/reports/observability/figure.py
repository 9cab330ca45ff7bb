"""How well a measurement determines each parameter: a bar for each, worst first."""

from collections.abc import Sequence
from functools import partial
from typing import Final

import numpy as np
from markupsafe import Markup
from matplotlib.ticker import FuncFormatter

from truepose.reports.figures.canvas import Colours, Drawing, new_figure, on_page
from truepose.reports.observability.determined import HARDLY, Determined
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_MOST: Final = 60  # parameters whose names still stand below one another


def observability_figure(found: Sequence[Determined], words: Catalogue = IN_ENGLISH) -> Markup | None:
    """Draw the worst known parameters; None where there is none to draw."""
    if not found:
        return None
    return on_page(partial(_drawn, found[:_MOST], words), "observability", words.say("observability.picture"))


def _drawn(found: Sequence[Determined], words: Catalogue, colours: Colours) -> Drawing:
    halves = np.array_split(np.arange(len(found)), 2 if len(found) > 12 else 1)
    figure = new_figure(8.0, 0.9 + 0.17 * len(halves[0]))
    widest = max(found[-1].times, 2.0 * HARDLY)
    for column, rows in enumerate(halves, start=1):
        axes = figure.add_subplot(1, len(halves), column)
        part = [found[k] for k in rows]
        places = np.arange(len(part))
        colour = [colours.before if one.is_hardly else colours.after for one in part]
        axes.barh(places, [max(one.times, 1.0) for one in part], color=colour, height=0.7)
        axes.axvline(HARDLY, color=colours.ink, linewidth=1.0, linestyle=":")
        axes.set_yticks(places, [one.name for one in part], fontsize=7.5)
        axes.set_ylim(len(halves[0]) - 0.4, -0.6)
        axes.set_xscale("log")
        axes.set_xlim(1.0, 1.3 * widest)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.grid(axis="y", visible=False)
        axes.set_xlabel(words.say("observability.axis"))
    return figure
