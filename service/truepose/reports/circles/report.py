"""The report of a single-axis circle test: one HTML file, or the content of a page."""

from pathlib import Path

from markupsafe import Markup

from truepose.judgement.circle.judged import CircleTest
from truepose.reports.circles.sentences import (
    circle_heads,
    circle_rows,
    circle_sentences,
    withheld_sentences,
)
from truepose.reports.figures.curves.tangential import tangential_figure
from truepose.reports.front.held_to_limit import NO_LIMIT, Limit, circles_front
from truepose.reports.front.page import front_page
from truepose.reports.pages import rendered, write_page
from truepose.reports.traceability.conditions import ReportConditions
from truepose.reports.traceability.imprint import Imprint
from truepose.reports.traceability.traced import Traced, traced_context
from truepose.words.catalogue import IN_ENGLISH, Catalogue


def write_circle_report(
    path: Path, test: CircleTest, robot: str, words: Catalogue = IN_ENGLISH, limit: Limit = NO_LIMIT
) -> None:
    """Write the report of a circle test as one self-contained HTML file, a figure for each circle.

    Raises
    ------
    UnwritableReportError
        The file cannot be written.
    """
    front = front_page(circles_front(test, robot, limit, words), ReportConditions(), words)
    given = _context(test, words) | {"robot": robot, "imprint": Imprint(robot), "front": front}
    write_page(path, "circles.html", simulated=False, traced=None, **given)


def circle_content(test: CircleTest, traced: Traced, words: Catalogue) -> Markup:
    """Return the report without a frame, for a page that has one of its own."""
    stated = traced_context(traced, words)
    return rendered("circles_content.html", traced=traced, **stated, **_context(test, words))


def _context(test: CircleTest, words: Catalogue) -> dict[str, object]:
    shown = [
        (one, tangential_figure(one, words), [words.spoken(sentence) for sentence in circle_sentences(one)])
        for one in test.circles
    ]
    return {
        "heads": circle_heads(words),
        "rows": tuple(circle_rows(test)),
        "circles": shown,
        "withheld": [words.spoken(sentence) for sentence in withheld_sentences(test)],
        "words": words,
        "say": words.say,
    }
