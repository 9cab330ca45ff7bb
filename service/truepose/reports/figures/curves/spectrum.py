"""Amplitudes of a joint's waves against their order."""

import numpy as np
from markupsafe import Markup

from truepose.domain.results.causes import Spectrum
from truepose.effects.joints.joint_harmonics import spoken_order
from truepose.identification.distributions import WITHIN_95
from truepose.reports.figures.canvas import AFTER, INK, marked_in, new_figure, page_style, to_svg
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_MOST_LABELS = 24  # orders whose numbers still stand side by side


def spectrum_picture(spectrum: Spectrum, prefix: str, words: Catalogue = IN_ENGLISH) -> Markup:
    """Draw a bar for each order with its 95 % interval, evenly spaced: orders of gears lie far apart."""
    at, amplitude = np.arange(len(spectrum.order)), spectrum.amplitude_deg
    reach = WITHIN_95 * spectrum.standard_uncertainty_deg
    step = -(-len(at) // _MOST_LABELS)
    with page_style():
        figure = new_figure(8.0, 2.4)
        axes = figure.add_subplot()
        axes.bar(
            at,
            amplitude,
            width=0.6,
            color=AFTER,
            alpha=0.5,
            linewidth=0.0,
            label=words.say("spectrum.amplitude"),
        )
        axes.vlines(
            at,
            np.maximum(amplitude - reach, 0.0),
            amplitude + reach,
            color=INK,
            linewidth=1.1,
            label=words.say("spectrum.interval"),
        )
        axes.set_xticks(at[::step], [spoken_order(order) for order in spectrum.order[::step].tolist()])
        axes.grid(axis="x", visible=False)
        marked_in(axes.yaxis, words.units.conversion("deg"))
        axes.set_xlabel(words.say("spectrum.order"))
        axes.set_ylabel(words.say("spectrum.amplitude_deg"))
        figure.legend(loc="outside upper left", ncols=2)
        return to_svg(figure, prefix, words.say("spectrum"))
