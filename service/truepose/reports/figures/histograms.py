"""Figures of how many: errors, distances, two models in the same bins."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator

from truepose.domain.arrays import FloatArray
from truepose.domain.validation import DistanceErrors, Histogram, SignedErrors
from truepose.identification.verdict.judge import Assessment
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.reports.figures.svg_rendering import Colours, Drawing, mark_axis, new_figure, on_page, plain
from truepose.reports.rounding import millimetres


def noise_line(axes: Axes, noise_mm: float, colours: Colours, words: Catalogue) -> None:
    """Draw the mean error that stated noise alone gives."""
    label = words.say("comparison.noise", mean=millimetres(noise_mm))
    axes.axvline(noise_mm, color=colours.noise, linestyle="--", linewidth=1.4, label=label)


def counted_readings(figure: Drawing, axes: Axes, errors: str, words: Catalogue) -> None:
    """Say what is counted over which errors, and what the colours are."""
    mark_axis(axes.xaxis, words.units.conversion("mm"))
    axes.grid(axis="x", visible=False)
    axes.set_xlabel(errors)
    axes.set_ylabel(words.say("curve.readings"))
    figure.legend(loc="outside upper left", ncols=3)


_BINS = 60
_SMALLEST_SHARE = 1e-4  # of the largest error: what lies below is drawn in the first bin
_DECADES_OF_LABELS = 6


@dataclass(frozen=True, slots=True)
class SizeHistogram:
    """The picture, and what its caption must state."""

    picture: Markup
    noise_drawn: bool


def histogram(judged: Assessment, noise_mm: float, words: Catalogue = IN_ENGLISH) -> SizeHistogram:
    """Draw the histogram of error norms, both on one logarithmic axis: they differ by decades.

    `noise_mm` is the mean that noise alone would show; below the first bin it is not drawn.
    """
    before, after = _norms(judged)
    edges = _edges_of_sizes(np.concatenate([before, after]))
    draw = partial(_draw_errors, before, after, noise_mm, words)
    picture = on_page(draw, "histogram", words.say("histogram"), words)
    return SizeHistogram(picture, noise_drawn=bool(noise_mm > edges[0]))


def plain_histogram(judged: Assessment, noise_mm: float) -> Drawing:
    """Return the same histogram as a figure that a program may change."""
    return plain(partial(_draw_errors, *_norms(judged), noise_mm, IN_ENGLISH))


def _norms(judged: Assessment) -> tuple[FloatArray, FloatArray]:
    return np.linalg.norm(judged.nominal_mm, axis=1), np.linalg.norm(judged.identified_mm, axis=1)


def _draw_errors(
    before: FloatArray, after: FloatArray, noise_mm: float, words: Catalogue, colours: Colours
) -> Drawing:
    figure = new_figure(8.0, 3.0)
    axes = figure.add_subplot()
    edges = _edges_of_sizes(np.concatenate([before, after]))
    nominal, identified = words.say("model.nominal"), words.say("model.identified")
    # One shape for all bars: half the bytes, and no hairlines between neighbours (commit f4cdb237).
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


def _edges_of_sizes(norms: FloatArray) -> FloatArray:
    largest = max(float(norms.max()), 1e-6)
    # A handful of tiny errors would stretch the axis over empty decades.
    smallest = max(float(np.quantile(norms, 0.005)), largest * _SMALLEST_SHARE)
    return np.geomspace(smallest / 1.2, largest * 1.05, _BINS + 1)


_BINS_OF_TWO = 40
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
    draw = partial(_draw_comparison, before_mm, after_mm, noise_mm, words)
    return on_page(draw, "comparison", words.say("comparison"), words), beyond


def plain_comparison(before_mm: FloatArray, after_mm: FloatArray, noise_mm: float) -> Drawing:
    """Return the same histogram as a figure that a program may change; parameters as above."""
    return plain(partial(_draw_comparison, before_mm, after_mm, noise_mm, IN_ENGLISH))


def _draw_comparison(
    before_mm: FloatArray, after_mm: FloatArray, noise_mm: float, words: Catalogue, colours: Colours
) -> Drawing:
    end = _end(np.concatenate([before_mm, after_mm]))
    edges = np.linspace(0.0, end, _BINS_OF_TWO + 1)
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


def distance_histogram(errors: DistanceErrors, words: Catalogue = IN_ENGLISH) -> Markup:
    """Draw both histograms, each over an axis of its own: they differ by decades."""
    return on_page(
        partial(_draw_distances, errors, words=words), "distances", words.say("distances.picture"), words
    )


def plain_distance_histogram(errors: DistanceErrors) -> Drawing:
    """Return the same histograms as a figure that a program may change."""
    return plain(partial(_draw_distances, errors, words=IN_ENGLISH))


def _draw_distances(errors: DistanceErrors, colours: Colours, words: Catalogue) -> Drawing:
    figure = new_figure(8.0, 2.8)
    panels = figure.subplots(1, 2)
    of_models = (
        ("model.nominal", errors.nominal, colours.before),
        ("model.identified", errors.identified, colours.after),
    )
    for axes, (name, signed, colour) in zip(panels, of_models, strict=True):
        axes.stairs(
            _shares(signed.histogram),
            _edges_of_distances(signed.histogram),
            fill=True,
            color=colour,
            alpha=0.75,
        )
        axes.axvline(0.0, color=colours.ink, linewidth=0.8)
        axes.set_title(_title(words.say(name), signed, words), loc="left")
        axes.set_xlabel(words.say("distances.axis"))
        axes.locator_params(axis="x", nbins=6)
        mark_axis(axes.xaxis, words.units.conversion("mm"))
    panels[0].set_ylabel(words.say("distances.share"))
    return figure


def _title(name: str, signed: SignedErrors, words: Catalogue) -> str:
    mean, percent = millimetres(signed.mean_mm), 100.0 * signed.positive_share
    return words.say("distances.panel", name=name, mean=mean, percent=percent)


def _shares(bins: Histogram) -> list[float]:
    total = sum(bins.counts)
    return [100.0 * count / total for count in bins.counts]


def _edges_of_distances(bins: Histogram) -> list[float]:
    return [float(edge) for edge in bins.width_mm * (bins.first + np.arange(len(bins.counts) + 1))]
