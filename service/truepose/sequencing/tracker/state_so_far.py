"""What the ledger of a tracker session amounts to, line by line.

What counts no more is REOPENED: of the instruments, that they are ready and that the fixed nests were in
their place; of the world frame, the registration, which stays as a guess of where the nests are.
"""

from collections import Counter
from dataclasses import dataclass, field

from truepose.domain.measurement.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.measurement.session import FixedNestTaken, Registration, SessionState, config_of
from truepose.sequencing.engine.state_so_far import Record
from truepose.sequencing.tracker.measuring.groups import Groups
from truepose.sequencing.tracker.plan.steps import StepKind


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
    warming: list[FixedNestTaken] = field(default_factory=list)  # readings that tell how fast it drifts
    warm_enough: bool = False  # a person said so
    left_out: set[int] = field(default_factory=set)  # configurations of which a person wants no reading
    reopened: set[int] = field(default_factory=set)  # configurations that somebody wanted once more
    ended: list[str] = field(default_factory=list)  # steps that were done, newest last, as long as they count
    _asked: frozenset[int] = frozenset()  # configurations that the open question is about
    _seen_s: float | None = None  # the last line since the first reading

    def take(self, entry: LedgerEntry) -> None:
        """Take what a line says of the steps of the session."""
        self._pass_time(entry)
        match entry.kind:
            case EntryKind.BEGUN:
                self.doing = entry.text
            case EntryKind.READ if entry.step_id == StepKind.WARM and entry.fixed_nest is not None:
                self.warming.append(entry.fixed_nest)
            case EntryKind.SKIPPED if entry.key is not None:
                self._leave_out(entry.step_id)
            case EntryKind.MEASURED | EntryKind.SKIPPED:
                self._end_stop(entry)
            case EntryKind.COMPUTED:
                self.registration = entry.registration
                self._end(StepKind.REGISTER, StepKind.REGISTER)
            case EntryKind.ENDED:
                self._end(StepKind(entry.step_id), entry.step_id)
            case EntryKind.REOPENED:
                self._reopen(entry.step_id)
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
        if config is None or config in self.left_out:
            return
        is_measured = entry.kind is EntryKind.MEASURED
        now, before = (self.measured, self.skipped) if is_measured else (self.skipped, self.measured)
        now.add(config)
        before.discard(config)
        self.measured_lately |= is_measured
        if entry.point is not None:
            self.groups.take(entry.point)
        self.failures = 0 if is_measured else self.failures + 1
        self._end(StepKind.MEASURE, entry.step_id)

    def _leave_out(self, step_id: str) -> None:
        """Take that a person wants none of a configuration, or no further warm-up."""
        config = config_of(step_id)
        if config is None:
            self.warm_enough = True
            return
        self.left_out.add(config)
        self.skipped.add(config)
        self.measured.discard(config)

    def _end(self, kind: StepKind, step_id: str) -> None:
        self.end(kind)
        self.ended.append(step_id)

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

    def _reopen(self, step_id: str) -> None:
        self.ended = [ended for ended in self.ended if ended != step_id]
        config = config_of(step_id)
        if config is not None:
            self._want_again(config)
            return
        kind = StepKind(step_id)
        self.looked = False
        if kind is StepKind.WARM:
            self.warming.clear()
            self.warm_enough = self.registered = False
        if kind is StepKind.OPEN:
            self.opened = False
        if kind is StepKind.REGISTER:
            self.registered = False

    def _want_again(self, config: int) -> None:
        """Take that a configuration is to be measured; to go there a person has to let the arm."""
        self.reopened.add(config)
        for known in (self.measured, self.skipped, self.left_out, self.allowed):
            known.discard(config)

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
