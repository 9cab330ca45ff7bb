"""Radial errors of a sphere test, stop by stop, of every model."""

from itertools import cycle

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from truepose.judgement.sphere.judged import NOMINAL, Sphere, SphereOfModel
from truepose.reports.figures.canvas import (
    AFTER,
    BEFORE,
    MUTED,
    NOISE,
    marked_in,
    new_figure,
    page_style,
    to_svg,
)
from truepose.reports.spheres.sentences import model_name
from truepose.words.catalogue import Catalogue


def radial_figure(sphere: Sphere, words: Catalogue) -> Markup:
    """Return the errors about the taught centre, or else the best one, for a page."""
    title = words.say("sphere.figure", placement=sphere.placement, base_point=sphere.base_point)
    taught = any(not one.errors.centre.is_fitted for one in sphere.models)
    shown = [one for one in sphere.models if one.errors.centre.is_fitted is not taught]
    with page_style():
        figure = new_figure(7.0, 2.8)
        axes = figure.add_subplot()
        axes.axhline(0.0, color=MUTED, linewidth=0.8)
        colours = cycle((AFTER, NOISE, MUTED))
        for one in shown:
            _draw(axes, one, BEFORE if one.model == NOMINAL else next(colours), model_name(one.model, words))
        _part_nests(axes, sphere)
        marked_in(axes.yaxis, words.units.conversion("mm"))
        axes.set_xlabel(words.say("sphere.figure.stop"))
        axes.set_ylabel(words.say("sphere.figure.error"))
        axes.legend()
        return to_svg(figure, f"sphere-{sphere.placement}-{sphere.base_point}", title)


def _draw(axes: Axes, one: SphereOfModel, colour: str, name: str) -> None:
    error, u = one.errors.errors_mm, one.errors.standard_uncertainty_mm
    stop = np.arange(1, len(error) + 1)
    axes.fill_between(stop, error - u, error + u, color=colour, alpha=0.18, linewidth=0.0)
    axes.plot(stop, error, ".-", color=colour, markersize=3.0, linewidth=0.9, label=name)


def _part_nests(axes: Axes, sphere: Sphere) -> None:
    """Draw a line where the bar went to another nest."""
    for row in np.flatnonzero(np.diff(sphere.nest)).tolist():
        axes.axvline(row + 1.5, color=MUTED, linewidth=0.8, linestyle=":")
