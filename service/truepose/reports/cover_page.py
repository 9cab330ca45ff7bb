"""The cover page of a report: pass or not, one figure, one picture, one sentence, who and when."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from markupsafe import Markup

from truepose.domain.identification import Statistics
from truepose.domain.validation import Decision
from truepose.messages.catalogue import Catalogue
from truepose.reports.pages import rendered
from truepose.reports.rounding import millimetres
from truepose.reports.traceability import NOT_STATED, ReportConditions


@dataclass(frozen=True, slots=True)
class OneFigure:
    """A number of a report's first page or first screen, as text."""

    name: str
    value: str
    remark: str = ""


@dataclass(frozen=True, slots=True)
class Front:
    """What stands on the first page of a report beside its conditions."""

    title: str
    look: str  # of the verdict, as `shape.html` knows it
    word: str
    outcome: str  # what every result begins with
    sentence: str
    robot: str
    figure: OneFigure | None = None
    picture: Markup | None = None
    caption: str = ""
    rule: str = ""  # by which was judged


def front_page(front: Front, conditions: ReportConditions, words: Catalogue) -> Markup:
    """Return the first page."""
    return rendered(
        "front.html",
        front=front,
        facts=tuple(_facts(front, conditions, words)),
        closing=words.spoken(conditions.closing),
        overridden=conditions.overridden,
        words=words,
        say=words.say,
    )


def _facts(front: Front, conditions: ReportConditions, words: Catalogue) -> Iterator[tuple[str, str]]:
    """Yield which robot, who, when, and which report."""
    say, unstated = words.say, words.say(NOT_STATED)
    serial = conditions.robot_serial_number or unstated
    yield say("report.robot"), say("report.robot.serial", robot=front.robot, serial=serial)
    yield say("conditions.person"), conditions.person or unstated
    yield say("front.measured"), _measured(conditions, words) or unstated
    yield say("report.written"), conditions.written_at or unstated
    yield say("front.units"), words.units_named
    if conditions.number:
        yield say("front.report"), conditions.number


def _measured(conditions: ReportConditions, words: Catalogue) -> str:
    starts = [one.started for one in conditions.sessions if one.started]
    ends = [one.ended for one in conditions.sessions if one.ended]
    if starts and ends:
        return words.say("range", low=min(starts), high=max(ends))
    return conditions.measured_at


def graded(good: bool | None) -> str:
    """Return the look of a verdict; None: it could not be decided."""
    return "not_answered" if good is None else "consistent" if good else "failed"


DECIDED: Final = {  # the word of a decision, and whether it is good
    "conforms": ("front.passed", True),
    "does not conform": ("front.failed", False),
    "cannot be decided": ("front.undecided", None),
}


def applied_rule(decision: Decision, words: Catalogue) -> str:
    """Return the limit, and how the uncertainty was counted."""
    key = "front.rule.simple" if decision.rule == "simple" else "front.rule.guard_band"
    return words.say(key, limit_mm=decision.limit_mm)


_WIDTH = 390.0  # of the longest bar, in units of the picture


@dataclass(frozen=True, slots=True)
class Bar:
    """Errors before or after; lengths in units of the picture."""

    name: str
    colour: str
    y: int
    mean: float
    largest: float
    beside: float  # where its text begins
    mean_text: str
    largest_text: str


def error_bars(
    before: Statistics,
    after: Statistics,
    words: Catalogue,
    limit_mm: float | None = None,
    names: tuple[str, str] = ("model.nominal", "model.identified"),
) -> Markup:
    """Draw both errors on one scale from 0; the limit is a line across both."""
    longest = max(before.max_mm, after.max_mm, limit_mm or 0.0) or 1.0
    limit = None if limit_mm is None else _WIDTH * limit_mm / longest
    models = zip(names, ("before", "after"), (before, after), strict=True)
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
