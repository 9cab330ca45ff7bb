"""The report of a ballbar sphere test: one HTML file, or the content of a page."""

from pathlib import Path

from markupsafe import Markup

from truepose.judgement.sphere.judged import NOMINAL, SphereTest
from truepose.reports.figures.curves.radial import radial_figure
from truepose.reports.front.held_to_limit import NO_LIMIT, Limit, sphere_front
from truepose.reports.front.page import front_page
from truepose.reports.pages import rendered, write_page
from truepose.reports.spheres.sentences import (
    WORDS_OF_ROW,
    order_sentences,
    sphere_heads,
    sphere_rows,
    sphere_sentences,
)
from truepose.reports.traceability.conditions import ReportConditions
from truepose.reports.traceability.imprint import Imprint
from truepose.reports.traceability.traced import Traced, traced_context
from truepose.words.catalogue import IN_ENGLISH, Catalogue


def write_sphere_report(
    path: Path,
    test: SphereTest,
    robot: str,
    words: Catalogue = IN_ENGLISH,
    limit: Limit = NO_LIMIT,
    *,
    simulated: bool = False,
) -> None:
    """Write the report of a sphere test as one self-contained HTML file, a figure for each ball.

    Raises
    ------
    UnwritableReportError
        The file cannot be written.
    """
    best = test.order[0][0] if test.order else NOMINAL  # which the arm would be commanded by
    page = sphere_front(test, robot, best, limit, words)
    front = front_page(page, ReportConditions(simulated=simulated), words)
    given = _context(test, words) | {"robot": robot, "imprint": Imprint(robot), "front": front}
    write_page(path, "spheres.html", simulated=simulated, traced=None, **given)


def sphere_content(test: SphereTest, traced: Traced, words: Catalogue) -> Markup:
    """Return the report without a frame, for a page that has one of its own."""
    stated = traced_context(traced, words)
    return rendered("spheres_content.html", traced=traced, **stated, **_context(test, words))


def _context(test: SphereTest, words: Catalogue) -> dict[str, object]:
    shown = [
        (
            sphere,
            radial_figure(sphere, words) if sphere.models else None,
            [words.spoken(sentence) for sentence in sphere_sentences(sphere, words)],
        )
        for sphere in test.spheres
    ]
    return {
        "heads": sphere_heads(words),
        "names": WORDS_OF_ROW,
        "rows": tuple(sphere_rows(test, words)),
        "order": [words.spoken(sentence) for sentence in order_sentences(test, words)],
        "spheres": shown,
        "words": words,
        "say": words.say,
    }
