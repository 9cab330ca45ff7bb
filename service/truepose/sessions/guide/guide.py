"""A session that runs by itself as those see it who ask: where it stands, what may be pressed. Pure."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, cast

from truepose.analysis.campaigns.tracker import MeasuredSession
from truepose.analysis.job_queue.accuracy_tasks import OutlookTask, SessionForecast
from truepose.analysis.job_queue.supervisor import Perform, Turns
from truepose.domain.contacts import ContactPlan
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.session import IdentityTaken, Progress, SessionPlan, SessionState, config_of, stop_id
from truepose.messages.message import Text
from truepose.sessions.contact.state import OPEN, ContactRecord, Open, Question, Visit
from truepose.sessions.contact.state import situation_of as contact_situation
from truepose.sessions.engine.commands import CommandName
from truepose.sessions.engine.states import after_restart
from truepose.sessions.service import Attendance
from truepose.sessions.tracker.revisions import can_be_skipped, newest_stop
from truepose.sessions.tracker.state import TrackerRecord, situation_of
from truepose.sessions.tracker.steps import StepKind
from truepose.storage.records import SessionSetup

Plan: TypeAlias = SessionPlan | ContactPlan
Kind: TypeAlias = Literal["tracker", "camera", "contacts"]
StepName: TypeAlias = Literal["instruments", "warm-up", "world-frame", "fixed-nests", "stop", "question"]

_ALWAYS: Final = frozenset({CommandName.ABORT})
_BY_STATE: Final = {
    SessionState.PLANNED: frozenset({CommandName.START, CommandName.ABORT}),
    SessionState.RUNNING: frozenset({CommandName.PAUSE, CommandName.STOP, *_ALWAYS}),
    SessionState.PAUSING: frozenset({CommandName.STOP, *_ALWAYS}),
    SessionState.PAUSED: frozenset({CommandName.RESUME, *_ALWAYS}),
    SessionState.AWAITING_CONFIRMATION: frozenset({CommandName.CONFIRM, *_ALWAYS}),
}


@dataclass(frozen=True, slots=True)
class Fixed:
    """What of a session changes only by configurations that are added."""

    name: str
    role: str
    setup: SessionSetup
    plan: Plan

    @property
    def kind(self) -> Kind:
        """What measures in it."""
        if isinstance(self.plan, ContactPlan):
            return "contacts"
        return "tracker" if self.plan.measures == "points" else "camera"


@dataclass(frozen=True, slots=True)
class GuideStep:
    """What is due now."""

    id: str
    kind: StepName
    config: int | None = None
    nest: int | None = None


@dataclass(frozen=True, slots=True)
class LastStop:
    """How the newest configuration ended."""

    config: int
    measured: bool
    text: Text  # why it was not
    number: int  # of lines that ended one, this one included: two of the same configuration differ


@dataclass(frozen=True, slots=True)
class SessionStatus:
    """Where a session stands, by its plan and its ledger alone."""

    state: SessionState
    reason: Text
    step: GuideStep | None
    progress: Progress
    acts: frozenset[CommandName]
    last: LastStop | None
    identities: tuple[IdentityTaken, ...]


@dataclass(frozen=True, slots=True)
class Guide:
    """A session as it stands now."""

    id: int
    fixed: Fixed
    standing: SessionStatus
    attendance: Attendance
    tracker_in_question: IdentityTaken | None = None


def standing(fixed: Fixed, entries: Iterable[LedgerEntry], *, runs: bool) -> SessionStatus:
    """Return where a session stands after these lines; `runs`: a program does what is due."""
    record = TrackerRecord if isinstance(fixed.plan, SessionPlan) else ContactRecord
    return standing_of(fixed, record.of(entries), runs=runs)


def standing_of(fixed: Fixed, record: TrackerRecord | ContactRecord, *, runs: bool) -> SessionStatus:
    """Return where a session stands after what is on record."""
    step, progress, acts = _found(fixed, record)
    # A ledger that ends in "running" is of a service that was killed: nobody runs the session, and no page
    # may say so.
    state = record.state if runs else after_restart(record.state)
    allowed = _BY_STATE.get(state, frozenset())
    return SessionStatus(
        state=state,
        reason=record.reason,
        step=step,
        progress=progress,
        acts=allowed | acts if runs and state in _REVISED_IN else allowed,
        last=_last(record),
        identities=tuple(record.identities),
    )


_REVISED_IN: Final = frozenset({
    SessionState.RUNNING, SessionState.PAUSING, SessionState.PAUSED, SessionState.AWAITING_CONFIRMATION,
})  # fmt: skip
_Found: TypeAlias = tuple[GuideStep | None, Progress, frozenset[CommandName]]


def _found(fixed: Fixed, record: TrackerRecord | ContactRecord) -> _Found:
    match fixed.plan, record:
        case SessionPlan() as plan, TrackerRecord() as of_tracker:
            return _of_tracker(plan, len(fixed.setup.cell.fixed_nests), of_tracker)
        case ContactPlan() as contact_plan, ContactRecord() as of_contacts:
            return _of_contacts(contact_plan, of_contacts)
    raise TypeError("the plan and the record are from different kinds of session")


def _of_tracker(plan: SessionPlan, n_fixed_nests: int, record: TrackerRecord) -> _Found:
    found = situation_of(plan, n_fixed_nests, record)
    acts = set()
    if can_be_skipped(found.step):
        acts.add(CommandName.SKIP)
    if newest_stop(record) is not None:
        acts.add(CommandName.RETRY)
    # Devices are opened by the session itself whenever that is needed.
    if record.ended and record.ended[-1] != StepKind.OPEN:
        acts.add(CommandName.BACK)
    step = found.step
    if step is None:
        return None, found.progress, frozenset(acts)
    config, nest = (None, None) if step.stop is None else (step.stop.config, step.stop.nest)
    shown = GuideStep(step.id, step.kind.value, config, nest)
    return shown, found.progress, frozenset(acts)


def _of_contacts(plan: ContactPlan, record: ContactRecord) -> _Found:
    found = contact_situation(plan, record)
    match found.step:
        case Visit(stop):
            step = GuideStep(stop_id(stop.config), "stop", stop.config, plan.nest)
        case Open():
            step = GuideStep(OPEN, "instruments")
        case Question() as question:
            step = GuideStep(question.value, "question")
        case None:
            return None, found.progress, frozenset()
    return step, found.progress, frozenset()


def _last(record: TrackerRecord | ContactRecord) -> LastStop | None:
    line = record.last_end
    config = None if line is None else config_of(line.step_id)
    if line is None or config is None:
        return None
    return LastStop(config, line.kind is EntryKind.MEASURED, line.text, record.ends)


FEWEST: Final = 11  # configurations; fewer identify nothing that a promise could rest on
_WAITING: Final = 3
_PATIENCE_S: Final = 60.0
_REMEMBERED: Final = 8  # sessions
_Basis: TypeAlias = tuple[tuple[float, ...], int]  # times of the readings, configurations that are left


class Outlooks:
    """Keeps the newest one of each of the sessions that were asked about last."""

    def __init__(self, perform: Perform) -> None:
        self._perform = perform
        self._turns = Turns(at_once=1, waiting=_WAITING, patience_s=_PATIENCE_S)
        self._known: dict[int, tuple[_Basis, SessionForecast]] = {}  # by session

    async def of(self, session: MeasuredSession, left: int) -> SessionForecast | None:
        """Return what a session promises, None before enough is measured; raises TrueposeError, BusyError."""
        if len(session.points) < FEWEST:
            return None
        basis = _basis(session, left)
        async with self._turns.taken():
            # Looked up with the place taken: of two tablets that ask at once the second finds what the first
            # had computed.
            known = self._known.get(session.id)
            if known is not None and known[0] == basis:
                return known[1]
            found = cast(SessionForecast, await self._perform(OutlookTask(session, left), _nobody))
            self._known.pop(session.id, None)
            self._known[session.id] = basis, found  # comes last
            for forgotten in [*self._known][:-_REMEMBERED]:
                del self._known[forgotten]
            return found


def _basis(session: MeasuredSession, left: int) -> _Basis:
    """Return what tells whether an outlook still holds."""
    # The times and not the number of readings: one that is taken again leaves as many as before.
    of_points = (point.time_s for point in session.points)
    return (*of_points, *(taken.time_s for taken in session.fixed_nests)), left


async def _nobody(fraction: float, doing: Text) -> None:
    """Take progress that nobody follows."""
