"""A robot that warms up: how far its barycentre went, and its repeatability, over the hours."""

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from truepose.judgement.iso9283.drift import Drift
from truepose.reports.figures.canvas import AFTER, BEFORE, marked_in, new_figure, page_style, to_svg
from truepose.words.catalogue import Catalogue


def drift_figure(drift: Drift, words: Catalogue) -> Markup:
    """Return the curve of a test of drift with its uncertainties, for a page."""
    hours = [point.hours for point in drift.curve]
    with page_style():
        figure = new_figure(7.0, 2.8)
        axes = figure.add_subplot()
        moved = [(point.moved_mm, point.moved_uncertainty_mm) for point in drift.curve]
        repeated = [(point.repeatability_mm, point.repeatability_uncertainty_mm) for point in drift.curve]
        _draw(axes, hours, moved, BEFORE, words.say("pose_test.drift.moved"))
        _draw(axes, hours, repeated, AFTER, "RP")
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel(words.say("pose_test.drift.hours"))
        axes.set_ylabel(words.units.conversion("mm").symbol)
        marked_in(axes.yaxis, words.units.conversion("mm"))
        axes.legend()
        return to_svg(figure, "drift", words.say("pose_test.drift"))


def _draw(
    axes: Axes, hours: Sequence[float], values: Sequence[tuple[float, float]], colour: str, name: str
) -> None:
    value, u = np.array(values).T
    axes.fill_between(hours, value - u, value + u, color=colour, alpha=0.18, linewidth=0.0)
    axes.plot(hours, value, ".-", color=colour, markersize=4.0, linewidth=0.9, label=name)
