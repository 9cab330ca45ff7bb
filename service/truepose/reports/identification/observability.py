"""How well a measurement determines each parameter, and which of them it cannot tell apart."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from markupsafe import Markup
from matplotlib.colors import to_rgb
from matplotlib.ticker import FuncFormatter

from truepose.domain.arrays import FloatArray
from truepose.domain.identification import Model, NotIdentifiable, Parameter
from truepose.identification.verdict.identifiability import UNDETERMINED
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import Text, message, together
from truepose.reports.figures.svg_rendering import (
    Colours,
    Drawing,
    new_figure,
    no_spines,
    on_page,
    page_style,
    to_svg,
)
from truepose.reports.rounding import uncertainty

HARDLY: Final = 1.0 / UNDETERMINED  # times better known; below, what was assumed before holds the parameter


@dataclass(frozen=True, slots=True)
class DeterminedParameter:
    """A parameter, and how many times better it is known than was assumed before the measurement."""

    name: str
    times: float

    @property
    def is_hardly(self) -> bool:
        """Whether what was assumed before holds it."""
        return self.times < HARDLY


def determined_parameters(parameters: Sequence[Parameter]) -> tuple[DeterminedParameter, ...]:
    """Return the parameters of which an assumption was stated, the worst known first."""
    known = (
        DeterminedParameter(one.name, one.prior_width / one.standard_uncertainty)
        for one in parameters
        if one.standard_uncertainty > 0.0 and one.prior_width > 0.0
    )
    return tuple(sorted(known, key=lambda one: one.times))


def observability_sentence(
    found: Sequence[DeterminedParameter], left_out: Sequence[NotIdentifiable] = ()
) -> Text:
    """Return how many parameters the readings determine, which is known worst, and how many were left out."""
    if not found:
        return message("seen.observability.none")
    worst, weak = found[0], sum(one.is_hardly for one in found)
    key = "seen.observability.weak" if weak else "seen.observability.all"
    told = message(
        key,
        weak=weak,
        number=len(found),
        name=worst.name,
        times=uncertainty(worst.times),
        percent=100.0 / worst.times,
    )
    groups = len(left_out)
    return together(told, message("seen.observability.open", number=groups) if groups else "")


_MOST: Final = 60  # parameters whose names still stand below one another


def observability_figure(
    found: Sequence[DeterminedParameter], words: Catalogue = IN_ENGLISH
) -> Markup | None:
    """Draw the worst known parameters; None where there is none to draw."""
    if not found:
        return None
    return on_page(
        partial(_bars, found[:_MOST], words), "observability", words.say("observability.picture"), words
    )


def _bars(found: Sequence[DeterminedParameter], words: Catalogue, colours: Colours) -> Drawing:
    halves = np.array_split(np.arange(len(found)), 2 if len(found) > 12 else 1)
    figure = new_figure(8.0, 0.9 + 0.17 * len(halves[0]))
    widest = max(found[-1].times, 2.0 * HARDLY)
    for column, rows in enumerate(halves, start=1):
        axes = figure.add_subplot(1, len(halves), column)
        part = [found[k] for k in rows]
        places = np.arange(len(part))
        colour = [colours.before if one.is_hardly else colours.after for one in part]
        axes.barh(places, [max(one.times, 1.0) for one in part], color=colour, height=0.7)
        axes.axvline(HARDLY, color=colours.ink, linewidth=1.0, linestyle=":")
        axes.set_yticks(places, [one.name for one in part], fontsize=7.5)
        axes.set_ylim(len(halves[0]) - 0.4, -0.6)
        axes.set_xscale("log")
        axes.set_xlim(1.0, 1.3 * widest)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.grid(axis="y", visible=False)
        axes.set_xlabel(words.say("observability.axis"))
    return figure


_MOST_READABLE = 48  # parameters whose names still stand side by side
_STRONG = 0.8
_MOST_PAIRS = 8
# The map is an image, which knows no variables of the page: two colours that stand on white and on black.
_POSITIVE, _NEGATIVE = "#3b82d6", "#e0653a"


def correlation_matrix(model: Model) -> FloatArray:
    """Return the correlation of the parameters, shape (P, P); 0 where a variance is 0."""
    width = np.sqrt(np.diag(model.covariance))
    safe = np.where(width > 0.0, width, np.inf)
    matrix = model.covariance / np.outer(safe, safe)
    np.fill_diagonal(matrix, 1.0)
    return np.asarray(np.clip(matrix, -1.0, 1.0))


def strongest_pairs(model: Model) -> tuple[tuple[str, str, float], ...]:
    """Return the pairs whose correlation exceeds 0.8 in size, strongest first, eight at most."""
    matrix = correlation_matrix(model)
    first, second = np.triu_indices(len(matrix), k=1)
    strong = [(i, j) for i, j in zip(first, second, strict=True) if abs(matrix[i, j]) > _STRONG]
    strong.sort(key=lambda pair: -abs(matrix[pair]))
    names = [parameter.name for parameter in model.parameters]
    return tuple((names[i], names[j], float(matrix[i, j])) for i, j in strong[:_MOST_PAIRS])


def correlation_map(model: Model, words: Catalogue = IN_ENGLISH) -> Markup | None:
    """Return the map, or None where it could not be read."""
    if not 2 <= len(model.parameters) <= _MOST_READABLE:
        return None
    names = [parameter.name for parameter in model.parameters]
    with page_style():
        figure = new_figure(6.4, 6.4)
        axes = figure.add_subplot()
        axes.imshow(_coloured(correlation_matrix(model)), interpolation="nearest")
        axes.set_xticks(range(len(names)), names, rotation=90, fontsize=6.5)
        axes.set_yticks(range(len(names)), names, fontsize=6.5)
        axes.tick_params(length=0)
        axes.grid(visible=False)
        no_spines(axes)
        return to_svg(figure, "correlation", words.say("correlation.picture"), words)


def _coloured(matrix: FloatArray) -> FloatArray:
    """Return colours with the size of the correlation as their opacity, shape (P, P, 4)."""
    hue = np.where(matrix[..., None] > 0.0, to_rgb(_POSITIVE), to_rgb(_NEGATIVE))
    return np.concatenate([hue, np.abs(matrix)[..., None]], axis=2)


def observability_context(
    parameters: Sequence[Parameter], left_out: Sequence[NotIdentifiable], words: Catalogue
) -> dict[str, object]:
    """Return what the template `observability.html` fills in."""
    found = determined_parameters(parameters)
    return {
        "observability": observability_figure(found, words),
        "observability_seen": observability_sentence(found, left_out),
    }
