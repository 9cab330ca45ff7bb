"""Which robots are to be measured next, and why: every reason with its figures, the most urgent first.

First robots of which nobody knows how they stand; then those whose last validation failed, could not be
decided, or found a model worse than it claims (without a limit nothing fails); then those whose last
measurement proves nothing, that carry another tool or stand elsewhere than their model knows, or that a
diagnosis does not explain; then what months foretell before the next day; then age; last what a diagnosis
asks for (decision 0069). The clock of a cell may be wrong: a robot whose last day is yet to come would
otherwise never be due.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date, timedelta
from enum import StrEnum
from typing import Final

from truepose.messages.message import Message, Value, message
from truepose.storage.caches import FleetComparison, LimitForecast
from truepose.storage.plant.overview import ResultFacts, RobotMeasured
from truepose.storage.plant.result_projections import ToldKind
from truepose.storage.results.items import FAILED, UNDECIDED, WORSE

_MONTH_DAYS: Final = 30.0  # a quick check each month
_AHEAD: Final = timedelta(days=1)  # of the plant's day, in another time zone
_UNEXPLAINED: Final = "unexplained"


class DueReason(StrEnum):
    """What speaks for measuring a robot, the most urgent first."""

    UNMEASURED = "unmeasured"
    DOUBTFUL = "doubtful"  # its last day is not over yet, or is no day
    FAILED = "failed"  # its last validation
    UNDECIDED = "undecided"  # its last validation, of which the readings are too uncertain for the limit
    WORSE = "worse"  # by its last validation than its model claims; without a limit nothing fails
    UNCERTIFIED = "uncertified"  # what measured it last had no valid certificate
    CHANGED = "changed"  # tool or place since its model was made
    UNEXPLAINED = "unexplained"  # by its last diagnosis
    WORSENING = "worsening"  # a change passes a limit before the robot is due
    OVERDUE = "overdue"
    ASKED = "asked"  # for more, by its last diagnosis


@dataclass(frozen=True, slots=True)
class DueAfter:
    """How many days after its last measurement a robot is due."""

    days: float = _MONTH_DAYS
    by_type: Mapping[str, float] = field(default_factory=dict)  # of robots of a type; else `days`

    def of(self, robot: str) -> float:
        """Return the days of robots of a type."""
        return self.by_type.get(robot, self.days)


@dataclass(frozen=True, slots=True)
class Evidence:
    """What is on record beside the days on which robots were measured."""

    told: Mapping[str, Mapping[ToldKind, ResultFacts]] = field(default_factory=dict)  # by robot
    expires: Mapping[str, str] = field(default_factory=dict)  # last day of an instrument's certificate
    compared: Sequence[FleetComparison] = ()  # the newest comparison of each type


@dataclass(frozen=True, slots=True)
class Reason:
    """One reason to measure a robot."""

    why: DueReason
    sentence: Message
    weight: float = 0.0  # among reasons of the same kind, the greatest first
    record: ResultFacts | None = None  # that says so
    compared: FleetComparison | None = None  # that says so


@dataclass(frozen=True, slots=True)
class RobotStatus:
    """A robot, and what speaks for measuring it, the most urgent first; nothing: it is not due."""

    measured: RobotMeasured
    reasons: tuple[Reason, ...]


def latest_day(today: date) -> date:
    """Return the last day that a cell whose clock is right may say."""
    return today + _AHEAD


def standing_robots(
    robots: Iterable[RobotMeasured], evidence: Evidence, due: DueAfter, today: date
) -> list[RobotStatus]:
    """Return how robots stand on a day, those first that are to be measured first."""
    foreseen = {
        one.robot: _Foretold(compared, one) for compared in evidence.compared for one in compared.foreseen
    }
    return sorted(
        (_standing(robot, evidence, due, today, foreseen.get(robot.serial_number)) for robot in robots),
        key=_urgency,
    )


@dataclass(frozen=True, slots=True)
class _Foretold:
    """What a comparison foretells of one robot."""

    by: FleetComparison
    of: LimitForecast


def _standing(
    robot: RobotMeasured, evidence: Evidence, due: DueAfter, today: date, foretold: _Foretold | None
) -> RobotStatus:
    told = evidence.told.get(robot.serial_number, {})
    found = (
        *_of_days(robot, due.of(robot.robot), today),
        *_of_certificate(robot, evidence.expires.get(robot.instrument_serial_number, "")),
        *_of_validation(told),
        *_of_change(told),
        *_of_diagnosis(told, robot.last_measured_on),
        *([] if foretold is None else _of_forecast(robot, foretold, due.of(robot.robot), today)),
    )
    return RobotStatus(robot, tuple(sorted(found, key=lambda reason: [*DueReason].index(reason.why))))


def _urgency(robot: RobotStatus) -> tuple[int, float, str]:
    if not robot.reasons:
        return len(DueReason), 0.0, robot.measured.serial_number
    first = robot.reasons[0]
    return [*DueReason].index(first.why), -first.weight, robot.measured.serial_number


def _of_days(robot: RobotMeasured, due_days: float, today: date) -> Iterator[Reason]:
    last = robot.last_measured_on
    if not last:
        yield Reason(DueReason.UNMEASURED, message("plant.why.unmeasured"))
        return
    day = _day(last)
    days = None if day is None else (today - day).days
    if days is None or days < -_AHEAD.days:
        yield Reason(DueReason.DOUBTFUL, message("plant.why.doubtful", day=last, cell=robot.cell))
    elif days > due_days:
        sentence = message("plant.why.overdue", day=last, days=days, due=due_days)
        yield Reason(DueReason.OVERDUE, sentence, days / due_days)


def _of_certificate(robot: RobotMeasured, expires: str) -> Iterator[Reason]:
    if expires and expires < robot.last_measured_on:
        instrument, day = robot.instrument_serial_number, robot.last_measured_on
        sentence = message("plant.why.uncertified", day=day, instrument=instrument, expires=expires)
        yield Reason(DueReason.UNCERTIFIED, sentence)


def _of_validation(told: Mapping[ToldKind, ResultFacts]) -> Iterator[Reason]:
    """Yield what the last validation leaves amiss; a model that was made after it answers it."""
    found = validation_of_newest_model(told)
    if found is not None and found.verdict in _AMISS:
        yield Reason(_AMISS[found.verdict], _amiss(found), times_allowed(found), found)


def validation_of_newest_model(told: Mapping[ToldKind, ResultFacts]) -> ResultFacts | None:
    """Return the last validation of a robot; None: there is none, or a model was made after it."""
    found, model = told.get("validation"), told.get("model")
    return None if found is None or (model is not None and model.is_later_than(found)) else found


_AMISS: Final = {FAILED: DueReason.FAILED, UNDECIDED: DueReason.UNDECIDED, WORSE: DueReason.WORSE}


def _amiss(found: ResultFacts) -> Message:
    """Return what a validation leaves amiss, with the figures that it has."""
    of: dict[str, Value] = {"number": found.record_id, "day": found.measured_on}
    if found.figure_mm is None:
        return message("plant.why.failed_beyond_measure", **of)
    if found.limit_mm is None:
        return message("plant.why.failed", **of, figure=found.figure_mm)
    if found.document.get("promised"):
        return message("plant.why.broken_promise", **of, figure=found.figure_mm, promised=found.limit_mm)
    key = "plant.why.undecided" if found.verdict == UNDECIDED else "plant.why.beyond_limit"
    return message(key, **of, figure=found.figure_mm, limit=found.limit_mm)


def times_allowed(found: ResultFacts) -> float:
    """Return by how many times an error exceeds what is allowed; 1 where nobody said what is."""
    if found.figure_mm is None:
        return math.inf  # no finite number was kept: it is beyond every limit
    return found.figure_mm / found.limit_mm if found.limit_mm else 1.0


def _of_change(told: Mapping[ToldKind, ResultFacts]) -> Iterator[Reason]:
    """Yield that a robot carries another tool, or stands elsewhere, than when its model was made."""
    model, now = told.get("model"), told.get("campaign")
    if model is None or now is None or not now.is_later_than(model):
        return
    before_tool, tool = model.document.get("tool"), now.document.get("tool")
    before_base, base = model.document.get("base"), now.document.get("base")
    values: dict[str, Value] = {"number": model.record_id, "day": now.measured_on}
    if before_tool and tool and before_tool != tool:
        sentence = message("plant.why.another_tool", **values, before=before_tool, tool=tool)
        yield Reason(DueReason.CHANGED, sentence, record=model)
    elif before_base and base and before_base != base:
        yield Reason(DueReason.CHANGED, message("plant.why.another_base", **values), record=model)


def _of_diagnosis(told: Mapping[ToldKind, ResultFacts], last_measured_on: str) -> Iterator[Reason]:
    """Yield what the last diagnosis leaves open; a later measurement answers it."""
    found = told.get("diagnosis")
    if found is None or found.measured_on < last_measured_on:
        return
    values: dict[str, Value] = {"number": found.record_id, "day": found.measured_on}
    if found.verdict == _UNEXPLAINED and found.figure_mm is not None:
        sentence = message("plant.why.unexplained", **values, figure=found.figure_mm)
        yield Reason(DueReason.UNEXPLAINED, sentence, found.figure_mm, found)
    asks = int(found.document.get("asks", 0))
    if asks:
        yield Reason(DueReason.ASKED, message("plant.why.asked", **values, count=asks), float(asks), found)


def _of_forecast(robot: RobotMeasured, foretold: _Foretold, due_days: float, today: date) -> Iterator[Reason]:
    """Yield that a change passes a limit before the robot is due; a later measurement answers it."""
    found, last = foretold.of, _day(robot.last_measured_on)
    if last is None or robot.last_measured_on > found.last_measured_on:
        return
    if found.rate_mm is None and found.earliest is None:
        yield Reason(DueReason.WORSENING, _beyond(foretold), math.inf, compared=foretold.by)
        return
    # What is overdue can be measured today at the earliest, and not on its day that has passed.
    earliest, next_due = _day(found.earliest or ""), max(last + timedelta(days=due_days), today)
    if earliest is not None and earliest <= next_due:
        weight = float((today - earliest).days)
        yield Reason(DueReason.WORSENING, _passes(foretold, next_due, today), weight, compared=foretold.by)


def _beyond(foretold: _Foretold) -> Message:
    found, limit_mm = foretold.of, foretold.by.limit_mm
    of: dict[str, Value] = {"cause": _cause_of(found), "since": found.since}
    return message("plant.why.beyond", **of, size_mm=found.size_mm, limit_mm=limit_mm)


def _passes(foretold: _Foretold, next_due: date, today: date) -> Message:
    """Return when a limit is passed, or since when it is."""
    found = foretold.of
    of: dict[str, Value] = {"cause": _cause_of(found), "since": found.since, "rate_mm": found.rate_mm or 0.0}
    of["limit_mm"] = foretold.by.limit_mm
    if found.day is not None and found.day <= today.isoformat():
        return message("plant.why.passed", **of, day=found.day)
    of |= {"earliest": found.earliest or "", "due": next_due.isoformat()}
    if found.day is None:
        return message("plant.why.may_pass", **of)
    return message("plant.why.passes", **of, day=found.day)


def _cause_of(found: LimitForecast) -> Message:
    of = {"effect": found.effect, "subject": found.subject}
    return message("fleet.wave", **of, order=found.order) if found.order else message("fleet.cause", **of)


def _day(day: str) -> date | None:
    try:
        return date.fromisoformat(day)
    except ValueError:
        return None
