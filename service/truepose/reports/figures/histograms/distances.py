"""Errors of the distances between all pairs of points, with their signs, before and after."""

from functools import partial

import numpy as np
from markupsafe import Markup

from truepose.domain.results.validation import DistanceErrors, Histogram, SignedErrors
from truepose.reports.figures.canvas import Colours, Drawing, marked_in, new_figure, on_page, plain
from truepose.reports.wording.rounding import millimetres
from truepose.words.catalogue import IN_ENGLISH, Catalogue


def distance_histogram(errors: DistanceErrors, words: Catalogue = IN_ENGLISH) -> Markup:
    """Draw both histograms, each over an axis of its own: they differ by decades."""
    return on_page(partial(_drawn, errors, words=words), "distances", words.say("distances.picture"))


def plain_distance_histogram(errors: DistanceErrors) -> Drawing:
    """Return the same histograms as a figure that a program may change."""
    return plain(partial(_drawn, errors, words=IN_ENGLISH))


def _drawn(errors: DistanceErrors, colours: Colours, words: Catalogue) -> Drawing:
    figure = new_figure(8.0, 2.8)
    panels = figure.subplots(1, 2)
    of_models = (
        ("model.nominal", errors.nominal, colours.before),
        ("model.identified", errors.identified, colours.after),
    )
    for axes, (name, signed, colour) in zip(panels, of_models, strict=True):
        axes.stairs(_shares(signed.histogram), _edges(signed.histogram), fill=True, color=colour, alpha=0.75)
        axes.axvline(0.0, color=colours.ink, linewidth=0.8)
        axes.set_title(_title(words.say(name), signed, words), loc="left")
        axes.set_xlabel(words.say("distances.axis"))
        axes.locator_params(axis="x", nbins=6)
        marked_in(axes.xaxis, words.units.conversion("mm"))
    panels[0].set_ylabel(words.say("distances.share"))
    return figure


def _title(name: str, signed: SignedErrors, words: Catalogue) -> str:
    mean, percent = millimetres(signed.mean_mm), 100.0 * signed.positive_share
    return words.say("distances.panel", name=name, mean=mean, percent=percent)


def _shares(bins: Histogram) -> list[float]:
    total = sum(bins.counts)
    return [100.0 * count / total for count in bins.counts]


def _edges(bins: Histogram) -> list[float]:
    return [float(edge) for edge in bins.width_mm * (bins.first + np.arange(len(bins.counts) + 1))]
