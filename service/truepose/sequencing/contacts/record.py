"""What the ledger of a session of closed loops amounts to, line by line."""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

from truepose.domain.measurement.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.measurement.session import SessionState, config_of
from truepose.sequencing.contacts.questions import Question
from truepose.sequencing.engine.state_so_far import Record
from truepose.sequencing.engine.states import ASKS

OPEN: Final = "open"  # the step that makes the devices ready


class _Timed(StrEnum):
    """Under which the times of steps are kept."""

    STOPS = "stops"


@dataclass(slots=True)
class ContactRecord(Record):
    """The ledger of a session of closed loops so far."""

    doing: str = "waiting for a person"
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

    def enter(self, state: SessionState, reason: str) -> None:
        """Enter a state."""
        self.state, self.reason = state, reason
        if state is SessionState.FINISHED:
            self.doing = "finished"

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
            named = entry.step_id in set(Question)
            self._asked = Question(entry.step_id) if named else Question.CLEAR
        if entry.entered is SessionState.RUNNING:
            self.answered.add(self._asked)
            self.failures = 0
