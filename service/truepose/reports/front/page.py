"""The first page, the same for every kind of report: what differs is a `Front`."""

from collections.abc import Iterator
from dataclasses import dataclass

from markupsafe import Markup

from truepose.domain.sentences import Text
from truepose.reports.pages import rendered
from truepose.reports.traceability.conditions import NOT_STATED, ReportConditions
from truepose.words.catalogue import Catalogue


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


def text_of(text: Text | None, words: Catalogue) -> str:
    """Return a sentence in words; "" where there is none."""
    return "" if text is None else words.spoken(text)
