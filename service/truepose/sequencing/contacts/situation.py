"""The present situation of a session of closed loops: a pure function of its plan and its ledger.

The present step is the first that is due: fixture bolted, gauges zeroed, devices ready, cell clear, then the
next stop that was neither measured nor skipped.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

from truepose.domain.measurement.contacts import ContactPlan, ContactStop
from truepose.domain.measurement.ledger import LedgerEntry
from truepose.domain.measurement.session import Progress, stop_id
from truepose.sequencing.contacts.questions import Question
from truepose.sequencing.contacts.record import OPEN, ContactRecord
from truepose.sequencing.engine.by_itself import RunsByItself


@dataclass(frozen=True, slots=True)
class Open:
    """Connect the devices, ask them who they are, set the robot's speed."""

    id: str = OPEN
    title: str = "opening the devices"


@dataclass(frozen=True, slots=True)
class Visit:
    """Go to a stop, read the gauges, come back."""

    stop: ContactStop

    @property
    def id(self) -> str:
        """Its name in the ledger."""
        return stop_id(self.stop.config)

    @property
    def title(self) -> str:
        """What the operator reads."""
        return f"measuring configuration {self.stop.config}"


Step: TypeAlias = Question | Open | Visit


@dataclass(frozen=True, slots=True)
class ContactSituation(RunsByItself):
    """Where a session stands."""

    step: Step | None  # the present one; None: nothing is left to do
    left: tuple[ContactStop, ...]  # neither measured nor skipped
    failures: int
    progress: Progress


def situation(plan: ContactPlan, entries: Iterable[LedgerEntry]) -> ContactSituation:
    """Return where a session stands after these lines of its ledger, oldest first."""
    record = ContactRecord()
    for entry in entries:
        record.apply(entry)
    return situation_of(plan, record)


def situation_of(plan: ContactPlan, record: ContactRecord) -> ContactSituation:
    """Return where a session stands after what is on record."""
    ended = record.measured | record.skipped
    left = tuple(stop for stop in plan.stops if stop.config not in ended)
    each_s = record.stop_s
    return ContactSituation(
        state=record.state,
        reason=record.reason,
        step=present_step(record, left),
        left=left,
        failures=record.failures,
        progress=Progress(
            done=len(record.measured),
            skipped=len(record.skipped),
            planned=len(plan.stops),
            elapsed_s=record.times.elapsed_s,
            remaining_s=None if each_s is None else each_s * len(left),
            doing=record.doing,
        ),
    )


def present_step(record: ContactRecord, left: tuple[ContactStop, ...]) -> Step | None:
    """Return what is due now; None: nothing is."""
    if not left:
        return None
    for question in (Question.FIXTURE, Question.ZERO):
        if question not in record.answered:
            return question
    if not record.opened:
        return Open()
    return Visit(left[0]) if Question.CLEAR in record.answered else Question.CLEAR


def steps(plan: ContactPlan) -> Iterator[Step]:
    """Yield all steps of a session that nothing disturbs."""
    yield from (Question.FIXTURE, Question.ZERO, Open(), Question.CLEAR)
    yield from map(Visit, plan.stops)
