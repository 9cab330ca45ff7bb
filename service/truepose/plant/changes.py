"""What changed since a day, robot by robot: what is known now against what was known when that day began.

Errors, the causes that diagnoses name, and models; each change is a sentence with its figures and leads to
the record that says so. The robots whose error grew most come first; certificates stand beside them.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import date
from enum import StrEnum
from typing import Any, Final, TypeAlias

from truepose.domain.cell import Paper
from truepose.messages.message import Message, Value, message
from truepose.storage.plant.certificates import CertificateRecord
from truepose.storage.plant.overview import NewestTold, ResultFacts, RobotMeasured
from truepose.storage.plant.result_projections import ToldKind

_SAME_MM: Final = 0.0005  # what a page does not show
_ERRORS: Final[tuple[ToldKind, ...]] = ("validation", "identification")
_Results: TypeAlias = Mapping[ToldKind, ResultFacts]
_Cause: TypeAlias = Mapping[str, Any]


class ChangeKind(StrEnum):
    """What of a robot changed."""

    ERROR = "error"
    CAUSE_NAMED = "cause_named"
    CAUSE_GONE = "cause_gone"
    MODEL = "model"


@dataclass(frozen=True, slots=True)
class RecordedChange:
    """One change, and the record that says so."""

    what: ChangeKind
    sentence: Message
    record: ResultFacts
    before_mm: float | None = None  # of an error; None: there is none to compare with
    after_mm: float | None = None

    @property
    def grown_mm(self) -> float:
        """By how much an error grew; 0 of anything else."""
        return 0.0 if self.before_mm is None or self.after_mm is None else self.after_mm - self.before_mm


@dataclass(frozen=True, slots=True)
class RobotChanged:
    """A robot, and what changed of it."""

    serial_number: str
    changes: tuple[RecordedChange, ...]

    @property
    def worsening_mm(self) -> float:
        """By how much its error grew, the most of several; negative where all fell."""
        grown = [change.grown_mm for change in self.changes if change.before_mm is not None]
        return max(grown, default=0.0)


def robots_changed(before: NewestTold, now: NewestTold, upto: date) -> list[RobotChanged]:
    """Return the robots of which something changed, the one whose error grew most first.

    What is dated later than `upto` changes nothing: it can only be a clock that is wrong.
    """
    each = (
        RobotChanged(serial, tuple(_changes(before.get(serial, {}), results, upto.isoformat())))
        for serial, results in now.items()
    )
    changed = [robot for robot in each if robot.changes]
    return sorted(changed, key=lambda robot: (-robot.worsening_mm, robot.serial_number))


class RobotsChanged:
    """The robots that changed, found anew on another day and where something came in."""

    def __init__(self) -> None:
        self._of: tuple[date, int] | None = None
        self._found: list[RobotChanged] = []

    def found(self, before: NewestTold, now: NewestTold, upto: date, read_up_to: int) -> list[RobotChanged]:
        """Return what `robots_changed` does, of what was read up to a row."""
        if self._of != (upto, read_up_to):
            self._of, self._found = (upto, read_up_to), robots_changed(before, now, upto)
        return self._found


def _changes(before: _Results, now: _Results, upto: str) -> Iterator[RecordedChange]:
    new = {
        kind: found
        for kind, found in now.items()
        if found.measured_on <= upto and (kind not in before or before[kind].id != found.id)
    }
    for kind in _ERRORS:
        if kind in new:
            yield from _of_error(before.get(kind), new[kind])
    if "diagnosis" in new:
        yield from _of_causes(before.get("diagnosis"), new["diagnosis"])
    if "model" in new:
        yield RecordedChange(ChangeKind.MODEL, _of_model(before.get("model"), new["model"]), new["model"])


def _of_error(before: ResultFacts | None, now: ResultFacts) -> Iterator[RecordedChange]:
    """Yield how an error changed, where what is compared is alike: means, or largest errors."""
    after_mm = now.figure_mm
    if after_mm is None:
        return
    named = _error_named(now)
    of: dict[str, Value] = {"what": named, "record": _record(now), "day": now.measured_on}
    if before is None or before.figure_mm is None or _error_named(before) != named:
        sentence = message("plant.changed.first", **of, after_mm=after_mm)
        yield RecordedChange(ChangeKind.ERROR, sentence, now, after_mm=after_mm)
        return
    grown_mm = after_mm - before.figure_mm
    if abs(grown_mm) >= _SAME_MM:
        key = "plant.changed.rose" if grown_mm > 0.0 else "plant.changed.fell"
        figures = {"before_mm": before.figure_mm, "after_mm": after_mm}
        sentence = message(key, **of, **figures, day_before=before.measured_on)
        yield RecordedChange(ChangeKind.ERROR, sentence, now, **figures)


def _error_named(found: ResultFacts) -> Message:
    """Return which error a result tells."""
    if found.kind == "identification":
        return message("plant.changed.error.identified")
    is_mean = found.document.get("promised") or found.limit_mm is None
    return message("plant.changed.error.validated" if is_mean else "plant.changed.error.largest")


def _record(found: ResultFacts) -> Message:
    is_validation = found.kind == "validation"
    return message(
        "plant.record.validation" if is_validation else "plant.record.identification", number=found.record_id
    )


def _of_causes(before: ResultFacts | None, now: ResultFacts) -> Iterator[RecordedChange]:
    """Yield which causes a diagnosis names that the one before did not, and which it names no more."""
    known, found = ({} if one is None else _causes(one) for one in (before, now))
    of: dict[str, Value] = {"number": now.record_id, "day": now.measured_on}
    named = tuple(_cause_said(cause) for key, cause in found.items() if key not in known)
    gone = tuple(_cause_said(cause) for key, cause in known.items() if key not in found)
    if before is not None:
        of["day_before"] = before.measured_on
    if named:
        sentence = message(
            "plant.changed.causes.first" if before is None else "plant.changed.causes.named",
            **of,
            causes=named,
        )
        yield RecordedChange(ChangeKind.CAUSE_NAMED, sentence, now)
    if gone:
        sentence = message("plant.changed.causes.gone", **of, causes=gone)
        yield RecordedChange(ChangeKind.CAUSE_GONE, sentence, now)


def _causes(found: ResultFacts) -> dict[tuple[str, str], _Cause]:
    return {(cause["effect"], cause["subject"]): cause for cause in found.document.get("causes", ())}


def _cause_said(cause: _Cause) -> Message:
    effect, subject = cause["effect"], cause["subject"]
    named = (
        message("fleet.cause", effect=effect, subject=subject)
        if subject
        else message("plant.cause", effect=effect)
    )
    worth_mm = cause.get("worth_mm")
    return named if worth_mm is None else message("plant.changed.cause", cause=named, worth_mm=worth_mm)


def _of_model(before: ResultFacts | None, now: ResultFacts) -> Message:
    of: dict[str, Value] = {"number": now.record_id, "day": now.measured_on}
    accepted_by = now.document.get("accepted_by")
    if accepted_by:
        return message("plant.changed.model.accepted", **of, person=accepted_by)
    if before is None:
        return message("plant.changed.model.first", **of)
    of |= {"number_before": before.record_id, "day_before": before.measured_on}
    return message("plant.changed.model.replaced", **of)


@dataclass(frozen=True, slots=True)
class CertificateEnded:
    """A certificate that ended, and what that concerns."""

    stated: CertificateRecord
    sentence: Message


def certificates_ended(
    papers: Iterable[CertificateRecord], robots: Iterable[RobotMeasured], since: date, today: date
) -> list[CertificateEnded]:
    """Return the certificates that count and ended since a day, the first to end first."""
    measured = Counter(robot.instrument_serial_number for robot in robots)
    ended = [one for one in papers if since.isoformat() <= one.paper.expires < today.isoformat()]
    return [
        CertificateEnded(one, _ended(one.paper, measured[one.paper.serial_number]))
        for one in sorted(ended, key=lambda one: one.paper.expires)
    ]


def _ended(paper: Paper, robots: int) -> Message:
    of: dict[str, Value] = {"certificate": paper.certificate, "of": paper.of, "expires": paper.expires}
    if not paper.serial_number:
        return message("plant.changed.certificate.unnumbered", **of)
    return message("plant.changed.certificate", **of, serial=paper.serial_number, robots=robots)
