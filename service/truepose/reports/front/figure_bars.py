"""A bar for each figure of a test, with its expanded uncertainty, and the limit across all of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from markupsafe import Markup

from truepose.judgement.figure import Figure
from truepose.reports.pages import rendered
from truepose.reports.wording.rounding import rounded
from truepose.words.catalogue import Catalogue

_WIDTH: Final = 330.0  # of the longest bar with its uncertainty, in units of the picture
_ROW: Final = 34
_TOP: Final = 14


@dataclass(frozen=True, slots=True)
class FigureBar:
    """A figure; lengths in units of the picture."""

    name: str
    y: int
    length: float
    low: float  # ends of the 95 % interval
    high: float
    text: str


def figure_bars(named: Sequence[tuple[str, Figure]], limit_mm: float | None, words: Catalogue) -> Markup:
    """Draw figures [mm] on one scale from 0, largest first; the limit is a line across all."""
    longest = max([abs(one.value) + 2.0 * one.standard_uncertainty for _, one in named] + [limit_mm or 0.0])
    scale = _WIDTH / (longest or 1.0)
    ranked = sorted(named, key=lambda one: abs(one[1].value), reverse=True)
    bars = [_bar(name, one, _TOP + _ROW * row, scale, words) for row, (name, one) in enumerate(ranked)]
    return rendered(
        "figure_bars.html",
        bars=bars,
        bottom=_TOP + _ROW * len(bars),
        limit=None if limit_mm is None else limit_mm * scale,
        limit_mm=limit_mm,
        say=words.say,
        words=words,
    )


def _bar(name: str, figure: Figure, y: int, scale: float, words: Catalogue) -> FigureBar:
    size, u = abs(figure.value), figure.standard_uncertainty
    ends = (max(size - 2.0 * u, 0.0) * scale, (size + 2.0 * u) * scale)
    text = words.units.quantity(rounded(size, 2.0 * u, "mm"), "mm")
    return FigureBar(name, y, size * scale, *ends, text)
