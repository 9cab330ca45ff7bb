"""Errors of the distances between all pairs of points, with their signs, before and after."""

from functools import partial

import numpy as np
from markupsafe import Markup

from truepose.domain.results import DistanceErrors, Histogram, SignedErrors
from truepose.reports.figures.canvas import Colours, Drawing, new_figure, on_page, plain
from truepose.reports.rounding import millimetres


def distance_histogram(errors: DistanceErrors) -> Markup:
    """Draw both histograms, each over an axis of its own: they differ by decades."""
    return on_page(partial(_drawn, errors), "distances", "Histograms of errors of distance, before and after")


def plain_distance_histogram(errors: DistanceErrors) -> Drawing:
    """Return the same histograms as a figure that a program may change."""
    return plain(partial(_drawn, errors))


def _drawn(errors: DistanceErrors, colours: Colours) -> Drawing:
    figure = new_figure(8.0, 2.8)
    panels = figure.subplots(1, 2)
    of_models = (
        ("nominal", errors.nominal, colours.before),
        ("identified", errors.identified, colours.after),
    )
    for axes, (name, signed, colour) in zip(panels, of_models, strict=True):
        axes.stairs(_shares(signed.histogram), _edges(signed.histogram), fill=True, color=colour, alpha=0.75)
        axes.axvline(0.0, color=colours.ink, linewidth=0.8)
        axes.set_title(f"{name}: {_said(signed)}", loc="left")
        axes.set_xlabel("seen minus predicted distance [mm]")
    panels[0].set_ylabel("share of the pairs [%]")
    return figure


def _said(signed: SignedErrors) -> str:
    return f"mean {millimetres(signed.mean_mm)} mm, {100.0 * signed.positive_share:.0f} % above 0"


def _shares(bins: Histogram) -> list[float]:
    total = sum(bins.counts)
    return [100.0 * count / total for count in bins.counts]


def _edges(bins: Histogram) -> list[float]:
    return [float(edge) for edge in bins.width_mm * (bins.first + np.arange(len(bins.counts) + 1))]
