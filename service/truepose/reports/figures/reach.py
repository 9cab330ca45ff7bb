"""Errors over the distance from axis 1, before and after."""

from functools import partial

import numpy as np
from markupsafe import Markup
from matplotlib.ticker import FuncFormatter

from truepose.domain.arrays import FloatArray
from truepose.reports.figures.canvas import Colours, Drawing, marked_in, new_figure, on_page
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_MOST_POINTS = 400  # dots of one colour


def reach_figure(
    reach_mm: FloatArray, before_mm: FloatArray, after_mm: FloatArray, words: Catalogue = IN_ENGLISH
) -> Markup:
    """Draw sizes of errors (n,) over the distance from axis 1 (n,); of many an even selection."""
    draw = partial(_drawn, reach_mm, before_mm, after_mm, words)
    return on_page(draw, "reach", words.say("reach.picture"))


def _drawn(
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
    marked_in(axes.xaxis, words.units.conversion("mm"))
    marked_in(axes.yaxis, words.units.conversion("mm"))
    axes.set_xlabel(words.say("places.from_axis"))
    axes.set_ylabel(words.say("histogram.error"))
    figure.legend(loc="outside upper left", ncols=2, markerscale=2.0)
    return figure
