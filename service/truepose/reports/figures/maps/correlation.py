"""Correlation of the identified parameters as a map, and the strongest pairs in words."""

import numpy as np
from markupsafe import Markup
from matplotlib.colors import to_rgb

from truepose.domain.arrays import FloatArray
from truepose.domain.results.identification import Model
from truepose.reports.figures.canvas import new_figure, no_spines, page_style, to_svg
from truepose.words.catalogue import IN_ENGLISH, Catalogue

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
        return to_svg(figure, "correlation", words.say("correlation.picture"))


def _coloured(matrix: FloatArray) -> FloatArray:
    """Return colours with the size of the correlation as their opacity, shape (P, P, 4)."""
    hue = np.where(matrix[..., None] > 0.0, to_rgb(_POSITIVE), to_rgb(_NEGATIVE))
    return np.concatenate([hue, np.abs(matrix)[..., None]], axis=2)
