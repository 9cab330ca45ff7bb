"""The one picture of a first page: mean and largest error before and after, and the limit beside them."""

from dataclasses import dataclass

from markupsafe import Markup

from truepose.domain.results.identification import Statistics
from truepose.reports.pages import rendered
from truepose.reports.wording.rounding import millimetres
from truepose.words.catalogue import Catalogue

_WIDTH = 390.0  # of the longest bar, in units of the picture


@dataclass(frozen=True, slots=True)
class Bar:
    """A model's errors; lengths in units of the picture."""

    name: str
    colour: str
    y: int
    mean: float
    largest: float
    beside: float  # where its text begins
    mean_text: str
    largest_text: str


def error_bars(
    before: Statistics, after: Statistics, words: Catalogue, limit_mm: float | None = None
) -> Markup:
    """Draw both models on one scale from 0; the limit is a line across both."""
    longest = max(before.max_mm, after.max_mm, limit_mm or 0.0) or 1.0
    limit = None if limit_mm is None else _WIDTH * limit_mm / longest
    models = (("model.nominal", "before", before), ("model.identified", "after", after))
    bars = [
        Bar(
            words.say(name),
            f"var(--{colour})",
            46 + 64 * row,
            _WIDTH * one.mean_mm / longest,
            _WIDTH * one.max_mm / longest,
            8.0 + max(_WIDTH * one.max_mm / longest, limit or 0.0),
            millimetres(one.mean_mm),
            millimetres(one.max_mm),
        )
        for row, (name, colour, one) in enumerate(models)
    ]
    return rendered("bars.html", bars=bars, limit=limit, limit_mm=limit_mm, say=words.say, words=words)
