"""Runs a session of closed loops: questions first, then one stop after the other while nobody is in the cell.

A stop whose reading fails is skipped with its reason; several in a row pause the session. A lost link, or an
arm that is not where it was left, has a person look at the cell before anything moves again.
"""

from collections import deque
from dataclasses import replace
from typing import Any, Final

from truepose.domain.contacts import ContactPlan
from truepose.domain.errors import text_of
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.people import tidy_name
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
from truepose.sessions.engine.arm import Arm
from truepose.sessions.engine.commands import HALTS, CommandName, CommandOutcome, OperatorCommand
from truepose.sessions.engine.halts import Halts
from truepose.sessions.engine.identity_check import reported_serial_number, same_number
from truepose.sessions.engine.interlocks import binding_speed, end_of_motion, motion_limits, speed_sentence
from truepose.sessions.engine.ledger import RESTARTED, Ledger, Logbook
from truepose.sessions.engine.prompts import CELL_CLEAR
from truepose.sessions.engine.runner import is_interruption
from truepose.sessions.engine.states import has_ended
from truepose.sessions.engine.unattended import UnattendedRunner
from truepose.sessions.engine.ways import KnownWays
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

    def __init__(
        self, plan: ContactPlan, cell: ContactCell, ledger: Ledger, entries: tuple[LedgerEntry, ...] = ()
    ) -> None:
        limits = motion_limits(cell.robot, cell.joint_limits)
        check_plan(plan, cell.robot, cell.base, limits)
        self._plan = plan
        self._cell = cell
        self._record = record = ContactRecord()
        logbook = Logbook(ledger, cell.clock, record, lambda: situation_of(plan, record), entries)
        halts = Halts(logbook, lambda: end_of_motion(cell.robot_controller), _EFFECTS)
        super().__init__(logbook, halts, cell.robot_controller)
        self._speed = binding_speed(plan, cell.speed_limits)
        self._ways = KnownWays(cell.look_at_ways)
        self._arm = Arm(
            cell.robot_controller,
            cell.clock,
            cell.robot,
            limits,
            plan.joint_tolerance_rad,
            self._permission,
            self._ways,
        )
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

    async def do(self, act: OperatorCommand) -> CommandOutcome:
        """Do what an act asks for; raises NotNowError."""
        if act.name in HALTS:
            return await self._halts.halt(act)
        if act.name is CommandName.START:
            return self._asked_now()
        name, asked = tidy_name(act.person), self._record.reason
        number = await self._logbook.enter(SessionState.RUNNING, message("session.went_on", person=name), act)
        self._halts.forget()
        self._ways.confirm(asked)
        self._arm.forget()
        self._visiting.forget()
        return CommandOutcome(message("session.done.confirmed"), number)

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

    async def perform(self) -> None:
        """Do the present step; after a fault the ledger says what is to be done about it."""
        step = self.situation.step
        if self._halts.wish is not None:
            return
        if step is None:
            await self._logbook.keep(self.settle)
        elif isinstance(step, Question):
            await self._ask(step)
        # After the disk has refused for a while nobody expects a motion (decision 0024).
        elif self._logbook.interrupted is not None:
            await self._logbook.keep(self._wait_after_refusal)
        else:
            await self._do(step)

    async def _do(self, step: Open | Visit) -> None:
        self._halts.moving = True
        try:
            lines = await self._attempt(step)
        finally:
            self._halts.moving = False
        waiting = deque(lines)
        await self._logbook.keep(lambda: self._conclude(waiting))

    async def _attempt(self, step: Open | Visit) -> list[dict[str, Any]]:
        """Do a step; returns the lines that are put on record at its end."""
        progress = replace(self.progress, doing=step.title)
        await self._logbook.write(EntryKind.BEGUN, step.id, text=step.title, progress=progress)
        try:
            if isinstance(step, Open):
                await self._open()
                return [{"kind": EntryKind.ENDED, "step_id": OPEN}]
            # Before each stop: a controller may be exchanged behind an address without the link going down.
            await self._require_same_robot()
            taken = await self._visiting.visit(step.stop)
            return [{"kind": EntryKind.MEASURED, "step_id": step.id, "contact": taken}]
        except (SessionError, DriverError) as error:
            if isinstance(error, MotionForbiddenError) and self._halts.wish is not None:
                return []  # asked for between two looks
            if is_interruption(error):
                await self._gauges.close()
                await self._cell.robot_controller.close()
            return self._lines_after(error, step)

    def _lines_after(self, error: Exception, step: Open | Visit) -> list[dict[str, Any]]:
        """Return what is put on record after a fault: somebody looks, or the stop is left out."""
        reason = text_of(error)
        if is_interruption(error) or isinstance(error, MotionForbiddenError):
            waits = {"entered": SessionState.AWAITING_CONFIRMATION, "text": together(reason, CELL_CLEAR)}
            return [
                {"kind": EntryKind.REOPENED, "step_id": OPEN},
                {"kind": EntryKind.CONTROL, "step_id": step.id, **waits},
            ]
        pauses = {"kind": EntryKind.CONTROL, "step_id": step.id, "entered": SessionState.PAUSED}
        waits = {**pauses, "text": together(reason, CELL_CLEAR)}
        if isinstance(step, Open) or isinstance(error, AttentionNeededError):
            return [waits]
        skipped = {"kind": EntryKind.SKIPPED, "step_id": step.id, "text": reason}
        if not self._visiting.is_where_the_next_way_begins(step.stop):
            # A stop stays the present one until the arm has left its target: so it leaves by the way of this
            # stop, also after a restart. Wires have nothing to leave, only a way that nobody has looked at.
            return [waits] if self._plan.touches else [skipped, waits]
        # One configuration may fail by itself; several in a row make the set-up suspect.
        if self.situation.failures + 1 < self._plan.failures_in_a_row:
            return [skipped]
        why = message("session.stops_in_a_row", stops=self.situation.failures + 1, why=reason)
        return [skipped, {**pauses, "text": together(why, CELL_CLEAR)}]

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

    async def _conclude(self, lines: deque[dict[str, Any]]) -> None:
        """Put on record how a step ended, once; a halt that was asked for meanwhile takes effect."""
        ends = self._halts.wish is SessionState.ABORTED
        while lines:
            waits = "entered" in lines[0]
            if not (waits and ends):
                await self._logbook.append(progress=self.progress, **lines[0])
            if waits and not ends:
                self._halts.wish = None  # it waits for a person, as was wished
            lines.popleft()
        await self.follow_step()

    async def close(self) -> None:
        """Let go of the gauges."""
        await self._gauges.close()
