"""Runs a session of closed loops: questions first, then one stop after the other while nobody is in the cell.

A stop whose reading fails is skipped with its reason; several in a row pause the session. A lost link, or an
arm that is not where it was left, has a person look at the cell before anything moves again.
"""

from collections.abc import Sequence
from typing import Any, Final

from truepose.domain.contacts import ContactPlan
from truepose.domain.errors import text_of
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.session import SessionState
from truepose.messages.message import Text, message, together
from truepose.sessions.contact.dry_run import check_plan, ways_to
from truepose.sessions.contact.measuring import ContactCell, ContactMeasurement, Gauges
from truepose.sessions.contact.state import (
    OPEN,
    ContactRecord,
    ContactSituation,
    Open,
    Question,
    Visit,
    open_prompt,
    situation_of,
)
from truepose.sessions.engine.commands import OperatorCommand
from truepose.sessions.engine.identity_check import reported_serial_number, same_number
from truepose.sessions.engine.interlocks import binding_speed, motion_limits, speed_sentence
from truepose.sessions.engine.ledger import RESTARTED, Ledger, Logbook
from truepose.sessions.engine.prompts import CELL_CLEAR
from truepose.sessions.engine.runner import is_interruption
from truepose.sessions.engine.states import has_ended
from truepose.sessions.engine.unattended import Line, UnattendedRunner, awaits_person
from truepose.sessions.errors import (
    AttentionNeededError,
    ForeignRobotError,
    MotionForbiddenError,
    SessionError,
)
from truepose_drivers.errors import DriverError

_EFFECTS: Final = {
    SessionState.PAUSED: together(message("session.pause_requested"), CELL_CLEAR),
    SessionState.AWAITING_CONFIRMATION: together(message("session.stopped"), CELL_CLEAR),
    SessionState.ABORTED: message("session.ended_between"),
}


class ContactRunner(UnattendedRunner[ContactSituation]):
    """One session of closed loops on one cell.

    `entries` are what earlier runs kept: the session goes on where they end, once a person has confirmed.
    Raises PlanRefusedError where the plan does not fit the cell.
    """

    progress_on_each_line = True

    def __init__(
        self, plan: ContactPlan, cell: ContactCell, ledger: Ledger, entries: tuple[LedgerEntry, ...] = ()
    ) -> None:
        limits = motion_limits(cell.robot, cell.joint_limits)
        check_plan(plan, cell.robot, cell.base, limits)
        self._plan = plan
        self._cell = cell
        self._record = record = ContactRecord()
        logbook = Logbook(ledger, cell.clock, record, lambda: situation_of(plan, record), entries)
        super().__init__(logbook, cell, limits, plan.joint_tolerance_rad, _EFFECTS)
        self._speed = binding_speed(plan, cell.speed_limits)
        self._gauges = Gauges(cell.gauges, cell.clock, plan)
        self._visiting = ContactMeasurement(plan, cell, self._arm, self._gauges)

    @property
    def has_asked(self) -> bool:
        """Whether this run has asked a person."""
        return not self._logbook.restarted

    @property
    def record(self) -> ContactRecord:
        """What its ledger amounts to."""
        return self._record

    @property
    def robot_moving(self) -> bool:
        """Whether the arm may be on its way: a stop is gone to, touched and left in many small motions."""
        return self._halts.moving and isinstance(self.situation.step, Visit)

    # what a person asks for

    async def _go_on(self, act: OperatorCommand) -> int:
        number = await super()._go_on(act)
        self._visiting.forget()
        return number

    # what the run does

    async def begin(self) -> None:
        """Ask the first thing; after a restart that is whether the cell is clear, or what was asked then."""
        if has_ended(self.state):
            await super().begin()
        elif self.state is SessionState.PLANNED:
            await self._ask(Question.FIXTURE)
        # What people did with their hands stays done, so only an open question of theirs is put again; else
        # it is whether the cell is clear.
        elif self._logbook.restarted:
            step = self.situation.step
            question = step if isinstance(step, Question) else Question.CLEAR
            text = together(RESTARTED, await self._prompt(question))
            await self._logbook.keep(
                lambda: self._logbook.open(step_id=question, text=text, progress=self.progress)
            )

    async def _prompt(self, question: Question) -> Text:
        """Return what is asked; where the arm goes next, with what to watch on its ways."""
        asked, left = open_prompt(question, self._plan), self.situation.left
        if question is not Question.CLEAR or not left:
            return asked
        return together(await self._ways.what_to_watch(ways_to(left)), asked)

    async def _ask(self, question: Question) -> None:
        text = await self._prompt(question)

        async def put() -> None:
            # A question to a person who has just asked for a halt would take its place.
            if not self._ended and self._halts.wish is None:
                said: dict[str, Any] = {"entered": SessionState.AWAITING_CONFIRMATION}
                said |= {"text": text, "progress": self.progress}
                await self._logbook.append(EntryKind.CONTROL, question, **said)

        await self._logbook.keep(put)

    async def perform_step(self) -> None:
        """Do the present step, or ask what it asks."""
        step = self.situation.step
        if isinstance(step, Question):
            await self._ask(step)
        # After the disk has refused for a while nobody expects a motion (decision 0024).
        elif self._logbook.interrupted is not None:
            await self._logbook.keep(self._wait_after_refusal)
        elif step is not None:
            await self._do(step)

    async def operate(self, step: Open | Visit) -> Sequence[Line]:
        """Do a step; returns what is put on record at its end."""
        if isinstance(step, Open):
            await self._open()
            return (Line(EntryKind.ENDED, OPEN),)
        # Before each stop: a controller may be exchanged behind an address without the link going down.
        await self._require_same_robot()
        return (Line(EntryKind.MEASURED, step.id, contact=await self._visiting.visit(step.stop)),)

    async def let_go(self) -> None:
        """Close the links to gauges and robot."""
        await self._gauges.close()
        await self._cell.robot_controller.close()

    def lines_after(self, error: SessionError | DriverError, step: Open | Visit) -> Sequence[Line]:
        """Return what is put on record after a fault: somebody looks, or the stop is left out."""
        reason = text_of(error)
        if is_interruption(error) or isinstance(error, MotionForbiddenError):
            return Line(EntryKind.REOPENED, OPEN), awaits_person(reason, step.id)
        if isinstance(step, Open) or isinstance(error, AttentionNeededError):
            return (_paused(reason, step),)
        skipped = Line(EntryKind.SKIPPED, step.id, reason)
        if not self._visiting.is_where_the_next_way_begins(step.stop):
            # A stop stays the present one until the arm has left its target: so it leaves by the way of this
            # stop, also after a restart. Wires have nothing to leave, only a way that nobody has looked at.
            waits = _paused(reason, step)
            return (waits,) if self._plan.touches else (skipped, waits)
        # One configuration may fail by itself; several in a row make the set-up suspect.
        failures = self.situation.failures + 1
        if failures < self._plan.failures_in_a_row:
            return (skipped,)
        return skipped, _paused(message("session.stops_in_a_row", stops=failures, why=reason), step)

    async def _open(self) -> None:
        robot = self._cell.robot_controller
        if not robot.connected:
            await robot.connect()
        await self._require_same_robot()
        for sentence in await self._gauges.open():
            await self._logbook.write(EntryKind.NOTED, text=sentence)
        await self._arm.set_limits(self._speed)
        await self._logbook.write(EntryKind.NOTED, text=speed_sentence(self._speed, robot.motion_guard))

    async def _require_same_robot(self) -> None:
        serial, wanted = (
            reported_serial_number((await self._cell.robot_controller.identify()).serial),
            self._cell.robot_serial,
        )
        if serial and wanted and not same_number(serial, wanted):
            raise ForeignRobotError(message("session.identity.robot_short", serial=serial, expected=wanted))

    async def _wait_after_refusal(self) -> None:
        why = together(message("session.database.was"), CELL_CLEAR)
        if self.state is SessionState.RUNNING:
            await self._logbook.enter(SessionState.AWAITING_CONFIRMATION, why)

    async def close(self) -> None:
        """Let go of the gauges."""
        await self._gauges.close()


def _paused(reason: Text, step: Open | Visit) -> Line:
    return Line(EntryKind.CONTROL, step.id, together(reason, CELL_CLEAR), SessionState.PAUSED)
