"""Runs a tracker session: takes one step after the other while nobody is in the cell.

- What a fault means is in `faults`; what is due next in `state`.
- Configurations may be added to the plan until the session has ended. They are measured after the others,
  once a person has confirmed that the cell is clear for them: whoever added them need not stand beside it.
- A pause or the end that somebody asks for takes effect between two operations, hence at the end of a motion.
- After a record was refused a person confirms before the next motion.
"""

from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from dataclasses import replace
from typing import Any, Final

from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.people import tidy_name
from truepose.domain.session import IdentityTaken, PlannedStop, SessionPlan, SessionState
from truepose.messages.message import Message, Text, message, together
from truepose.sessions.engine.commands import CommandName, CommandOutcome, OperatorCommand
from truepose.sessions.engine.ledger import Ledger, Logbook
from truepose.sessions.engine.prompts import CELL_CLEAR, require_person
from truepose.sessions.engine.runner import Onlooker
from truepose.sessions.engine.states import has_ended, words
from truepose.sessions.engine.unattended import Line, UnattendedRunner, awaits_person
from truepose.sessions.errors import NotNowError, SessionError
from truepose.sessions.tracker.cell import SessionCell
from truepose.sessions.tracker.dry_run import check_plan, first_pass, motion_limits, obstructions_ahead
from truepose.sessions.tracker.execution import Execution
from truepose.sessions.tracker.faults import lines_after
from truepose.sessions.tracker.reflector_monitor import Sighting, Watch
from truepose.sessions.tracker.revisions import REVISIONS, revision
from truepose.sessions.tracker.state import TrackerRecord, TrackerSituation, situation_of
from truepose.sessions.tracker.steps import KeepWorking, Move, Step, StepKind, extended_plan
from truepose.sessions.tracker.tracking import TrackerIdentityCheck
from truepose_drivers.errors import DriverError

_EFFECTS: Final = {
    SessionState.PAUSED: message("session.pause_requested.resume"),
    SessionState.AWAITING_CONFIRMATION: together(message("session.stopped"), CELL_CLEAR),
    SessionState.ABORTED: message("session.ended_between"),
}
_COLD: Final = message("session.cold")
_SETTLED: Final = message("session.settled")


class TrackerRunner(UnattendedRunner[TrackerSituation]):
    """One tracker session on one cell; `run` is its task, all other methods may be called from other tasks.

    `entries` are what earlier runs kept: the session goes on where they end, once a person has confirmed.
    Raises PlanRefusedError where the plan does not fit the cell.
    """

    def __init__(
        self,
        plan: SessionPlan,
        cell: SessionCell,
        ledger: Ledger,
        entries: tuple[LedgerEntry, ...] = (),
    ) -> None:
        limits = motion_limits(cell.robot, cell.joint_limits, plan)
        self._plan = plan
        self._limits = limits
        self._cell = cell
        self._record = record = TrackerRecord()

        def describe() -> TrackerSituation:
            return situation_of(self._plan, len(cell.fixed_nests), record)

        logbook = Logbook(ledger, cell.clock, record, describe, entries)
        self._check(plan, logbook.situation)
        super().__init__(logbook, cell, limits, plan.joint_tolerance_rad, _EFFECTS)
        self._identities = TrackerIdentityCheck(cell.expected, logbook)
        self._execution = Execution(plan, cell, self._arm, logbook, self._identities)
        self._watch = Watch(plan, cell, logbook, self._execution)
        # Kept from the beginning: stops that are added before anybody answers are a question of their own.
        self._first = logbook.situation.left  # what the first question is about
        self._asked = False  # in this run

    @property
    def has_asked(self) -> bool:
        """Whether this run has asked a person."""
        return self._asked

    @property
    def tracker_in_question(self) -> IdentityTaken | None:
        """Another tracker than the expected one, until a person accepts it."""
        return self._identities.tracker_in_question

    @property
    def finishes_because(self) -> Text:
        """Why the session ends where nothing is left to do."""
        return _SETTLED if self.situation.settled else super().finishes_because

    async def add_stops(self, stops: tuple[PlannedStop, ...], keep: Callable[[], Awaitable[None]]) -> None:
        """Add stops to the plan; they come last, after a person has confirmed.

        `keep` stores them; it is awaited while the session cannot end, and nothing is added where it
        raises. Raises NotNowError, PlanRefusedError.
        """
        # The session cannot end while the stops are being stored: none is on record that nobody will measure.
        async with self._logbook.changing:
            if self._ended or self._halts.wish is SessionState.ABORTED:
                raise NotNowError(message("session.refused.plan_another", state=words(self.state)))
            plan = extended_plan(self._plan, stops)
            self._check(plan, self.situation)
            await keep()
            # Only once they are on disk.
            self._plan = plan
            self._logbook.refresh()

    def _check(self, plan: SessionPlan, now: TrackerSituation) -> None:
        cell, left = self._cell, {stop.config for stop in now.left}
        done = [stop.config for stop in self._plan.stops if stop.config not in left]
        check_plan(plan, cell.robot, cell.nests, cell.fixed_nests, self._limits, done)

    @property
    def record(self) -> TrackerRecord:
        """What its ledger amounts to."""
        return self._record

    @property
    def robot_moving(self) -> bool:
        """Whether the arm is on its way now."""
        return self._execution.is_moving

    def live(self) -> AsyncIterator[Sighting]:
        """Return where the reflector is, again and again until the session ends; for all who watch."""
        return self._watch.follow()

    def onlookers(self) -> tuple[Onlooker, ...]:
        """Look where the reflector is, while somebody watches."""
        return (self._watch.run,)

    async def close(self) -> None:
        """Tell watchers that nothing more comes."""
        self._watch.end()

    # what a person asks for

    def require(self, act: OperatorCommand) -> None:
        """Raise NotNowError, PersonMissingError where an act is not allowed now."""
        if act.name not in REVISIONS:
            super().require(act)
            return
        require_person(act.person)
        if self._ended or self.state in {SessionState.PLANNED, SessionState.ABORTING}:
            raise NotNowError(message("session.refused.nothing_to_do", state=words(self.state), act=act.name))

    async def do(self, act: OperatorCommand) -> CommandOutcome:
        """Do what an act asks for; raises NotNowError, ReasonMissingError."""
        if act.name in REVISIONS:
            return await self._revise(act)
        done = await super().do(act)
        if act.name is CommandName.RESUME:
            return replace(done, sentence=message("session.done.begins_again"))
        return done

    async def _go_on(self, act: OperatorCommand) -> int:
        self._identities.require_questioned(act.accepted_serial)
        number = await super()._go_on(act)
        self._identities.permit(act.accepted_serial, tidy_name(act.person))
        return number

    async def _revise(self, act: OperatorCommand) -> CommandOutcome:
        found = revision(act, self._plan, self._record, self.situation.step)
        number = await self._logbook.append(found.kind, found.step_id, act, text=found.text)
        return CommandOutcome(found.sentence, number)

    # what the run does

    async def begin(self) -> None:
        """Ask a person to look at the cell; also after a restart, whatever was asked before."""
        if has_ended(self.state):
            await super().begin()
        else:
            cold = _COLD if self._plan.ends_when_settled and not self.progress.done else ""
            first = "" if self.progress.done else first_pass(self._plan, self._cell)
            what = together(self._identities.question or cold, first)
            await self._ask(what, self._first)

    async def _ask(self, what: Text, stops: Sequence[PlannedStop]) -> None:
        """Have a person confirm that the arm may go to `stops`, and say what the ways there look like."""
        robot, offset_rad = self._cell.robot_controller, self._plan.approach_offset_rad
        ahead = await obstructions_ahead(self._ways, robot, stops, offset_rad)
        asked = together(what, ahead, CELL_CLEAR)
        await self._logbook.keep(lambda: self._put(asked, tuple(stop.config for stop in stops)))
        self._asked = True
        self._logbook.tell()

    async def _put(self, asked: Text, stops: tuple[int, ...]) -> None:
        if self._ended or self._halts.wish is not None:
            return
        line: dict[str, Any] = {
            "entered": SessionState.AWAITING_CONFIRMATION,
            "text": asked,
            "stops": stops,
            "progress": self.progress,
        }
        if self._logbook.restarted:
            await self._logbook.open(**line)
        else:
            await self._logbook.append(EntryKind.CONTROL, **line)

    async def perform_step(self) -> None:
        """Do the present step, once a person has let the arm go there."""
        now = self.situation
        if now.step is not None and now.step.stop in now.unasked:
            await self._ask(_what_comes(now, self._record), now.unasked)
        elif now.step is not None:
            await self._do(now.step)

    async def let_go(self) -> None:
        """Close both links, whichever failed: the step begins again with the opening of the instruments."""
        await self._cell.tracker.close()
        await self._cell.robot_controller.close()

    def lines_after(self, error: SessionError | DriverError, step: Step) -> Sequence[Line]:
        """Return what is put on record after a fault, as `faults` has it."""
        moving = self._execution.is_moving
        return tuple(lines_after(error, step, self.situation, self._plan, moving=moving))

    async def operate(self, step: Step) -> Sequence[Line]:
        """Do the operations of a step; returns what is put on record at its end."""
        self._execution.begin_step()
        for operation in step.operations:
            # Between two operations, hence at the end of a motion: what is under way cannot be broken off.
            if self._halts.wish is not None or self._is_left_out(step):
                return ()
            # A session may have waited a minute for the disk: after that nobody expects a motion (decision
            # 0024).
            refused = self._logbook.interrupted
            if isinstance(operation, Move | KeepWorking) and refused is not None:
                return (awaits_person(message("session.database.was_because", why=refused)),)
            await self._execution.perform(operation)
        ends_by_itself = step.kind in {StepKind.OPEN, StepKind.WARM, StepKind.LOOK}
        return (Line(EntryKind.ENDED, step.id),) if ends_by_itself else ()

    def _is_left_out(self, step: Step) -> bool:
        """Whether a person wants no reading here any more."""
        return step.stop is not None and step.stop.config in self._record.left_out


def _what_comes(now: TrackerSituation, record: TrackerRecord) -> Message:
    """Say which configurations nobody has let the arm go to so far."""
    wanted_again = [stop.config for stop in now.unasked if stop.config in record.reopened]
    if not wanted_again:
        return message("session.added_next")
    return message("session.wanted_next", n=len(wanted_again), named=tuple(map(str, wanted_again)))
