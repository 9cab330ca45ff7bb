"""The report of a fleet: one HTML or PDF file, or the content of a page."""

import math
from dataclasses import dataclass
from pathlib import Path

from markupsafe import Markup

from truepose.fleet.answer.due import due
from truepose.fleet.answer.sentences import (
    cause_said,
    compared,
    headline,
    least_said,
    next_said,
    scatter_said,
    told_of,
    what,
)
from truepose.fleet.changes import Account, Named
from truepose.fleet.course import along
from truepose.fleet.forecast import concerned, passing
from truepose.reports.figures.curves.growth import Growth, growth_figure
from truepose.reports.fleets.rows import change_rows, due_rows, least_rows, shared_rows
from truepose.reports.pages import rendered, write_page
from truepose.words.catalogue import IN_ENGLISH, Catalogue


@dataclass(frozen=True, slots=True)
class FleetInput:
    """Robots of one type, compared."""

    account: Account  # whose days are those of the calendar
    robot: str  # the type
    limit_mm: float
    left_out: tuple[tuple[str, str], ...] = ()  # campaigns, and why
    simulated: bool = False


def write_fleet_report(path: Path, given: FleetInput, words: Catalogue = IN_ENGLISH) -> None:
    """Write a report as one self-contained file; raises UnwritableReportError."""
    write_page(path, "fleet.html", simulated=given.simulated, robot=given.robot, **_context(given, words))


def fleet_content(given: FleetInput, words: Catalogue) -> Markup:
    """Return the report without a frame, for a page that has one of its own."""
    return rendered("fleet_content.html", robot=given.robot, **_context(given, words))


def _context(given: FleetInput, words: Catalogue) -> dict[str, object]:
    account, limit_mm = given.account, given.limit_mm
    return {
        "words": words,
        "say": words.say,
        "headline": words.spoken(headline(account)),
        "good": not account.named,
        "compared": [words.spoken(one) for one in (compared(account), *scatter_said(account))],
        "least": [words.spoken(one) for one in least_said(account)],
        "least_rows": tuple(least_rows(account, words)),
        "limit_mm": limit_mm,
        "rows": change_rows(account, limit_mm, words),
        "changes": [
            _change(account, one, number, limit_mm, words) for number, one in enumerate(account.named)
        ],
        "next": words.spoken(next_said(due(account, limit_mm)[0], limit_mm)),
        "due": due_rows(account, limit_mm, words),
        "shared": tuple(shared_rows(account, words)),
        "left_out": given.left_out,
    }


def _change(
    account: Account, named: Named, number: int, limit_mm: float, words: Catalogue
) -> tuple[str, list[str], Markup]:
    """Return title, sentences and picture of a change."""
    passes = passing(account.fleet, named, limit_mm)
    change = named.change
    title = words.between.join((words.spoken(what(change)), words.spoken(cause_said(change.cause))))
    told, days = along(account, named), account.fleet.day[concerned(account.fleet, named)]
    growth = Growth(
        first=float(days.min()),
        day=told.day,
        size_mm=told.size_mm,
        u_mm=told.u_mm,
        kind=change.kind,
        since=change.since,
        named_mm=named.size_mm,
        named_u_mm=named.size_u_mm,
        limit_mm=limit_mm,
        passed=None
        if passes is None or not math.isfinite(passes.earliest)
        else (passes.earliest, passes.latest),
    )
    sentences = [words.spoken(one) for one in told_of(account, named, passes)]
    return title, sentences, growth_figure(growth, f"growth{number}", title, words)
