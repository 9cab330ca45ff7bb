"""What histograms of the sizes of errors share: the noise in them, and what their axes say."""

from matplotlib.axes import Axes

from truepose.reports.figures.canvas import Colours, Drawing, marked_in
from truepose.reports.wording.rounding import millimetres
from truepose.words.catalogue import Catalogue


def noise_line(axes: Axes, noise_mm: float, colours: Colours, words: Catalogue) -> None:
    """Draw the mean error that stated noise alone gives."""
    label = words.say("comparison.noise", mean=millimetres(noise_mm))
    axes.axvline(noise_mm, color=colours.noise, linestyle="--", linewidth=1.4, label=label)


def counted_readings(figure: Drawing, axes: Axes, errors: str, words: Catalogue) -> None:
    """Say what is counted over which errors, and what the colours are."""
    marked_in(axes.xaxis, words.units.conversion("mm"))
    axes.grid(axis="x", visible=False)
    axes.set_xlabel(errors)
    axes.set_ylabel(words.say("curve.readings"))
    figure.legend(loc="outside upper left", ncols=3)
