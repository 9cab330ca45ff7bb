"""The questions and the present state of a contact session: a pure function of its plan and its ledger.

The present step is the first that is due: fixture bolted, gauges zeroed, devices ready, cell clear, then the
next stop that was neither measured nor skipped.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final, TypeAlias

from truepose.domain.contacts import ContactPlan, ContactStop, Loop, Target, TargetKind
from truepose.domain.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.session import Progress, SessionState, config_of, stop_id
from truepose.messages.message import Message, Text, message, together
from truepose.sessions.engine.progress import FINISHED, WAITS, Record
from truepose.sessions.engine.prompts import CELL_CLEAR
from truepose.sessions.engine.states import ASKS
from truepose.sessions.engine.unattended import RunsByItself


class Question(StrEnum):
    """One thing that a person does, or looks at; the name of its step."""

    FIXTURE = "fixture"
    ZERO = "zero"
    CLEAR = "clear"


_FIXED: Final[dict[Loop, str]] = {
    "probe": "session.fixture.probe",
    "gauges": "session.fixture.gauges",
    "wires": "session.fixture.wires",
    "sensor": "session.fixture.sensor",
}
_ZEROED: Final[dict[Loop, Message]] = {
    "probe": message("session.zero.probe"),
    "gauges": message("session.zero.gauges"),
    "wires": message("session.zero.wires"),
    "sensor": message("session.zero.sensor"),
}
_THING: Final[dict[TargetKind, Message]] = {
    TargetKind.SPHERE: message("session.thing.sphere"),
    TargetKind.PLANE: message("session.thing.plane"),
    TargetKind.GAUGE: message("session.thing.gauge"),
    TargetKind.WIRE: message("session.thing.drum"),
    TargetKind.BALL: message("session.thing.ball"),
}


def open_prompt(question: Question, plan: ContactPlan) -> Text:
    """Return what is asked."""
    match question:
        case Question.FIXTURE:
            return message(_FIXED[plan.loop], places=tuple(map(_place, plan.targets)))
        case Question.ZERO:
            return _ZEROED[plan.loop]
        case Question.CLEAR:
            way = message("session.way.slow" if plan.touches else "session.way.wires")
            return together(way, CELL_CLEAR)


def _place(target: Target) -> Message:
    thing, number = _THING[target.kind], target.number
    if target.place_mm is None:
        return message("session.place.on_paper", thing=thing, number=number)
    x_mm, y_mm, z_mm = target.place_mm
    return message("session.place", thing=thing, number=number, x_mm=x_mm, y_mm=y_mm, z_mm=z_mm)


OPEN: Final = "open"  # the step that makes the devices ready


class _Timed(StrEnum):
    """Under which the times of steps are kept."""

    STOPS = "stops"


@dataclass(slots=True)
class ContactRecord(Record):
    """The ledger of a session of closed loops so far."""

    doing: Text = WAITS
    answered: set[Question] = field(default_factory=set)
    opened: bool = False  # the devices are ready, since the program last began
    measured: set[int] = field(default_factory=set)  # configurations
    skipped: set[int] = field(default_factory=set)
    failures: int = 0  # in a row
    _asked: Question = Question.FIXTURE  # the question that is open, or was last

    def take(self, entry: LedgerEntry) -> None:
        """Take what a line says of the steps of the session."""
        match entry.kind:
            case EntryKind.BEGUN:
                self.doing = entry.text
            case EntryKind.MEASURED | EntryKind.SKIPPED:
                self._end_stop(entry)
            case EntryKind.ENDED if entry.step_id == OPEN:
                self.opened = True
            case EntryKind.REOPENED if entry.step_id == OPEN:
                self.opened = False
            case EntryKind.CONTROL:
                self._control(entry)
            case _:
                pass

    def enter(self, state: SessionState, reason: Text) -> None:
        """Enter a state."""
        self.state, self.reason = state, reason
        if state is SessionState.FINISHED:
            self.doing = FINISHED

    @property
    def stop_s(self) -> float | None:
        """How long a stop takes at the pace so far [s]; None before the first."""
        return self.times.median_s([_Timed.STOPS])

    def _end_stop(self, entry: LedgerEntry) -> None:
        config = config_of(entry.step_id)
        if config is None:
            return
        is_measured = entry.kind is EntryKind.MEASURED
        (self.measured if is_measured else self.skipped).add(config)
        self.failures = 0 if is_measured else self.failures + 1
        self.times.end_step(_Timed.STOPS)

    def _control(self, entry: LedgerEntry) -> None:
        if entry.control is Control.RESTARTED:
            self.opened = False
        if entry.entered in ASKS:
            # Whatever the session waits for, the cell is looked at before anything moves again.
            self.answered.discard(Question.CLEAR)
            # A halt names the stop at which it came; what it asks is whether the cell is clear.
            named = entry.step_id in set(Question)
            self._asked = Question(entry.step_id) if named else Question.CLEAR
        if entry.entered is SessionState.RUNNING:
            self.answered.add(self._asked)
            self.failures = 0


_OPENING: Final = message("session.doing.open_devices")


@dataclass(frozen=True, slots=True)
class Open:
    """Connect the devices, ask them who they are, set the robot's speed."""

    id: str = OPEN
    title: Text = _OPENING


@dataclass(frozen=True, slots=True)
class Visit:
    """Go to a stop, read the gauges, come back."""

    stop: ContactStop

    @property
    def id(self) -> str:
        """Its name in the ledger."""
        return stop_id(self.stop.config)

    @property
    def title(self) -> Text:
        """What the operator reads."""
        return message("session.doing.measure", config=self.stop.config)


Step: TypeAlias = Question | Open | Visit


@dataclass(frozen=True, slots=True)
class ContactSituation(RunsByItself):
    """Where a session stands."""

    step: Step | None  # the present one; None: nothing is left to do
    left: tuple[ContactStop, ...]  # neither measured nor skipped
    failures: int

    @property
    def leads_to(self) -> tuple[int, ...]:
        """Configurations to which the arm may go once the question is answered."""
        by_hand = isinstance(self.step, Question) and self.step is not Question.CLEAR
        return () if by_hand else tuple(stop.config for stop in self.left)


def situation(plan: ContactPlan, entries: Iterable[LedgerEntry]) -> ContactSituation:
    """Return where a session stands after these lines of its ledger, oldest first."""
    return situation_of(plan, ContactRecord.of(entries))


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
    # What is done by hand comes before the devices are opened: whoever bolts a fixture is in the cell.
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
