"""What the ledger amounts to, line by line: which steps are done, what is attached, who acts, what is open.

Lines are applied one after the other; no line is ever taken back. What counts no more is REOPENED:

- of an initialisation, it takes along the readings of its group, whose zero it was;
- of a motion, everything done at that stop: the arm does not come to rest twice at the same place;
- of the step at which a pose was skipped, the skip.

The ballbar counts as attached from the moment a person was asked to attach it, until a person has
confirmed that it is off.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final, Literal, TypeAlias

from truepose.domain.ballbar import ArrivalTaken, LengthTaken, PreCalibration, StepKind, Suspicion
from truepose.domain.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.session import SessionState
from truepose.messages.message import Text
from truepose.sessions.ballbar import step_ids
from truepose.sessions.engine.progress import ActingTablet, Record

OutcomeKind: TypeAlias = Literal["open", "confirmed", "measured", "moved", "skipped", "computed"]

NEEDS_BALLBAR_OFF: Final = frozenset({StepKind.DETACH, StepKind.MOVE})
READINGS: Final = frozenset({StepKind.INITIALISE, StepKind.MEASURE_SIDE, StepKind.CONNECT_LEG})
_IN_VAIN: Final = 2  # answers of one kind after which another reading would only ask again
_ENDS: Final[dict[EntryKind, OutcomeKind]] = {
    EntryKind.CONFIRMED: "confirmed",
    EntryKind.MEASURED: "measured",
    EntryKind.MOVED: "moved",
    EntryKind.SKIPPED: "skipped",
    EntryKind.COMPUTED: "computed",
}


class Answer(StrEnum):
    """Answer of a person to a suspicion."""

    RIGHT_PAIR = "right_pair"  # the reading is stored, with the doubt kept beside it
    RECONNECTED = "reconnected"  # it is read again
    EXCHANGED = "exchanged"  # both legs are read again


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a step stands."""

    kind: OutcomeKind = "open"
    length: LengthTaken | None = None
    text: Text = ""
    arrival: ArrivalTaken | None = None


@dataclass(frozen=True, slots=True)
class OpenSuspicion:
    """A reading that was not stored, because it contradicts what was asked for."""

    step_id: str
    suspicion: Suspicion
    length: LengthTaken
    answered: int = 0  # times that a person has put the ballbar on anew for a doubt of this kind

    @property
    def main_answer(self) -> Answer:
        """The answer that is offered first: to read again, unless that tells nothing or has led nowhere."""
        leads_nowhere = self.suspicion.kind == "like_calibrator" or self.answered >= _IN_VAIN
        return Answer.RIGHT_PAIR if leads_nowhere else Answer.RECONNECTED


@dataclass(frozen=True, slots=True)
class _PoseSkip:
    step_id: str  # where the person skipped
    reason: Text
    ballbar_stays: bool  # it was attached: taking it off is still to be done


@dataclass(slots=True)
class BallbarRecord(Record):
    """The ledger of a ballbar session so far."""

    attached: bool = False
    exchanged: bool = False  # another ballbar may answer than the one that may be attached
    ball_fitted: bool = False
    arm_at: str | None = None  # the motion that brought the arm where it stands; None: not known
    last_stop: str | None = None  # the motion that ended last, wherever the arm is now
    begun: tuple[str, ...] = ()  # the motions that a person has let begin since then
    arrival: ArrivalTaken | None = None
    shown: str | None = None  # the step whose prompt was shown since anything else happened
    confirmed: str | None = None  # the motion that a person has just allowed
    suspicion: OpenSuspicion | None = None
    # By step: doubts for which the ballbar was put on anew, oldest first.
    answered: dict[str, tuple[OpenSuspicion, ...]] = field(default_factory=dict)
    initialisations: int = 0
    zeros: dict[str, LengthTaken] = field(
        default_factory=dict
    )  # group of readings -> its last initialisation
    last_zero: tuple[str, LengthTaken] | None = None  # by step, whatever became of it
    zero_lost: bool = False  # the ballbar was without supply since, or is another one
    found: dict[str, PreCalibration | None] = field(default_factory=dict)  # by step; None: left out
    stood_at: dict[str, str | None] = field(default_factory=dict)  # pre-calibration -> last stop by then
    last: tuple[str, Outcome] | None = None
    _outcomes: dict[str, Outcome] = field(default_factory=dict)
    _skips: dict[str, _PoseSkip] = field(default_factory=dict)

    def take(self, entry: LedgerEntry) -> None:
        """Take what a line says of the steps of the session."""
        self._note_person(entry)
        match entry.kind:
            case EntryKind.SHOWN:
                self._show(entry)
            case EntryKind.CONTROL:
                self._control(entry)
            case EntryKind.SUSPECTED:
                self._suspect(entry)
            case EntryKind.ANSWERED:
                self._answer()
            case EntryKind.REOPENED:
                self._reopen(entry.step_id)
            case _:
                self._end(entry)

    def enter(self, state: SessionState, reason: Text) -> None:
        """Enter a state; whatever was shown or confirmed before counts no more."""
        self.state, self.reason = state, reason
        self.shown = None
        self.confirmed = None

    def outcome(self, step_id: str) -> Outcome:
        """Return how a step stands."""
        own = self._outcomes.get(step_id)
        if own is not None:
            return own
        skip = self._skips.get(step_ids.group_of(step_id))
        # A pose that is skipped with the bar on still has it taken off.
        if skip is None or (skip.ballbar_stays and step_ids.kind_of(step_id) is StepKind.DETACH):
            return Outcome()
        return Outcome("skipped", text=skip.reason)

    def skipped_at(self, step_id: str) -> str:
        """Return the step at which a person skipped what this step belongs to."""
        skip = self._skips.get(step_ids.group_of(step_id))
        return step_id if skip is None else skip.step_id

    @property
    def skipped_poses(self) -> frozenset[str]:
        """Groups of the attempts at poses that ended with a skip."""
        return frozenset(self._skips)

    @property
    def precalibration(self) -> PreCalibration | None:
        """What the last pre-calibration found; None before the first."""
        return next((found for found in reversed(self.found.values()) if found is not None), None)

    def _note_person(self, entry: LedgerEntry) -> None:
        """Follow who holds the tablet that acts; a tablet comes to act by a CONTROL line only."""
        if self.acting is not None and entry.tablet == self.acting.tablet and entry.person:
            self.acting = ActingTablet(self.acting.tablet, entry.person)

    def _show(self, entry: LedgerEntry) -> None:
        self.shown = entry.step_id
        self.confirmed = None
        # From the prompt on, not from the first signal: a bar with an empty battery hangs between the balls
        # all the same (decision 0016).
        if step_ids.kind_of(entry.step_id) in READINGS:
            self.attached = True

    def _control(self, entry: LedgerEntry) -> None:
        # The first tablet that acts has the session; another one takes it over in an act of its own.
        if entry.tablet is not None and (self.acting is None or entry.control is Control.HAND_OVER):
            self.acting = ActingTablet(entry.tablet, entry.person or "")
        if entry.control is Control.ZERO_LOST:
            self._lose_zero()
        taken = entry.identity
        if taken is None or taken.device != "ballbar":
            return
        # Before the first calibrator there is no zero to lose.
        if self.initialisations:
            self._lose_zero()  # whoever comes, goes or falls silent has a zero of its own
        # Another bar that answers now says nothing of the one that may still hang between the balls.
        self.exchanged |= self.attached and taken.finding in {"accepted", "silent"}

    def _lose_zero(self) -> None:
        self.zero_lost, self.last_zero, self.shown = True, None, None

    def _suspect(self, entry: LedgerEntry) -> None:
        if entry.suspicion is not None and entry.length is not None:
            before = self.answered.get(entry.step_id, ())
            answered = sum(doubt.suspicion.kind == entry.suspicion.kind for doubt in before)
            self.suspicion = OpenSuspicion(entry.step_id, entry.suspicion, entry.length, answered)

    def _answer(self) -> None:
        if self.suspicion is not None:
            step_id = self.suspicion.step_id
            self.answered[step_id] = (*self.answered.get(step_id, ()), self.suspicion)
        self.suspicion = None
        self.shown = None

    def _reopen(self, step_id: str) -> None:
        group, kind = step_ids.group_of(step_id), step_ids.kind_of(step_id)
        self._outcomes.pop(step_id, None)
        skip = self._skips.get(group)
        if kind is StepKind.MOVE or (skip is not None and skip.step_id == step_id):
            self._skips.pop(group, None)
        # The arm does not come to rest twice at the same place: six legs of a pose share one arrival, and
        # 0.0035 mm of scatter between arrivals is seven times a reading's (decision 0016).
        if kind is StepKind.MOVE:
            self._drop(group, frozenset(StepKind))
            self.zeros.pop(group, None)
        if kind is StepKind.INITIALISE:
            self._drop(group, READINGS)
            self.zeros.pop(group, None)
        if kind is StepKind.DETACH:
            self.attached = True
        doubted = self.suspicion is not None and step_ids.group_of(self.suspicion.step_id) == group
        if doubted and kind in {StepKind.MOVE, StepKind.INITIALISE}:
            self.suspicion = None  # the reading in doubt was of that stop, or counted from that zero
        self.shown = None
        self.confirmed = None

    def _drop(self, group: str, kinds: frozenset[StepKind]) -> None:
        for step_id in [*self._outcomes]:
            if step_ids.group_of(step_id) == group and step_ids.kind_of(step_id) in kinds:
                del self._outcomes[step_id]

    def _end(self, entry: LedgerEntry) -> None:
        """Take a line that ends its step, or allows the motion of one."""
        step_id, kind = entry.step_id, step_ids.kind_of(entry.step_id)
        self.shown = None
        if self.suspicion is not None and self.suspicion.step_id == step_id:
            self.suspicion = None
        # From here on nobody knows where the arm is, until its arrival is on record.
        if entry.kind is EntryKind.CONFIRMED and kind is StepKind.MOVE:
            self.confirmed = step_id
            self.begun = (*self.begun, step_id)
            self.arm_at = self.arrival = None
            return
        self.times.end_step(kind)
        self.confirmed = None
        outcome = Outcome(_ENDS[entry.kind], entry.length, entry.text, entry.arrival)
        self.last = step_id, outcome
        if entry.kind is EntryKind.SKIPPED and step_ids.is_of_a_pose(step_id):
            listed = step_ids.listed_step(step_id)
            self._skips[step_ids.group_of(listed)] = _PoseSkip(listed, entry.text, self.attached)
            return
        self._outcomes[step_id] = outcome
        self._note_consequences(entry, kind)

    def _note_consequences(self, entry: LedgerEntry, kind: StepKind | None) -> None:
        match kind:
            case StepKind.DETACH:
                self.attached = self.exchanged = False
            case StepKind.FIT_BALL:
                self.ball_fitted = True
            case StepKind.REMOVE_BALL:
                self.ball_fitted = False
            case StepKind.MOVE:
                self.arm_at = self.last_stop = entry.step_id
                self.arrival, self.begun = entry.arrival, ()
            case StepKind.INITIALISE if entry.length is not None:
                self.initialisations = entry.length.initialisation
                self.zeros[step_ids.group_with_zero(entry.step_id)] = entry.length
                self.last_zero = entry.step_id, entry.length
                self.zero_lost = False
            case StepKind.PRECALIBRATE:
                self.found[entry.step_id] = entry.precalibration
                if entry.precalibration is not None:
                    self.stood_at[entry.step_id] = self.last_stop
            case _:
                pass


def leaves_attached(entries: Iterable[LedgerEntry]) -> bool | None:
    """Return whether a session leaves the ballbar attached, as far as known; None where it tells nothing."""
    record, told = BallbarRecord(), False
    for entry in entries:
        record.apply(entry)
        told |= entry.kind is EntryKind.CONFIRMED and step_ids.kind_of(entry.step_id) in NEEDS_BALLBAR_OFF
    return True if record.attached else False if told else None
