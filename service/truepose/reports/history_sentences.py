"""What is said of a cause over the months."""

from typing import Final

from truepose.diagnosis.alarms import Alarm, NewCause
from truepose.diagnosis.history import CauseObservation, CauseOverTime, Change
from truepose.domain.diagnosis import Cause
from truepose.messages.catalogue import Catalogue
from truepose.reports.cause_words import cause_words, with_unit
from truepose.reports.rounding import millimetres, p_value

_DAY: Final = len("2026-03-03")  # of a time in ISO 8601
_MINUTE: Final = len("2026-03-03T08:15")


def cause_name(cause: CauseOverTime, words: Catalogue) -> str:
    """Return what a cause is called, with the way in which it acts where it has several."""
    name = cause_words(Cause(cause.effect, cause.subject), words)
    if cause.variant is None:
        return name
    return words.say(
        "over_time.variant", cause=name, what=cause.variant.name, value=f"{cause.variant.value:g}"
    )


def alarm_words(alarm: Alarm, words: Catalogue) -> str:
    """Return what grew or appeared, as one sentence."""
    if not isinstance(alarm, NewCause):
        return change_words(alarm.cause, alarm.change, words)
    return words.say(
        "over_time.appeared",
        cause=cause_name(alarm.cause, words),
        earlier=alarm.absent_on[:_DAY],
        limit=millimetres(alarm.at_most_mm),
        later=alarm.found_on[:_DAY],
        worth=millimetres(alarm.worth_mm),
    )


def change_words(cause: CauseOverTime, change: Change, words: Catalogue) -> str:
    """Return a change as one sentence with its uncertainty and its chance."""
    days = {sign.diagnosis_id: sign for sign in cause.signs}
    earlier, later = days[change.from_id], days[change.to_id]
    first, last = _moments(earlier, later)
    return words.say(
        _direction(earlier, later),
        cause=cause_name(cause, words),
        size=with_unit(abs(change.difference), change.standard_uncertainty, cause.unit, words),
        earlier=first,
        later=last,
        verdict=_verdict(change, words),
    )


def _moments(earlier: CauseObservation, later: CauseObservation) -> tuple[str, str]:
    """Return both times, to the minute where the day is the same."""
    first, last = earlier.measured_at or "", later.measured_at or ""
    length = _MINUTE if first[:_DAY] == last[:_DAY] else _DAY
    return first[:length].replace("T", " "), last[:length].replace("T", " ")


def _direction(earlier: CauseObservation, later: CauseObservation) -> str:
    before, after = earlier.amplitude or 0.0, later.amplitude or 0.0
    if before * after < 0.0:
        return "over_time.turned"
    return "over_time.grew" if abs(after) >= abs(before) else "over_time.fell"


def _verdict(change: Change, words: Catalogue) -> str:
    if change.p_value is None:
        return words.say("over_time.untested")
    key = "over_time.beyond_chance" if change.significant else "over_time.within_chance"
    return words.say(key, p=p_value(change.p_value))
