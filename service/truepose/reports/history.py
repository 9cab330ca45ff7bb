"""A robot over months: alarms first, then its courses, then two results side by side."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from typing import Final

import numpy as np
from markupsafe import Markup

from truepose.diagnosis.alarms import Alarm
from truepose.diagnosis.history import CauseObservation, CauseOverTime, Change, Sighting
from truepose.domain.identification import Statistics
from truepose.exchange.models.document import file_factor, file_unit
from truepose.messages.catalogue import Catalogue
from truepose.reports.cause_words import with_unit
from truepose.reports.figures.error_maps import exaggeration, views
from truepose.reports.figures.over_days import Course, course_figure
from truepose.reports.history_sentences import alarm_words, cause_name, change_words
from truepose.reports.identification.parameters import meaning
from truepose.reports.report import Description, Report
from truepose.reports.rounding import format_rounded, millimetres, p_value, with_uncertainty
from truepose.reports.tables import Table, heads_of
from truepose.validation.model_comparison import ModelComparison, ParameterChange, ToolShift


@dataclass(frozen=True, slots=True)
class Measurement:
    """A diagnosis of the robot, as far as its course needs it."""

    diagnosis_id: int
    measured_at: str | None
    before: Statistics | None  # errors of the model it started from, where it never was
    after: Statistics | None
    temperature_c: tuple[float, float] | None  # lowest and highest; None: nobody wrote it down


@dataclass(frozen=True, slots=True)
class HistoryReport(Report):
    """A robot over months; `two` are the results that the reader chose."""

    robot: str
    measurements: tuple[Measurement, ...]
    causes: tuple[CauseOverTime, ...]
    alarms: tuple[Alarm, ...]
    two: ModelComparison | None

    def described(self, words: Catalogue) -> Description:
        """Return what grew, the courses of errors, causes and temperatures, and what changed between two."""
        two, dated = self.two, [one for one in self.measurements if one.measured_at is not None]
        shown = {
            "headline": _headline(dated, len(self.alarms), words),
            "good": not self.alarms,
            "alarms": [alarm_words(alarm, words) for alarm in self.alarms],
            "errors": _errors(dated, words),
            "temperatures": _temperatures(dated, words),
            "causes": cause_histories(self.causes, self.alarms, words),
            "two": two,
        }
        if two is not None:
            shown |= {
                "verdict": verdict_sentence(two, words),
                "in_space": space_sentences(two, words),
                "changes": change_table(two, words),
                "changed": any(change.significant for change in two.changes),
                "moved": None if two.moved is None else moved_views(two.moved, words),
            }
        return Description(self.robot, self.robot, "history.html", shown)


_BAND: Final = 1.96  # standard uncertainties of 95 %
_SIGHTINGS: Final[Mapping[Sighting, str]] = {
    Sighting.FOUND: "over_time.found",
    Sighting.WITH_OTHERS: "over_time.with_others",
    Sighting.NOT_FOUND: "over_time.not_found",
    Sighting.NOT_VISIBLE: "over_time.not_visible",
    Sighting.PART_OF_START: "over_time.part_of_start",
    Sighting.NOT_MENTIONED: "over_time.not_mentioned",
}


@dataclass(frozen=True, slots=True)
class CauseHistory:
    """A cause as a page shows it."""

    name: str
    picture: Markup | None  # None where nothing can be drawn over days
    sentences: tuple[str, ...]
    seen: tuple[tuple[str, str, str], ...]  # day, what was said, amplitude
    grew: bool


def cause_histories(
    causes: Sequence[CauseOverTime], alarms: Sequence[Alarm], words: Catalogue
) -> tuple[CauseHistory, ...]:
    """Return every cause for a page; those of an alarm come first."""
    alarmed = [alarm.cause for alarm in alarms]
    ordered = sorted(causes, key=lambda cause: cause not in alarmed)
    return tuple(
        CauseHistory(
            cause_name(cause, words),
            _picture(cause, f"cause{number}", words),
            tuple(change_words(cause, change, words) for change in _told(cause)),
            tuple(_seen(cause, sign, words) for sign in cause.signs),
            cause in alarmed,
        )
        for number, cause in enumerate(ordered)
    )


def _told(cause: CauseOverTime) -> list[Change]:
    """Return the changes worth a sentence: all of it, and the last step."""
    return [*([] if cause.overall is None else [cause.overall]), *cause.changes[-1:]]


def _picture(cause: CauseOverTime, ident: str, words: Catalogue) -> Markup | None:
    dated = [sign for sign in cause.signs if sign.measured_at is not None]
    if not any(sign.amplitude is not None for sign in dated):
        return None
    value = np.array([np.nan if sign.amplitude is None else sign.amplitude for sign in dated])
    u = np.array([np.nan if s.standard_uncertainty is None else s.standard_uncertainty for s in dated])
    name = cause_name(cause, words)
    course = Course(name, value, value - _BAND * u, value + _BAND * u)
    days = [sign.measured_at or "" for sign in dated]
    return course_figure(days, [course], words.say("over_time.amplitude"), cause.unit, ident, name, words)


def _seen(cause: CauseOverTime, sign: CauseObservation, words: Catalogue) -> tuple[str, str, str]:
    day = words.say("over_time.undated") if sign.measured_at is None else sign.measured_at[:10]
    if sign.amplitude is None or sign.standard_uncertainty is None:
        return day, words.say(_SIGHTINGS[sign.sighting]), ""
    size = with_unit(sign.amplitude, sign.standard_uncertainty, cause.unit, words)
    return day, words.say(_SIGHTINGS[sign.sighting]), size


def _headline(dated: Sequence[Measurement], alarms: int, words: Catalogue) -> str:
    if len(dated) < 2:
        return words.say("over_time.one")
    first, last = (one.measured_at or "" for one in (dated[0], dated[-1]))
    months = round((date.fromisoformat(last[:10]) - date.fromisoformat(first[:10])).days / 30.44)
    if alarms:
        return words.say("over_time.alarm", n=alarms)
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


_MOST_ARROWS: Final = 250
_NAMED: Final = 3  # parameters in the sentence; the table has all
_SIGNIFICANT: Final = " ▲"


def change_table(found: ModelComparison, words: Catalogue) -> Table:
    """Return a row per common parameter, the least likely by chance first."""
    changed = ("side.earlier", "side.later", "side.difference", "report.unit", "side.chance")
    ordered = sorted(found.changes, key=lambda one: 2.0 if one.p_value is None else one.p_value)
    return Table(
        heads_of(words, "side.parameter", "side.meaning", *changed),
        [_change_row(one, words) for one in ordered],
        names=2,
        strong=[row for row, one in enumerate(ordered) if one.significant],
    )


def _change_row(change: ParameterChange, words: Catalogue) -> tuple[str, ...]:
    unit = file_unit(change.unit)
    factor, u = file_factor(change.unit), change.standard_uncertainty * file_factor(change.unit)
    return (
        change.name + (_SIGNIFICANT if change.significant else ""),
        meaning(change.name, change.effect, words),
        format_rounded(change.earlier * factor, u, unit),
        format_rounded(change.later * factor, u, unit),
        with_uncertainty(change.difference * factor, u, unit),
        words.units.conversion(unit).symbol,
        "" if change.p_value is None else p_value(change.p_value),
    )


def verdict_sentence(found: ModelComparison, words: Catalogue) -> str:
    """Return whether the robot changed, and which of its parameters did, in a sentence."""
    if found.p_value is None:
        return words.say("side.not_comparable")
    changed = [change for change in found.changes if change.significant]
    if changed:
        first = sorted(changed, key=_deviation, reverse=True)[:_NAMED]
        names = words.between.join(change.name for change in first)
        counts = {"number": len(changed), "total": len(found.changes)}
        return words.say("side.changed", **counts, names=names, p=p_value(found.p_value))
    key = "side.together" if found.p_value < 0.05 else "side.unchanged"
    return words.say(key, p=p_value(found.p_value))


def _deviation(change: ParameterChange) -> float:
    return abs(change.difference) / change.standard_uncertainty


def space_sentences(found: ModelComparison, words: Catalogue) -> tuple[str, ...]:
    """Return what the change is at the tool, and what the earlier model is worth today."""
    told = []
    if found.moved is not None:
        moved = found.moved
        told.append(words.say("side.moved", mean=millimetres(moved.mean_mm), most=millimetres(moved.max_mm)))
    if found.earlier_now is not None and found.later_now is not None:
        told.append(
            words.say(
                "side.worth",
                earlier=millimetres(found.earlier_now.mean_mm),
                later=millimetres(found.later_now.mean_mm),
                noise=millimetres(found.later_now.noise_mm),
            )
        )
    return tuple(told)


def moved_views(moved: ToolShift, words: Catalogue) -> tuple[Markup, float]:
    """Return where the tool goes now, as arrows in three views, and how many times longer they are."""
    shown = slice(None, None, -(-len(moved.places_mm) // _MOST_ARROWS))
    times = exaggeration(moved.places_mm, moved.moved_mm)
    return views(moved.places_mm[shown], times * moved.moved_mm[shown], "moved", words), times
