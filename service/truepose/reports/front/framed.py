"""A report whose content is made elsewhere, with a first page and a frame around it."""

from dataclasses import dataclass

from markupsafe import Markup

from truepose.reports.front.page import Front, front_page
from truepose.reports.pages import rendered
from truepose.reports.traceability.conditions import ReportConditions
from truepose.reports.traceability.imprint import imprint_of
from truepose.words.catalogue import catalogue


@dataclass(frozen=True, slots=True)
class Framed:
    """What is put together."""

    front: Front
    content: Markup
    conditions: ReportConditions
    language: str


def framed_page(report: Framed) -> Markup:
    """Return the report as one self-contained page."""
    words, conditions = catalogue(report.language), report.conditions
    return rendered(
        "framed.html",
        front=front_page(report.front, conditions, words),
        imprint=imprint_of(report.front.robot, conditions, words),
        title=report.front.title,
        content=report.content,
        conditions=conditions,
        simulated=conditions.simulated,
        words=words,
        say=words.say,
    )
