"""Values within their standard uncertainties: along a circle, from stop to stop, and over hours."""

from collections.abc import Callable
from itertools import cycle

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.messages.catalogue import Catalogue
from truepose.reports.figures.svg_rendering import (
    AFTER,
    BEFORE,
    MUTED,
    NOISE,
    mark_axis,
    new_figure,
    page_style,
    to_svg,
)
from truepose.validation.circle_test import JointCircle
from truepose.validation.iso9283.drift import Drift
from truepose.validation.sphere_test import NOMINAL, Sphere, SphereOfModel


def tangential_figure(one: JointCircle, words: Catalogue) -> Markup:
    """Return the tangential errors of a circle with their uncertainties, for a page."""
    title = words.say("circles.figure", joint=one.joint, nest=one.nest)
    with page_style():
        figure = new_figure(7.0, 2.6)
        axes = figure.add_subplot()
        axes.axhline(0.0, color=MUTED, linewidth=0.8)
        _draw_way(axes, one, one.direction > 0, BEFORE, words.say("circles.figure.up"))
        _draw_way(axes, one, one.direction < 0, AFTER, words.say("circles.figure.down"))
        _draw_way(axes, one, one.direction == 0, MUTED, words.say("circles.figure.unknown"))
        mark_axis(axes.xaxis, words.units.conversion("deg"))
        mark_axis(axes.yaxis, words.units.conversion("mm"))
        axes.set_xlabel(words.say("circles.figure.angle", joint=one.joint))
        axes.set_ylabel(words.say("circles.head.error"))
        axes.legend()
        return to_svg(figure, f"circle-{one.joint}-{one.nest}", title, words)


def _draw_way(axes: Axes, one: JointCircle, rows: BoolArray, colour: str, name: str) -> None:
    if not rows.any():
        return
    order = np.flatnonzero(rows)[np.argsort(one.errors.angle_rad[rows], kind="stable")]
    error, u = one.errors.tangential_mm[order], one.errors.tangential_uncertainty_mm[order]
    _band(axes, np.degrees(one.errors.angle_rad[order]), error, u, colour, name)


def radial_figure(sphere: Sphere, called: Callable[[str], str], words: Catalogue) -> Markup:
    """Return the errors of models, by what each is called, about the taught centre, or else the best one."""
    title = words.say("sphere.figure", placement=sphere.placement, base_point=sphere.base_point)
    taught = any(not one.errors.centre.is_fitted for one in sphere.models)
    shown = [one for one in sphere.models if one.errors.centre.is_fitted is not taught]
    with page_style():
        figure = new_figure(7.0, 2.8)
        axes = figure.add_subplot()
        axes.axhline(0.0, color=MUTED, linewidth=0.8)
        colours = cycle((AFTER, NOISE, MUTED))
        for one in shown:
            _draw_model(axes, one, BEFORE if one.model == NOMINAL else next(colours), called(one.model))
        _part_nests(axes, sphere)
        mark_axis(axes.yaxis, words.units.conversion("mm"))
        axes.set_xlabel(words.say("sphere.figure.stop"))
        axes.set_ylabel(words.say("sphere.figure.error"))
        axes.legend()
        return to_svg(figure, f"sphere-{sphere.placement}-{sphere.base_point}", title, words)


def _draw_model(axes: Axes, one: SphereOfModel, colour: str, name: str) -> None:
    error, u = one.errors.errors_mm, one.errors.standard_uncertainty_mm
    stop = np.arange(1, len(error) + 1)
    _band(axes, stop, error, u, colour, name)


def _part_nests(axes: Axes, sphere: Sphere) -> None:
    """Draw a line where the bar went to another nest."""
    for row in np.flatnonzero(np.diff(sphere.nest)).tolist():
        axes.axvline(row + 1.5, color=MUTED, linewidth=0.8, linestyle=":")


def drift_figure(drift: Drift, words: Catalogue) -> Markup:
    """Return the curve of a test of drift with its uncertainties, for a page."""
    hours = [point.hours for point in drift.curve]
    with page_style():
        figure = new_figure(7.0, 2.8)
        axes = figure.add_subplot()
        moved = np.array([(point.moved_mm, point.moved_uncertainty_mm) for point in drift.curve]).T
        repeated = np.array([
            (point.repeatability_mm, point.repeatability_uncertainty_mm) for point in drift.curve
        ]).T
        for (value, u), colour, name in (
            (moved, BEFORE, words.say("pose_test.drift.moved")),
            (repeated, AFTER, "RP"),
        ):
            _band(axes, hours, value, u, colour, name, marker=4.0)
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel(words.say("pose_test.drift.hours"))
        axes.set_ylabel(words.units.conversion("mm").symbol)
        mark_axis(axes.yaxis, words.units.conversion("mm"))
        axes.legend()
        return to_svg(figure, "drift", words.say("pose_test.drift"), words)


def _band(
    axes: Axes, x: ArrayLike, value: FloatArray, u: FloatArray, colour: str, name: str, marker: float = 3.0
) -> None:
    """Draw values (n,) joined by a line within one standard uncertainty (n,)."""
    axes.fill_between(x, value - u, value + u, color=colour, alpha=0.18, linewidth=0.0)
    axes.plot(x, value, ".-", color=colour, markersize=marker, linewidth=0.9, label=name)
