"""Runs a ballbar session: follows the ballbar, moves the arm where a person lets it, keeps every line.

- Nothing is remembered but the ledger: the present step follows from it, also after a restart.
- The arm moves in a MOVE step only, after a person has confirmed; see `motion`.
- A ballbar without a link is shown as such and found again; the session waits for it. A robot without a
  link, or elsewhere than it was left, has the session await a person's confirmation.
- Another ballbar shows its values and stores none before a person has accepted it by its serial number.
- A length is stored by itself once for each connection, or by the button; a doubt is put to a person.
- A line that the ledger refuses is tried again, and nothing moves meanwhile; a halt holds all the same.
"""

import asyncio
import contextlib
import time
from collections.abc import AsyncIterator, Callable, Coroutine
from typing import Any, Final

from truepose.domain.artefacts import BallbarKit
from truepose.domain.ballbar import BallbarPlan, BallbarStep, EntryKind, LedgerEntry, PreCalibration, StepKind
from truepose.domain.errors import RecordRefusedError
from truepose.domain.session import SessionState
from truepose.sequencing.ballbar.act_handlers import NEEDS_BALLBAR_OFF, ActHandlers
from truepose.sequencing.ballbar.acts import Act, ActName, ActOutcome
from truepose.sequencing.ballbar.arm_at_rest import Stand
from truepose.sequencing.ballbar.cell import BallbarCell
from truepose.sequencing.ballbar.doubts.assignments import Judges
from truepose.sequencing.ballbar.identity_check import Acquaintances
from truepose.sequencing.ballbar.logbook import Book
from truepose.sequencing.ballbar.measuring.live import LiveSample
from truepose.sequencing.ballbar.measuring.readings import Readings
from truepose.sequencing.ballbar.motion import Motion
from truepose.sequencing.ballbar.pending_halts import Arrears
from truepose.sequencing.ballbar.plan.dry_run import check_plan, check_structure, motion_limits
from truepose.sequencing.ballbar.precalibration import Foresight, foreseen
from truepose.sequencing.ballbar.situation import Situation
from truepose.sequencing.ballbar.transitions import Floor
from truepose.sequencing.engine.ledger import Ledger
from truepose.sequencing.engine.states import has_ended, words
from truepose.sequencing.errors import MotionForbiddenError, NotNowError, SequencingError
from truepose_drivers.errors import DriverError

POLL_S: Final = 0.05  # of the ballbar: 20 Hz
_LOOK_S: Final = 0.5  # at the robot while it stands
_BREATH_S: Final = 0.005  # wall time between two polls: a simulated cell's clock may cost none
_HALTS: Final = {
    ActName.PAUSE: SessionState.PAUSED,
    ActName.STOP: SessionState.AWAITING_CONFIRMATION,
    ActName.ABORT: SessionState.ABORTED,
}


def _wall_ms() -> int:
    return time.time_ns() // 1_000_000


class BallbarRunner:
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
        foresight: Foresight,
        entries: tuple[LedgerEntry, ...] = (),
        *,
        judges: Judges | None = None,
        wall_ms: Callable[[], int] = _wall_ms,
        breath_s: float = _BREATH_S,
    ) -> None:
        self._limits = motion_limits(cell.robot, cell.joint_limits)
        if entries:  # limits that were tightened since bind its next act; it is not lost by them
            check_structure(plan, kit)
        else:
            check_plan(plan, kit, cell.robot, self._limits)
        self._plan = plan
        self._kit = kit
        self._cell = cell
        self._foresight = foresight
        self._breath_s = breath_s
        self._book = Book(plan, kit, ledger, cell.clock, entries)
        self._stand = Stand(cell, plan)
        self._readings = Readings(plan, kit, cell, wall_ms)
        self._motion = Motion(plan, cell, self._limits, self._book, self._stand, self._readings)
        self._floor = Floor(
            kit,
            judges or Judges(),
            self._book,
            self._readings,
            self._stand,
            self._motion,
            Acquaintances(cell.expected, self._book),
        )
        self._handlers = ActHandlers(self._floor, cell.clock)
        self._failure: Exception | None = None  # a halt could not be kept: the run ends with this
        self._arrears = Arrears(self._floor, self.act, lambda: self._after_motion(None))
        last = self._book.last_length
        if last is not None:  # it may still be connected where it was stored
            length, step_id = last
            self._readings.contact.take(length.deviation_mm, step_id)

    @property
    def situation(self) -> Situation:
        """Where the session stands, as the ledger has it."""
        return self._book.situation

    @property
    def question(self) -> str | None:
        """What a person is asked to look at, or why the session waits; None where neither is."""
        return self.trouble or self.situation.question

    @property
    def trouble(self) -> str | None:
        """What a person is told while lines are refused; nothing moves meanwhile."""
        return self._book.trouble

    @property
    def robot_moving(self) -> bool:
        """Whether the arm is in motion, or about to be."""
        return self._motion.moving

    @property
    def version(self) -> int:
        """Number of changes so far."""
        return self._book.version

    async def changed(self, after: int) -> int:
        """Return the version once it is above `after`."""
        return await self._book.changed(after)

    def live(self) -> AsyncIterator[LiveSample]:
        """Return the samples from now on until the session ends; for any number of watchers."""
        return self._readings.watch()

    async def act(self, act: Act) -> ActOutcome:
        """Do what a person asks, once for each key; the outcome is on disk when this returns.

        Raises NotNowError, PersonMissingError, ReasonMissingError and WatchingTabletError; nothing was done
        then. Where it cannot be kept RecordRefusedError: a halt of a running session holds and is kept later.
        """
        wished = self._wish_at_once(act)
        was_running = self._runs
        try:
            await self._gather_samples(act)
            async with self._floor.changing:
                await self._book.open()
                earlier = await self._book.earlier_outcome(act.key)
                if earlier is not None:
                    return earlier
                self._handlers.require(act)
                if act.name is ActName.CONFIRM and was_running != self._runs:
                    state = words(self.situation.state)  # what was confirmed is not what is asked now
                    raise NotNowError(
                        f"The session became {state} meanwhile; look at the cell, confirm anew."
                    )
                return self._book.keep_outcome(act.key, await self._handlers.do(act))
        except RecordRefusedError:
            if wished:
                self._arrears.owe(act)
            raise
        except SequencingError:
            if wished and self._motion.wish is _HALTS[act.name]:
                self._motion.wish = None
            raise
        except Exception as error:
            if wished:  # nobody will enter that state any more, and the arm must not go on either
                self._failure = error
            raise
        finally:
            self._book.tell()

    async def run(self) -> SessionState:
        """Run to the end and return the state it ended in; first a person has to `start`, or to `confirm`.

        Raises what the ledger raises. Every fault of the devices becomes a state with a sentence; so does a
        mistake of the program, which ends this run: the next act finds a session that awaits a person.
        """
        await self._floor.keep(self._book.open)
        loops = [asyncio.create_task(loop) for loop in self._loops()]
        try:
            await asyncio.wait(loops, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for task in loops:
                task.cancel()
            results = await asyncio.gather(*loops, return_exceptions=True)
            await self._readings.close()
        for result in results:
            if isinstance(result, Exception):
                await self._floor.note_failure(result)
                raise result
        return self.situation.state

    def _loops(self) -> tuple[Coroutine[Any, Any, None], ...]:
        return self._conduct(), self._follow_ballbar(), self._follow_robot(), self._arrears.follow()

    @property
    def _ended(self) -> bool:
        return has_ended(self.situation.state)

    @property
    def _runs(self) -> bool:
        return self.situation.state is SessionState.RUNNING

    def _wish_at_once(self, act: Act) -> bool:
        """Forbid motion from the moment on at which a halt is asked for; returns whether that was done."""
        if act.name not in _HALTS or self._book.knows(act.key) or self._motion.wish is not None:
            return False
        try:
            self._handlers.require(act)
        except SequencingError:
            return False
        self._motion.wish = _HALTS[act.name]
        return True

    async def _gather_samples(self, act: Act) -> None:
        """Have what is done rest on samples that were taken since the button was pressed.

        A length that is stored by hand does, and so does the word that the ballbar is off. The floor is not
        taken meanwhile: the loop that brings the samples may be waiting for it.
        """
        if self._book.knows(act.key):
            return
        if act.name is ActName.STORE:
            self._handlers.require(act)
            await self._readings.fresh()
        step = self.situation.step
        asks_for_off = step is not None and step.kind in NEEDS_BALLBAR_OFF
        if act.name is ActName.CONFIRM and self._runs and asks_for_off:
            self._handlers.require(act)
            await self._readings.settle()

    # motion and computation

    async def _conduct(self) -> None:
        while not self._ended:
            if self._failure is not None:
                raise self._failure
            version = self._book.version
            step = self.situation.step
            if step is not None and self.situation.busy and not self._arrears.due:
                await (self._move(step) if step.kind is StepKind.MOVE else self._precalibrate(step))
            if not self._ended and self._book.version == version:
                await self._book.changed(version)

    async def _move(self, step: BallbarStep) -> None:
        arrival, failure = None, None
        try:
            arrival = await self._motion.perform(step)
        except MotionForbiddenError as error:
            failure = None if self._motion.wish is not None else str(error)
        except DriverError as error:
            failure = str(error)
            await self._stand.close()

        async def keep() -> None:
            nonlocal arrival
            if arrival is not None:
                await self._book.append(EntryKind.MOVED, step.id, arrival=arrival)
                arrival = None
            elif self._motion.saw_ballbar:
                await self._floor.note_attached()
            await self._after_motion(failure)
            await self._floor.settle()

        await self._floor.keep(keep)

    async def _after_motion(self, failure: str | None) -> None:
        state, wish = self.situation.state, self._motion.wish
        if wish is not None and state is SessionState.RUNNING:
            return  # who asked for it waits for the floor, and does it
        if wish is not None and failure is None:
            await self._book.enter(wish, self.situation.reason)
            self._motion.wish = None
        elif failure is not None:
            self._motion.wish = None
            await self._floor.hold(failure)

    async def _precalibrate(self, step: BallbarStep) -> None:
        task = asyncio.create_task(foreseen(self._foresight, self._plan, self._kit, self._book.entries))
        try:
            while not task.done() and not self._ended:
                await self._wait_for(task)
        finally:
            task.cancel()  # nobody waits for it any more; done, it does not mind
        if not task.done() or task.cancelled():
            return

        async def keep() -> None:
            present = self.situation.step
            if not self._ended and present is not None and present.id == step.id:
                await self._keep_foresight(step, task.result())
                await self._floor.settle()

        await self._floor.keep(keep)

    async def _wait_for(self, task: "asyncio.Task[PreCalibration | str]") -> None:
        """Return when the task is done, or when something else has changed."""
        changed = asyncio.create_task(self._book.changed(self._book.version))
        try:
            await asyncio.wait({task, changed}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            changed.cancel()

    async def _keep_foresight(self, step: BallbarStep, found: PreCalibration | str) -> None:
        if isinstance(found, PreCalibration):
            await self._book.append(EntryKind.COMPUTED, step.id, precalibration=found)
        elif self.situation.state is SessionState.RUNNING:
            reason = f"The pre-calibration was not possible: {found} Resume to try again, or skip it."
            await self._book.enter(SessionState.PAUSED, reason)

    # what goes on meanwhile

    async def _follow_ballbar(self) -> None:
        next_s = 0.0
        while not self._ended:
            if self.situation.state is SessionState.PLANNED:
                await self._book.changed(self._book.version)
                continue
            sample = await self._readings.poll(self.situation, robot_still=self._robot_is_still())
            await self._heed_ballbar()
            next_s = max(next_s + POLL_S, sample.time_s)
            now_s = await self._cell.clock.now_s()
            await self._cell.clock.sleep(min(POLL_S, max(0.0, next_s - now_s)))
            await asyncio.sleep(self._breath_s)

    async def _heed_ballbar(self) -> None:
        is_news = self._floor.ballbar_news() is not None
        due = is_news or self._is_ready() or self._readings.lost_power
        if self.trouble is not None or not due:
            return
        # Where the line is refused the length is shown on; it is read again once lines are taken.
        with contextlib.suppress(RecordRefusedError):
            async with self._floor.changing:
                if is_news:
                    await self._floor.note_ballbar()
                elif self._readings.lost_power:
                    await self._floor.note_lost_power()
                elif self._is_ready():
                    await self._store()
                if not self._motion.moving:  # a motion that is under way ends by itself, and settles then
                    await self._floor.settle()

    async def _store(self) -> None:
        """Store the length by itself, or see why it cannot be: then the session has said so."""
        now_s = await self._cell.clock.now_s()
        with contextlib.suppress(NotNowError):
            taken = self._readings.length(self.situation, now_s, by_hand=False)
            await self._floor.require_stop()  # after the last sample of it
            await self._floor.store(taken)

    def _is_ready(self) -> bool:
        running = self.situation.state is SessionState.RUNNING
        return running and self._readings.is_ready(self.situation, robot_still=self._robot_is_still())

    def _robot_is_still(self) -> bool:
        if self._motion.moving:
            return False
        sample = self._readings.sample
        return self.situation.stop is None or (sample is not None and self._stand.is_still(sample.time_s))

    async def _follow_robot(self) -> None:
        while not self._ended:
            if self.situation.state is SessionState.PLANNED:
                await self._book.changed(self._book.version)
                continue
            await self._cell.clock.sleep(_LOOK_S)
            await asyncio.sleep(self._breath_s)
            if self._floor.entered and not self._motion.moving:
                await self._look_at_robot()

    async def _look_at_robot(self) -> None:
        moved, failure = None, None
        try:
            moved = await self._floor.look_at_robot()
        except DriverError as error:
            failure = str(error)
        if (moved is None and failure is None) or self._motion.moving:
            return

        async def keep() -> None:
            if self._motion.moving or not self._floor.entered:
                return
            if failure is not None:
                await self._stand.close()
            if moved is not None:
                await self._floor.lose_stop(moved)
            await self._floor.hold(failure or moved or "")

        await self._floor.keep(keep)
