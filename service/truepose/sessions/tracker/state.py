"""The present state of a tracker session: a pure function of its plan and its ledger.

What counts no more is REOPENED: of the instruments, that they are ready and that the fixed nests were in
their place; of the world frame, the registration, which stays as a guess of where the nests are.

The present step is the first that is due: instruments that are ready, a tracker whose place in the world is
known, fixed nests that were looked at lately, then the next stop that was neither measured nor skipped.
"""

import math
from collections import Counter, deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from truepose.domain.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.session import (
    FixedNestTaken,
    PlannedStop,
    PointTaken,
    Progress,
    Registration,
    SessionPlan,
    SessionState,
    config_of,
)
from truepose.messages.message import Text
from truepose.sessions.engine.identity_check import KnownDevice, same_number
from truepose.sessions.engine.progress import FINISHED, WAITS, Record
from truepose.sessions.engine.unattended import RunsByItself
from truepose.sessions.tracker import steps as plans
from truepose.sessions.tracker.steps import Step, StepKind
from truepose.sessions.tracker.warm_up import warmth
from truepose.validation.iso9283.drift import has_settled


@dataclass(slots=True)
class Groups:
    """The readings of each group."""

    _taken: dict[int, list[PointTaken]] = field(default_factory=dict)

    def take(self, point: PointTaken) -> None:
        """Count a reading; one that is in no group is none of this."""
        if point.group is not None:
            self._taken.setdefault(point.group, []).append(point)

    def settled_before(self, group: int) -> bool:
        """Whether drift had become slow by the groups before this one."""
        before = [self._taken[number] for number in sorted(self._taken) if number < group]
        if not before:
            return False
        times = np.array([np.mean([point.time_s for point in points]) for points in before])
        return has_settled(
            times, [np.array([point.position_world_mm for point in points]) for points in before]
        )


@dataclass(slots=True)
class TrackerRecord(Record):
    """The ledger of a tracker session so far."""

    doing: Text = WAITS
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
            # With a key a person left it out; without one the session did, after a reading that failed.
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

    def enter(self, state: SessionState, reason: Text) -> None:
        """Enter a state."""
        self.state, self.reason = state, reason
        if state is SessionState.FINISHED:
            self.doing = FINISHED

    def _end_stop(self, entry: LedgerEntry) -> None:
        config = config_of(entry.step_id)
        # A reading that was under way when a person left its configuration out does not count either
        # (decision 0059).
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
                # A registration is confirmed by a look before the arm goes anywhere.
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
        # Whatever is reopened, the fixed nests are looked at again: instruments were opened, or a tracker may
        # stand elsewhere.
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
        # Also what a person has let the arm go to: whoever taps a row of a table looks at a table (decision
        # 0059).
        for known in (self.measured, self.skipped, self.left_out, self.allowed):
            known.discard(config)

    def _control(self, entry: LedgerEntry) -> None:
        if entry.control is Control.RESTARTED:
            # Devices belong to a process: a new one has to open them.
            self.opened = self.looked = False
        match entry.entered:
            case SessionState.RUNNING:
                # What was asked about and no more: stops that were added while the question was open are a
                # question of their own.
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


@dataclass(frozen=True, slots=True)
class TrackerSituation(RunsByItself):
    """Where a session stands."""

    step: Step | None  # the present one; None: nothing is left to do
    left: tuple[PlannedStop, ...]  # neither measured nor skipped
    unasked: tuple[PlannedStop, ...]  # of them: those to which nobody has let the arm go
    registration: Registration | None  # the tracker's place in the world, where it holds
    last_known: Registration | None  # or where it stood before
    measured_lately: bool
    failures: int
    paused_before: bool  # the present step made the session pause once
    interruptions: int  # of the present step
    since_first_s: float  # cell time from the first reading to the last line
    settled: bool  # what is left was left out, since drift has become slow

    @property
    def leads_to(self) -> tuple[int, ...]:
        """Configurations to which the arm may go once the question is answered."""
        return tuple(stop.config for stop in self.unasked)


def situation(plan: SessionPlan, n_fixed_nests: int, entries: Iterable[LedgerEntry]) -> TrackerSituation:
    """Return where a session stands after these lines of its ledger, oldest first."""
    return situation_of(plan, n_fixed_nests, TrackerRecord.of(entries))


def situation_of(plan: SessionPlan, n_fixed_nests: int, record: TrackerRecord) -> TrackerSituation:
    """Return where a session stands after what is on record."""
    ended = record.measured | record.skipped
    # What nobody has let the arm go to comes last: one question for all of it.
    open_stops = (stop for stop in plan.stops if stop.config not in ended)
    left = tuple(sorted(open_stops, key=lambda stop: stop.config not in record.allowed))
    settled = plan.ends_when_settled and _is_settled(record, left)
    if settled:
        left = ()
    step = present_step(plan, n_fixed_nests, record, left[0] if left else None)
    return TrackerSituation(
        state=record.state,
        reason=record.reason,
        step=step,
        left=left,
        unasked=tuple(stop for stop in left if stop.config not in record.allowed),
        registration=record.registration if _is_registered(record) else None,
        last_known=record.registration,
        measured_lately=record.measured_lately,
        failures=record.failures,
        paused_before=step is not None and step.id in record.paused_at,
        interruptions=0 if step is None else record.interruptions[step.id],
        progress=Progress(
            done=len(record.measured),
            skipped=len(record.skipped),
            planned=len(plan.stops),
            elapsed_s=record.times.elapsed_s,
            remaining_s=_remaining_s(plan, record, left),
            doing=record.doing,
        ),
        since_first_s=record.since_first_s,
        settled=settled,
    )


def _is_settled(record: TrackerRecord, left: Sequence[PlannedStop]) -> bool:
    following = left[0].group if left else None
    return following is not None and record.groups.settled_before(following)


def _remaining_s(plan: SessionPlan, record: TrackerRecord, left: Sequence[PlannedStop]) -> float | None:
    """Return how long the rest takes at the pace so far, and at least until the last stop is due."""
    each_s = record.times.mean_s(StepKind.MEASURE)
    if each_s is None:
        return None
    looks = math.ceil((len(left) + record.since_look) / plan.reference_every)
    looks_s = looks * (record.times.mean_s(StepKind.LOOK) or 0.0) if plan.measures == "points" else 0.0
    rest_s = each_s * len(left) + looks_s - record.times.in_step_s
    due = [stop.work.until_s - record.since_first_s for stop in left if stop.work is not None]
    return max([rest_s, 0.0, *due])


def present_step(
    plan: SessionPlan, n_fixed_nests: int, record: TrackerRecord, following: PlannedStop | None
) -> Step | None:
    """Return what is due now, where `following` is the next stop that is left; None: nothing is."""
    if not record.opened:
        return plans.opening()
    if not _is_registered(record):
        if _must_warm(plan, n_fixed_nests, record):
            return plans.warming(n_fixed_nests)
        return plans.registration(plan, n_fixed_nests)
    if plan.measures == "points" and _look_is_due(plan, record, following):
        return plans.references(n_fixed_nests)
    return None if following is None else plans.visit(plan, following)


def steps(plan: SessionPlan, n_fixed_nests: int) -> Iterator[Step]:
    """Yield all steps of a session that nothing disturbs."""
    record = TrackerRecord(allowed={stop.config for stop in plan.stops})
    left = deque(plan.stops)
    while (step := present_step(plan, n_fixed_nests, record, left[0] if left else None)) is not None:
        yield step
        if step.stop is not None:
            left.popleft()
        record.end(step.kind)
        # The listing shows one round of a warm-up: how many there will be, readings say.
        record.warm_enough |= step.kind is StepKind.WARM


def _must_warm(plan: SessionPlan, n_fixed_nests: int, record: TrackerRecord) -> bool:
    wanted = plan.warm_up and plan.measures == "points" and not record.warm_enough
    return wanted and not warmth(record.warming, plan, n_fixed_nests).ready


def _look_is_due(plan: SessionPlan, record: TrackerRecord, following: PlannedStop | None) -> bool:
    """Whether fixed nests are looked at now: first, last, every so often, and before somebody is asked."""
    if not record.looked:
        return True
    if record.since_look == 0:
        return False
    asks = following is None or following.config not in record.allowed
    return asks or record.since_look >= plan.reference_every


def _is_registered(record: TrackerRecord) -> bool:
    """Whether the registration holds, and is of the tracker that the session measures with."""
    found = record.registration
    return record.registered and (found is None or _vouches_for(record.known("tracker"), found))


def _vouches_for(tracker: KnownDevice, registration: Registration) -> bool:
    if tracker.foreign is not None:
        return False
    if registration.instrument_serial and tracker.serial:
        return same_number(registration.instrument_serial, tracker.serial)
    # Neither tells a number, so that only what a person said can tell them apart: one that was accepted since
    # is another.
    return not tracker.by_person
