"""Tangential errors of a joint over its angle, both directions apart."""

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes

from truepose.domain.arrays import BoolArray
from truepose.judgement.circle.judged import JointCircle
from truepose.reports.figures.canvas import AFTER, BEFORE, MUTED, marked_in, new_figure, page_style, to_svg
from truepose.words.catalogue import Catalogue


def tangential_figure(one: JointCircle, words: Catalogue) -> Markup:
    """Return the tangential errors of a circle with their uncertainties, for a page."""
    title = words.say("circles.figure", joint=one.joint, nest=one.nest)
    with page_style():
        figure = new_figure(7.0, 2.6)
        axes = figure.add_subplot()
        axes.axhline(0.0, color=MUTED, linewidth=0.8)
        _draw(axes, one, one.direction > 0, BEFORE, words.say("circles.figure.up"))
        _draw(axes, one, one.direction < 0, AFTER, words.say("circles.figure.down"))
        _draw(axes, one, one.direction == 0, MUTED, words.say("circles.figure.unknown"))
        marked_in(axes.xaxis, words.units.conversion("deg"))
        marked_in(axes.yaxis, words.units.conversion("mm"))
        axes.set_xlabel(words.say("circles.figure.angle", joint=one.joint))
        axes.set_ylabel(words.say("circles.head.error"))
        axes.legend()
        return to_svg(figure, f"circle-{one.joint}-{one.nest}", title)


def _draw(axes: Axes, one: JointCircle, rows: BoolArray, colour: str, name: str) -> None:
    if not rows.any():
        return
    order = np.flatnonzero(rows)[np.argsort(one.errors.angle_rad[rows], kind="stable")]
    angle_deg = np.degrees(one.errors.angle_rad[order])
    error, u = one.errors.tangential_mm[order], one.errors.tangential_uncertainty_mm[order]
    axes.fill_between(angle_deg, error - u, error + u, color=colour, alpha=0.18, linewidth=0.0)
    axes.plot(angle_deg, error, ".-", color=colour, markersize=3.0, linewidth=0.9, label=name)
