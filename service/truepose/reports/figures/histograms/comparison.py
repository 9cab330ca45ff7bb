"""How many held-out errors of which size: two models in the same bins."""

from functools import partial

import numpy as np
from markupsafe import Markup

from truepose.domain.arrays import FloatArray
from truepose.reports.figures.canvas import Colours, Drawing, new_figure, on_page, plain
from truepose.reports.figures.histograms.sizes import counted_readings, noise_line
from truepose.reports.wording.rounding import millimetres
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_BINS = 40
_NEARLY_ALL = 0.995  # of the errors; what lies beyond is counted in the last bin
_WORTH_A_CUT = 1.5  # a tail this much longer than nearly all errors would squeeze them


def comparison(
    before_mm: FloatArray, after_mm: FloatArray, noise_mm: float, words: Catalogue = IN_ENGLISH
) -> tuple[Markup, int]:
    """Return the histogram of both norms, and how many errors of either stand in the last bin for more.

    Parameters
    ----------
    before_mm, after_mm : ndarray, shape (n,)
        Norms of the errors [mm].
    noise_mm : float
        Mean norm that stated noise alone gives; not drawn where it is not within the picture.
    """
    end = _end(np.concatenate([before_mm, after_mm]))
    beyond = int((before_mm > end).sum() + (after_mm > end).sum())
    draw = partial(_drawn, before_mm, after_mm, noise_mm, words)
    return on_page(draw, "comparison", words.say("comparison")), beyond


def plain_comparison(before_mm: FloatArray, after_mm: FloatArray, noise_mm: float) -> Drawing:
    """Return the same histogram as a figure that a program may change; parameters as above."""
    return plain(partial(_drawn, before_mm, after_mm, noise_mm, IN_ENGLISH))


def _drawn(
    before_mm: FloatArray, after_mm: FloatArray, noise_mm: float, words: Catalogue, colours: Colours
) -> Drawing:
    end = _end(np.concatenate([before_mm, after_mm]))
    edges = np.linspace(0.0, end, _BINS + 1)
    figure = new_figure(8.0, 2.9)
    axes = figure.add_subplot()
    before, after = words.say("before"), words.say("after")
    for norms, colour, name in ((before_mm, colours.before, before), (after_mm, colours.after, after)):
        label = words.say("comparison.mean", name=name, mean=millimetres(float(norms.mean())))
        counts, _ = np.histogram(np.minimum(norms, end), edges)
        axes.stairs(counts, edges, fill=True, color=colour, alpha=0.5, label=label)
        axes.stairs(counts, edges, color=colour, linewidth=1.4)
    if 0.0 < noise_mm < end:
        noise_line(axes, noise_mm, colours, words)
    axes.set_xlim(0.0, end)
    counted_readings(figure, axes, words.say("comparison.error"), words)
    return figure


def _end(norms: FloatArray) -> float:
    largest, nearly = float(norms.max()), float(np.quantile(norms, _NEARLY_ALL))
    return max(largest if largest < _WORTH_A_CUT * nearly else nearly, 1e-6)
