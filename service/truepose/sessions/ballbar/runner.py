"""Runs a ballbar session: follows the ballbar, moves the arm where a person lets it, keeps every line.

- The arm moves in a MOVE step only, after a person has confirmed; see `motion`.
- A ballbar without a link is shown as such and found again; the session waits for it. A robot without a
  link, or elsewhere than it was left, has the session await a person's confirmation.
- Another ballbar shows its values and stores none before a person has accepted it by its serial number.
- A length is stored by itself once for each connection, or by the button; a doubt is put to a person.
- A failure of the program ends the run, not the session: the next act takes the ledger up again.
"""

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine
from typing import Any, Final

from truepose.domain.ballbar import (
    BallbarPlan,
    BallbarStep,
    LengthTaken,
    PreCalibration,
    StepKind,
)
from truepose.domain.cell import BallbarKit
from truepose.domain.errors import RecordRefusedError, text_of
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.session import SessionState
from truepose.messages.message import Text, message
from truepose.sessions.ballbar.cell import BallbarCell, PreCalibrate, precalibrated
from truepose.sessions.ballbar.command_handlers import CommandHandlers
from truepose.sessions.ballbar.dry_run import check_plan, check_structure
from truepose.sessions.ballbar.length_check import Judges
from truepose.sessions.ballbar.live import LiveSample
from truepose.sessions.ballbar.motion_interlock import InterlockedMotion, RestMonitor
from truepose.sessions.ballbar.readings import Readings
from truepose.sessions.ballbar.situation import Situation, situation_of
from truepose.sessions.ballbar.state import NEEDS_BALLBAR_OFF, BallbarRecord
from truepose.sessions.ballbar.transitions import Transitions
from truepose.sessions.engine.commands import CommandName, CommandOutcome, OperatorCommand
from truepose.sessions.engine.halts import Halts
from truepose.sessions.engine.interlocks import end_of_motion, motion_limits
from truepose.sessions.engine.ledger import IdentityCheck, Ledger, Logbook
from truepose.sessions.engine.runner import SessionRunner
from truepose.sessions.errors import MotionForbiddenError, NotNowError
from truepose_drivers.errors import DriverError

POLL_S: Final = 0.05  # of the ballbar: 20 Hz
_LOOK_S: Final = 0.5  # at the robot while it stands
_BREATHS_WITHOUT_CLOCK: Final = 100  # before a clock that failed is asked again
_BREATH_S: Final = 0.005  # wall time between two polls: a simulated cell's clock may cost none


def _wall_ms() -> int:
    return time.time_ns() // 1_000_000


class BallbarRunner(SessionRunner[Situation]):
    """One ballbar session on one cell; `run` is its task, all other methods may be called from other tasks.

    `entries` are what earlier runs kept: the session goes on where they end, once a person has confirmed.
    Raises PlanRefusedError where the plan does not fit the cell; a session that has begun says so at the
    next act that would have it go on.
    """

    def __init__(
        self,
        plan: BallbarPlan,
        kit: BallbarKit,
        cell: BallbarCell,
        ledger: Ledger,
        precalibrate: PreCalibrate,
        entries: tuple[LedgerEntry, ...] = (),
        *,
        judges: Judges | None = None,
        wall_ms: Callable[[], int] = _wall_ms,
        breath_s: float = _BREATH_S,
    ) -> None:
        limits = motion_limits(cell.robot, cell.joint_limits)
        if entries:  # limits that were tightened since bind its next act; it is not lost by them
            check_structure(plan, kit)
        else:
            check_plan(plan, kit, cell.robot, limits)
        self._plan = plan
        self._kit = kit
        self._cell = cell
        self._identify = precalibrate
        self._breath_s = breath_s
        self._next_poll_s = 0.0  # of the ballbar, cell clock
        record = BallbarRecord()
        logbook = Logbook(ledger, cell.clock, record, lambda: situation_of(plan, kit, record), entries)
        halts = Halts(logbook, lambda: end_of_motion(cell.robot_controller), effects={})
        super().__init__(logbook, halts, cell.robot_controller)
        self._rest = RestMonitor(cell, plan)
        self._readings = Readings(plan, kit, cell, wall_ms)
        identities = IdentityCheck(cell.expected, logbook)
        self._motion = InterlockedMotion(
            plan, kit, cell, limits, logbook, halts, identities, self._rest, self._readings
        )
        self._transitions = Transitions(
            kit, judges or Judges(), logbook, self._readings, self._rest, self._motion, identities
        )
        self._handlers = CommandHandlers(self._transitions, halts, cell.clock)
        last = _last_length(entries)
        if last is not None:  # it may still be connected where it was stored
            length, step_id = last
            # Otherwise a restart would store the same connection once more by itself.
            self._readings.contact.take(length.deviation_mm, step_id)

    def live(self) -> AsyncIterator[LiveSample]:
        """Return the samples from now on until the session ends; for any number of watchers."""
        return self._readings.watch()

    # what the engine asks for

    def require(self, act: OperatorCommand) -> None:
        """Raise PersonMissingError, WatchingTabletError or NotNowError where an act is not allowed now."""
        self._handlers.require(act)

    def lets_move(self, act: OperatorCommand) -> bool:
        """Return whether the arm may move after an act; of what is done by hand a word is no such act."""
        step = self.situation.step
        by_hand = step is not None and step.kind is not StepKind.MOVE and self._runs
        return super().lets_move(act) and not (by_hand and act.name is CommandName.CONFIRM)

    async def prepare(self, act: OperatorCommand) -> None:
        """Have what is done rest on samples that were taken since the button was pressed.

        A length that is stored by hand does, and so does the word that the ballbar is off. The ledger is not
        held meanwhile: the loop that brings the samples may be waiting for it.
        """
        # A repeated request has its answer already, and must not wait for samples of another moment.
        if self._logbook.knows(act.key):
            return
        if act.name is CommandName.STORE:
            # First what can be refused at once: nobody waits two seconds to hear that another tablet acts.
            self.require(act)
            await self._readings.fresh()
        step = self.situation.step
        asks_for_off = step is not None and step.kind in NEEDS_BALLBAR_OFF
        if act.name is CommandName.CONFIRM and self._runs and asks_for_off:
            self.require(act)
            with contextlib.suppress(DriverError):  # then nothing is known of it
                await self._readings.ask()  # it may have been exchanged behind a link that stays up
            await self._readings.settle()

    async def do(self, act: OperatorCommand) -> CommandOutcome:
        """Do what an act asks for; raises NotNowError, ReasonMissingError, PlanRefusedError."""
        return await self._handlers.do(act)

    async def perform(self) -> None:
        """Move the arm, or compute."""
        step = self.situation.step
        if step is not None:
            await (self._move(step) if step.kind is StepKind.MOVE else self._precalibrate(step))

    async def settle(self) -> None:
        """Bring the session to where it waits again."""
        await self._transitions.settle()

    async def hold(self, reason: Text) -> None:
        """Have the session wait for a person: something is not as it was left."""
        await self._transitions.hold(reason)

    async def note_failure(self, error: Exception) -> None:
        """Put a failure on record once lines are taken; else whoever shows it says that nobody runs it."""
        await self._transitions.note_failure(error)

    def companions(self) -> tuple[Coroutine[Any, Any, None], ...]:
        """Follow ballbar and robot."""
        return self._follow(self._poll_ballbar), self._follow(self._look_at_robot)

    async def close(self) -> None:
        """Let go of the ballbar."""
        await self._readings.close()

    # motion and computation

    async def _move(self, step: BallbarStep) -> None:
        # The motion is over before anything is written: where the line is refused, it is tried again without
        # moving anything.
        arrival, failure = None, None
        try:
            arrival = await self._motion.perform(step)
        except MotionForbiddenError as error:
            failure = None if self._halts.wish is not None else text_of(error)
        except DriverError as error:
            failure = text_of(error)
            # A link that failed is opened anew by whoever goes on.
            await self._rest.close()

        async def keep() -> None:
            nonlocal arrival
            if arrival is not None:
                await self._logbook.append(EntryKind.MOVED, step.id, arrival=arrival)
                # Kept once, although the rest may be refused and done again.
                arrival = None
            elif self._motion.saw_ballbar:
                await self._transitions.note_attached()
            await self._after_motion(failure)
            await self._transitions.settle()

        await self._logbook.keep(keep)

    async def _after_motion(self, failure: Text | None) -> None:
        # A halt that was asked for explains why nothing more was sent, so it is what a person reads; not so
        # where the robot itself failed.
        if self._halts.wish is not None and (self._runs or failure is None):
            await self._halts.take_effect()
        elif failure is not None:
            self._halts.wish = None
            await self.hold(failure)

    async def _precalibrate(self, step: BallbarStep) -> None:
        task = asyncio.create_task(
            precalibrated(self._identify, self._plan, self._kit, self._logbook.entries)
        )
        try:
            # The end does not wait for a computation of a minute.
            while not task.done() and not self._ended:
                await self._wait_for(task)
        finally:
            task.cancel()  # nobody waits for it any more; done, it does not mind
        if not task.done() or task.cancelled():
            return

        async def keep() -> None:
            present = self.situation.step
            # Somebody may have skipped it, or gone back, while it was computed.
            if not self._ended and present is not None and present.id == step.id:
                await self._keep_precalibration(step, task.result())
                await self._transitions.settle()

        await self._logbook.keep(keep)

    async def _wait_for(self, task: "asyncio.Task[PreCalibration | Text]") -> None:
        """Return when the task is done, or when something else has changed."""
        changed = asyncio.create_task(self._logbook.changed(self._logbook.version))
        try:
            await asyncio.wait({task, changed}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            changed.cancel()

    async def _keep_precalibration(self, step: BallbarStep, found: PreCalibration | Text) -> None:
        if isinstance(found, PreCalibration):
            await self._logbook.append(EntryKind.COMPUTED, step.id, precalibration=found)
        elif self.situation.state is SessionState.RUNNING:
            reason = message("session.precalibration", sentence=found)
            await self._logbook.enter(SessionState.PAUSED, reason)

    # what goes on meanwhile

    async def _follow(self, look: Callable[[], Awaitable[None]]) -> None:
        """Look again and again, from the start of the session to its end."""
        while not self._ended:
            if self.situation.state is SessionState.PLANNED:
                await self._logbook.changed(self._logbook.version)
                continue
            try:
                await look()
            # Of the cell's clock: what robot or ballbar fail by is told as theirs. The session waits for a
            # person, and goes on to look, as with any other device.
            except DriverError as error:
                await self._hold_at_rest(text_of(error))
                await asyncio.sleep(_BREATHS_WITHOUT_CLOCK * self._breath_s)
            await asyncio.sleep(self._breath_s)

    async def _hold_at_rest(self, reason: Text) -> None:
        async def keep() -> None:
            if not self._halts.moving:  # a motion asks the same clock, and ends by it
                await self._transitions.hold(reason)

        await self._logbook.keep(keep)

    async def _poll_ballbar(self) -> None:
        sample = await self._readings.poll(self.situation, robot_still=self._robot_is_still())
        await self._heed_ballbar()
        # In the cell's time, and without catching up: polls that were missed would come in a burst and count
        # as samples.
        self._next_poll_s = max(self._next_poll_s + POLL_S, sample.time_s)
        now_s = await self._cell.clock.now_s()
        await self._cell.clock.sleep(min(POLL_S, max(0.0, self._next_poll_s - now_s)))

    async def _heed_ballbar(self) -> None:
        is_news = self._transitions.ballbar_news() is not None
        due = is_news or self._is_ready() or self._readings.lost_power
        # Nothing is stored by itself while the disk refuses: each try would hold the lock that a halt waits
        # for.
        if self.trouble is not None or not due:
            return
        # Where the line is refused the length is shown on; it is read again once lines are taken.
        with contextlib.suppress(RecordRefusedError):
            async with self._logbook.changing:
                if is_news:
                    await self._transitions.note_ballbar()
                elif self._readings.lost_power:
                    await self._transitions.note_lost_power()
                elif self._is_ready():
                    await self._store()
                if not self._halts.moving:  # a motion that is under way ends by itself, and settles then
                    await self._transitions.settle()

    async def _store(self) -> None:
        """Store the length by itself, or see why it cannot be: then the session has said so."""
        now_s = await self._cell.clock.now_s()
        with contextlib.suppress(NotNowError):
            taken = self._readings.length(self.situation, now_s, by_hand=False)
            await self._transitions.require_stop()  # after the last sample of it
            await self._transitions.store(taken)

    def _is_ready(self) -> bool:
        running = self.situation.state is SessionState.RUNNING
        return running and self._readings.is_ready(self.situation, robot_still=self._robot_is_still())

    def _robot_is_still(self) -> bool:
        if self._halts.moving:
            return False
        sample = self._readings.sample
        return self.situation.stop is None or (sample is not None and self._rest.is_still(sample.time_s))

    async def _look_at_robot(self) -> None:
        await self._cell.clock.sleep(_LOOK_S)
        if self._transitions.entered and not self._halts.moving:
            await self._require_robot_at_rest()

    async def _require_robot_at_rest(self) -> None:
        moved, failure = None, None
        try:
            moved = await self._transitions.look_at_robot()
        except DriverError as error:
            failure = text_of(error)
        # A motion may have begun while the robot was asked.
        if (moved is None and failure is None) or self._halts.moving:
            return

        async def keep() -> None:
            # Looked at again with the lock: an act may have changed everything meanwhile.
            if self._halts.moving or not self._transitions.entered:
                return
            if failure is not None:
                await self._rest.close()
            if moved is not None:
                await self._transitions.lose_stop(moved)
            await self._transitions.hold(failure or moved or "")

        await self._logbook.keep(keep)


def _last_length(entries: tuple[LedgerEntry, ...]) -> tuple[LengthTaken, str] | None:
    """Return the length that was read last, and the step that it was stored for, "" for none."""
    entry = next((entry for entry in reversed(entries) if entry.length is not None), None)
    if entry is None or entry.length is None:
        return None
    return entry.length, entry.step_id if entry.kind is EntryKind.MEASURED else ""
