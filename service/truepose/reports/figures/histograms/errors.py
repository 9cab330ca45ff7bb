"""How many errors of which size, before and after."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from markupsafe import Markup
from matplotlib.ticker import FuncFormatter, LogLocator

from truepose.domain.arrays import FloatArray
from truepose.identification.verdict.judge import Judged
from truepose.reports.figures.canvas import Colours, Drawing, new_figure, on_page, plain
from truepose.reports.figures.histograms.sizes import counted_readings, noise_line
from truepose.reports.wording.rounding import millimetres
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_BINS = 60
_SMALLEST_SHARE = 1e-4  # of the largest error: what lies below is drawn in the first bin
_DECADES_OF_LABELS = 6


@dataclass(frozen=True, slots=True)
class Histogram:
    """The picture, and what its caption must state."""

    picture: Markup
    noise_drawn: bool


def histogram(judged: Judged, noise_mm: float, words: Catalogue = IN_ENGLISH) -> Histogram:
    """Draw the histogram of error norms, both on one logarithmic axis: they differ by decades.

    `noise_mm` is the mean that noise alone would show; below the first bin it is not drawn.
    """
    before, after = _norms(judged)
    edges = _edges(np.concatenate([before, after]))
    draw = partial(_drawn, before, after, noise_mm, words)
    picture = on_page(draw, "histogram", words.say("histogram"))
    return Histogram(picture, noise_drawn=bool(noise_mm > edges[0]))


def plain_histogram(judged: Judged, noise_mm: float) -> Drawing:
    """Return the same histogram as a figure that a program may change."""
    return plain(partial(_drawn, *_norms(judged), noise_mm, IN_ENGLISH))


def _norms(judged: Judged) -> tuple[FloatArray, FloatArray]:
    return np.linalg.norm(judged.nominal_mm, axis=1), np.linalg.norm(judged.identified_mm, axis=1)


def _drawn(
    before: FloatArray, after: FloatArray, noise_mm: float, words: Catalogue, colours: Colours
) -> Drawing:
    figure = new_figure(8.0, 3.0)
    axes = figure.add_subplot()
    edges = _edges(np.concatenate([before, after]))
    nominal, identified = words.say("model.nominal"), words.say("model.identified")
    for norms, colour, name in ((before, colours.before, nominal), (after, colours.after, identified)):
        label = words.say("comparison.mean", name=name, mean=millimetres(float(norms.mean())))
        counts, _ = np.histogram(np.maximum(norms, edges[0]), edges)
        axes.stairs(counts, edges, fill=True, color=colour, alpha=0.75, label=label)
    if noise_mm > edges[0]:
        noise_line(axes, noise_mm, colours, words)
    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=3 * _DECADES_OF_LABELS))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_locator(LogLocator(subs=(), numticks=1))
    counted_readings(figure, axes, words.say("histogram.error"), words)
    return figure


def _edges(norms: FloatArray) -> FloatArray:
    largest = max(float(norms.max()), 1e-6)
    # A handful of tiny errors would stretch the axis over empty decades.
    smallest = max(float(np.quantile(norms, 0.005)), largest * _SMALLEST_SHARE)
    return np.geomspace(smallest / 1.2, largest * 1.05, _BINS + 1)
