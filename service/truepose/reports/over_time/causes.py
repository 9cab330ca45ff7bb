"""Each cause over the months: its course, and in words whether it changed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from markupsafe import Markup

from truepose.diagnosis.alarms import Alarm
from truepose.diagnosis.history import CauseOverTime, Change, Sighting, Sign
from truepose.reports.figures.curves.course import Course, course_figure
from truepose.reports.over_time.sentences import cause_name, change_words
from truepose.reports.wording.causes import with_unit
from truepose.words.catalogue import Catalogue

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
class CauseShown:
    """A cause as a page shows it."""

    name: str
    picture: Markup | None  # None where nothing can be drawn over days
    sentences: tuple[str, ...]
    seen: tuple[tuple[str, str, str], ...]  # day, what was said, amplitude
    grew: bool


def causes_shown(
    causes: Sequence[CauseOverTime], alarms: Sequence[Alarm], words: Catalogue
) -> tuple[CauseShown, ...]:
    """Return every cause for a page; those of an alarm come first."""
    alarmed = [alarm.cause for alarm in alarms]
    ordered = sorted(causes, key=lambda cause: cause not in alarmed)
    return tuple(
        CauseShown(
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


def _seen(cause: CauseOverTime, sign: Sign, words: Catalogue) -> tuple[str, str, str]:
    day = words.say("over_time.undated") if sign.measured_at is None else sign.measured_at[:10]
    if sign.amplitude is None or sign.standard_uncertainty is None:
        return day, words.say(_SIGHTINGS[sign.sighting]), ""
    size = with_unit(sign.amplitude, sign.standard_uncertainty, cause.unit, words)
    return day, words.say(_SIGHTINGS[sign.sighting]), size
