"""What the ledger of a tracker session amounts to, line by line.

What counts no more is REOPENED: of the instruments, that they are ready and that the fixed nests were in
their place; of the world frame, the registration, which stays as a guess of where the nests are.
"""

from collections import Counter
from dataclasses import dataclass, field

from truepose.domain.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.session import Registration, SessionState, config_of
from truepose.sequencing.engine.state_so_far import Record
from truepose.sequencing.tracker.groups import Groups
from truepose.sequencing.tracker.steps import StepKind


@dataclass(slots=True)
class TrackerRecord(Record):
    """The ledger of a tracker session so far."""

    doing: str = "waiting for a person"
    opened: bool = False  # the instruments are ready, since the program last began
    looked: bool = False  # the fixed nests were found in their place since then
    since_look: int = 0  # stops that ended since the fixed nests were last looked at
    registered: bool = False  # the tracker's place in the world was found, and nothing speaks against it
    registration: Registration | None = None  # the last one, whatever became of it
    measured: set[int] = field(default_factory=set)  # configurations
    skipped: set[int] = field(default_factory=set)
    allowed: set[int] = field(default_factory=set)  # configurations to which a person lets the arm go
    measured_lately: bool = False  # something, since a person last had the session go on
    failures: int = 0  # in a row
    paused_at: set[str] = field(default_factory=set)  # steps that made the session pause
    interruptions: Counter[str] = field(default_factory=Counter)  # by step
    since_first_s: float = 0.0  # cell time since the first reading, off time included where the clock went on
    groups: Groups = field(default_factory=Groups)
    _asked: frozenset[int] = frozenset()  # configurations that the open question is about
    _seen_s: float | None = None  # the last line since the first reading

    def take(self, entry: LedgerEntry) -> None:
        """Take what a line says of the steps of the session."""
        self._pass_time(entry)
        match entry.kind:
            case EntryKind.BEGUN:
                self.doing = entry.text
            case EntryKind.MEASURED | EntryKind.SKIPPED:
                self._end_stop(entry)
            case EntryKind.COMPUTED:
                self.registration = entry.registration
                self.end(StepKind.REGISTER)
            case EntryKind.ENDED:
                self.end(StepKind(entry.step_id))
            case EntryKind.REOPENED:
                self._reopen(StepKind(entry.step_id))
            case EntryKind.CONTROL:
                self._control(entry)
            case _:
                pass

    def _pass_time(self, entry: LedgerEntry) -> None:
        if self._seen_s is not None:
            self.since_first_s += max(0.0, entry.time_s - self._seen_s)
        if self._seen_s is not None or entry.point is not None:
            self._seen_s = entry.time_s

    def enter(self, state: SessionState, reason: str) -> None:
        """Enter a state."""
        self.state, self.reason = state, reason
        if state is SessionState.FINISHED:
            self.doing = "finished"

    def _end_stop(self, entry: LedgerEntry) -> None:
        config = config_of(entry.step_id)
        if config is None:
            return
        is_measured = entry.kind is EntryKind.MEASURED
        (self.measured if is_measured else self.skipped).add(config)
        self.measured_lately |= is_measured
        if entry.point is not None:
            self.groups.take(entry.point)
        self.failures = 0 if is_measured else self.failures + 1
        self.end(StepKind.MEASURE)

    def end(self, kind: StepKind) -> None:
        """Take that the present step of this kind was done."""
        self.times.end_step(kind)
        match kind:
            case StepKind.OPEN:
                self.opened = True
            case StepKind.REGISTER:
                self.registered, self.looked = True, False
            case StepKind.LOOK:
                self.looked, self.since_look = True, 0
            case StepKind.MEASURE:
                self.since_look += 1

    def _reopen(self, kind: StepKind) -> None:
        self.looked = False
        if kind is StepKind.OPEN:
            self.opened = False
        if kind is StepKind.REGISTER:
            self.registered = False

    def _control(self, entry: LedgerEntry) -> None:
        if entry.control is Control.RESTARTED:
            self.opened = self.looked = False
        match entry.entered:
            case SessionState.RUNNING:
                self.allowed |= self._asked
                self.measured_lately, self.failures = False, 0
            case SessionState.AWAITING_CONFIRMATION:
                self._asked = frozenset(entry.stops)
                self.interruptions[entry.step_id] += 1
            case SessionState.PAUSED:
                self._asked = frozenset()
                self.paused_at.add(entry.step_id)
            case _:
                pass
