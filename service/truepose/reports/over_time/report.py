"""The page of a robot over months: alarms first, then its courses, then two results side by side."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date

import numpy as np
from markupsafe import Markup

from truepose.diagnosis.alarms import Alarm
from truepose.diagnosis.history import CauseOverTime
from truepose.domain.results.identification import Statistics
from truepose.judgement.two_models import TwoModels
from truepose.reports.figures.curves.course import Course, course_figure
from truepose.reports.over_time.causes import causes_shown
from truepose.reports.over_time.sentences import alarm_words
from truepose.reports.over_time.side_by_side import (
    change_rows,
    moved_views,
    space_sentences,
    verdict_sentence,
)
from truepose.reports.pages import rendered
from truepose.words.catalogue import Catalogue


@dataclass(frozen=True, slots=True)
class Measurement:
    """A diagnosis of the robot, as far as its course needs it."""

    diagnosis_id: int
    measured_at: str | None
    before: Statistics | None  # errors of the model it started from, where it never was
    after: Statistics | None
    temperature_c: tuple[float, float] | None  # lowest and highest; None: nobody wrote it down


@dataclass(frozen=True, slots=True)
class OverTimeInput:
    """A robot over months; `two` are the results that the reader chose."""

    measurements: tuple[Measurement, ...]
    causes: tuple[CauseOverTime, ...]
    alarms: tuple[Alarm, ...]
    two: TwoModels | None


def over_time_content(given: OverTimeInput, words: Catalogue) -> Markup:
    """Return the content of the page, without a frame."""
    alarms = given.alarms
    dated = [one for one in given.measurements if one.measured_at is not None]
    return rendered(
        "over_time_content.html",
        words=words,
        say=words.say,
        headline=_headline(dated, len(alarms), words),
        good=not alarms,
        alarms=[alarm_words(alarm, words) for alarm in alarms],
        errors=_errors(dated, words),
        temperatures=_temperatures(dated, words),
        causes=causes_shown(given.causes, alarms, words),
        two=given.two,
        verdict="" if given.two is None else verdict_sentence(given.two, words),
        in_space=() if given.two is None else space_sentences(given.two, words),
        rows=() if given.two is None else change_rows(given.two, words),
        moved=None if given.two is None or given.two.moved is None else moved_views(given.two.moved, words),
    )


def _headline(dated: Sequence[Measurement], alarms: int, words: Catalogue) -> str:
    if len(dated) < 2:
        return words.say("over_time.one")
    first, last = (one.measured_at or "" for one in (dated[0], dated[-1]))
    months = round((date.fromisoformat(last[:10]) - date.fromisoformat(first[:10])).days / 30.44)
    if alarms:
        return words.say("over_time.alarm.one" if alarms == 1 else "over_time.alarm", number=alarms)
    return words.say("over_time.quiet", number=len(dated), months=months)


def _errors(dated: Sequence[Measurement], words: Catalogue) -> Markup | None:
    if not dated:
        return None
    courses = [
        _error_course([one.before for one in dated], words.say("over_time.before")),
        _error_course([one.after for one in dated], words.say("over_time.after")),
    ]
    return _drawn(dated, courses, words.say("over_time.error.short"), "mm", "errors", words)


def _error_course(errors: Sequence[Statistics | None], name: str) -> Course:
    mean = np.array([np.nan if one is None else one.mean_mm for one in errors])
    most = np.array([np.nan if one is None else one.max_mm for one in errors])
    return Course(name, mean, mean, most)


def _temperatures(dated: Sequence[Measurement], words: Catalogue) -> Markup | None:
    """Draw the lowest and highest temperatures; None where none was written down."""
    if not any(one.temperature_c for one in dated):
        return None
    low, high = np.array([one.temperature_c or (np.nan, np.nan) for one in dated]).T
    name = words.say("over_time.temperature")
    return _drawn(dated, [Course(name, (low + high) / 2.0, low, high)], name, "°C", "temperatures", words)


def _drawn(
    dated: Sequence[Measurement],
    courses: Sequence[Course],
    quantity: str,
    unit: str,
    ident: str,
    words: Catalogue,
) -> Markup:
    days = [one.measured_at or "" for one in dated]
    return course_figure(days, courses, quantity, unit, ident, quantity, words)
