"""Executes a tracker session: takes the sections of a plan in turn and decides what a fault means.

- A configuration whose reading fails is skipped with the reason, unless nothing has been measured since a
  person last had the session go on, or several in a row have failed: then the instrument is suspect, and
  the session pauses.
- A lost link, a robot that is not where it was left and a program that was restarted are the same thing
  to a session: nothing moves before a person confirms; then the devices are opened anew, the fixed nests
  are looked at, and the section that was interrupted begins again.
- Another tracker than the expected one measures nothing before a person has accepted it by its serial
  number; then it is placed in the world anew. Another robot is refused.
- Configurations may be added to the plan until the session has ended. They are measured after the others,
  once a person has confirmed that the cell is clear for them: whoever added them need not stand beside it.
- A pause or the end that somebody asks for takes effect between two steps, hence at the end of a motion.
- A record that is refused is kept and tried again, and nothing moves; a person confirms before
  the next motion.
"""

from collections import Counter, deque
from collections.abc import Awaitable, Callable, Sequence
from typing import Final

from truepose.domain.session import PlannedStop, Progress, SessionPlan, SessionState, StopSkipped
from truepose.sequencing.engine.arm import Arm
from truepose.sequencing.engine.limits import binding_speed
from truepose.sequencing.engine.motion_segments import MotionSegments
from truepose.sequencing.engine.notices import end_of_motion
from truepose.sequencing.engine.prompts import CELL_CLEAR, require_person
from truepose.sequencing.engine.states import after_restart, has_ended, words
from truepose.sequencing.errors import (
    AttentionNeededError,
    ForeignInstrumentError,
    MotionForbiddenError,
    NotNowError,
    ReadingRejectedError,
)
from truepose.sequencing.tracker.cell import SessionCell
from truepose.sequencing.tracker.dry_run import check_plan, motion_limits
from truepose.sequencing.tracker.execution import Execution
from truepose.sequencing.tracker.identity_check import DeviceIdentities
from truepose.sequencing.tracker.journal import SessionHistory, SessionJournal
from truepose.sequencing.tracker.pace import Pace
from truepose.sequencing.tracker.plans import (
    extended_plan,
    opening,
    references,
    registration,
    session_sections,
    visits,
)
from truepose.sequencing.tracker.standing import Standing
from truepose.sequencing.tracker.steps import MeasurePoint, Move, Section
from truepose.sequencing.tracker.way_preview import outlook
from truepose_drivers.errors import (
    ConfigurationError,
    DeviceRefusedError,
    DriverError,
    MeasurementFailedError,
    NotInitialisedError,
)

_INTERRUPTIONS_PER_STOP: Final = 2  # a configuration on which the link breaks so often is left out


class _EndedError(Exception):
    """The session has ended; unwinds the run."""


class SessionRunner:
    """One session on one cell; `run` is its task, all other methods may be called from other tasks.

    Raises PlanRefusedError where the plan does not fit the cell.
    """

    def __init__(
        self,
        plan: SessionPlan,
        cell: SessionCell,
        journal: SessionJournal,
        history: SessionHistory | None = None,
    ) -> None:
        history = history or SessionHistory()
        limits = motion_limits(cell.robot, cell.joint_limits, plan)
        check_plan(plan, cell.robot, cell.nests, cell.fixed_nests, limits, history.done)
        self._plan = plan
        self._limits = limits
        self._cell = cell
        self._standing = Standing(
            journal, after_restart(history.state), lambda: end_of_motion(cell.robot_controller)
        )
        self._journal = self._standing.journal
        self._arm = Arm(
            cell.robot_controller,
            cell.clock,
            limits,
            plan.joint_tolerance_rad,
            self._standing.permission,
            pieces=MotionSegments(cell.robot, binding_speed(plan, cell.speed_limits)),
        )
        self._acquaintances = DeviceIdentities(cell.expected, self._journal, history.identities)
        self._execution = Execution(
            plan, cell, self._arm, self._journal, history.registration, self._acquaintances
        )
        self._done = set(history.done)
        self._agenda = deque(
            session_sections(
                plan,
                len(cell.fixed_nests),
                registered=self._execution.fixed_nests.registered,
                done=history.done,
            )
        )
        self._pace = Pace(
            len(plan.stops), len(history.points), len(history.skipped), elapsed_s=history.elapsed_s
        )
        self._now_s = 0.0  # at the end of the last step
        self._measured = False  # something was measured since a person last had the session go on
        self._failures_in_a_row = 0
        self._paused_at: set[int] = set()  # configurations that made the session pause
        self._interrupted_at: Counter[int] = Counter()
        self._added: set[int] = set()  # configurations that no person has confirmed yet

    @property
    def state(self) -> SessionState:
        """Where the session stands, as the journal has it."""
        return self._standing.state

    @property
    def question(self) -> str | None:
        """What a person is asked to confirm, or why the session waits; None while it runs or has ended."""
        return self.trouble or self._standing.desk.question

    @property
    def trouble(self) -> str | None:
        """What a person is told while records are refused; nothing moves meanwhile."""
        return self._standing.trouble

    @property
    def progress(self) -> Progress:
        """How far the session is."""
        return self._pace.progress()

    async def request_pause(self, person: str | None = None) -> str:
        """Ask for a pause; returns the sentence that says when it takes effect. Raises NotNowError."""
        return await self._standing.request_pause(person)

    async def request_abort(self, person: str | None = None) -> str:
        """Ask for the end; returns the sentence that says when it takes effect.

        Raises NotNowError, and RecordRefusedError where nothing is in motion: nothing was done then.
        """
        return await self._standing.request_abort(person)

    async def resume(self, person: str) -> str:
        """Continue a paused session. Raises NotNowError, PersonMissingError."""
        await self._standing.go_on(SessionState.PAUSED, "resume", person)
        return "The session goes on; what was under way begins again."

    async def confirm(self, person: str, accepted_serial: str = "") -> str:
        """Confirm what `question` asks; a tracker that it questions is accepted by its serial number only.

        Raises NotNowError, PersonMissingError.
        """
        self._acquaintances.require_questioned(accepted_serial)
        await self._standing.go_on(SessionState.AWAITING_CONFIRMATION, "confirm", person)
        self._acquaintances.permit(accepted_serial, require_person(person))
        return "Confirmed; the session goes on."

    async def add_stops(self, stops: tuple[PlannedStop, ...], keep: Callable[[], Awaitable[None]]) -> None:
        """Add stops to the plan; they come last, after a person has confirmed.

        `keep` stores them; it is awaited while the session cannot end, and nothing is added where it
        raises. Raises NotNowError, PlanRefusedError.
        """
        async with self._standing.changing:
            if self._standing.ends:
                raise NotNowError(f"The session is {words(self.state)}; plan a new one for what is missing.")
            plan = extended_plan(self._plan, stops)
            cell = self._cell
            check_plan(plan, cell.robot, cell.nests, cell.fixed_nests, self._limits, self._done)
            await keep()
            self._plan = plan
            self._agenda.extend(visits(plan, stops, len(self._cell.fixed_nests)))
            self._added |= {stop.config for stop in stops}
            self._pace.planned += len(stops)

    async def run(self) -> SessionState:
        """Run to the end and return the state it ended in; first a person has to `confirm`.

        Raises what the journal raises; every fault of the devices becomes a state with a sentence.
        """
        try:
            await self._session()
        except _EndedError:
            pass
        except ConfigurationError as error:
            await self._standing.fail(str(error))
        except Exception as error:
            await self._standing.fail(f"The program failed ({type(error).__name__}): {error}")
            raise
        return self.state

    async def _session(self) -> None:
        if has_ended(self.state):
            return
        foreign = self._acquaintances.question or ""  # also of before a restart
        await self._wait_before([stop for stop in self._plan.stops if stop.config not in self._done], foreign)
        while not await self._finished():
            while self._agenda:
                await self._carry_out(self._agenda.popleft())
            await self._heed_requests()

    async def _finished(self) -> bool:
        return await self._standing.finish(self._nothing_left)

    def _nothing_left(self) -> Progress | None:
        if self._agenda:
            return None
        self._pace.doing = "finished"
        return self.progress

    async def _wait_for_person(self, state: SessionState, question: str) -> None:
        """Enter `state` and return when a person had the session go on; raises _EndedError where it ended."""
        self._standing.desk.ask(question)
        self._pace.hold()
        await self._standing.put(state)
        await self._journal.progressed(self.progress)
        if self._standing.wish is SessionState.ABORTING:
            await self._end_as_asked()
        await self._standing.desk.wait()
        if has_ended(self.state):
            raise _EndedError
        self._arm.forget()
        self._journal.forget()
        self._measured = False
        self._failures_in_a_row = 0

    async def _wait_before(self, stops: Sequence[PlannedStop], what: str) -> None:
        """Have a person confirm that the arm may go to `stops`, and say what the ways there look like."""
        ahead = await outlook(self._cell, stops, self._plan.approach_offset_rad)
        asked = " ".join(filter(None, (what, ahead, CELL_CLEAR)))
        await self._wait_for_person(SessionState.AWAITING_CONFIRMATION, asked)

    async def _heed_requests(self) -> bool:
        """Pause or end where that was asked for; returns whether the session was paused meanwhile."""
        if self._standing.wish is None:
            return False
        if self._standing.wish is SessionState.ABORTING:
            await self._end_as_asked()
        await self._wait_for_person(
            SessionState.PAUSED, "Paused on request. Is the cell clear, so that it can be resumed?"
        )
        return True

    async def _end_as_asked(self) -> None:
        await self._standing.end_as_asked()
        raise _EndedError

    # sections

    async def _carry_out(self, section: Section) -> None:
        """Do a section; after a fault the agenda holds what is to be done about it."""
        self._pace.doing = section.title
        self._execution.begin_section()
        try:
            await self._do_steps(section)
        except (NotInitialisedError, MotionForbiddenError) as error:
            await self._on_interruption(section, error)
        except (MeasurementFailedError, DeviceRefusedError, ReadingRejectedError) as error:
            await self._on_failed_measurement(section, str(error))
        except AttentionNeededError as error:
            await self._on_attention_needed(section, str(error))
        except ForeignInstrumentError as error:
            await self._on_foreign_tracker(section, str(error))
        except ConfigurationError:
            raise
        except DriverError as error:  # the link, nonsense on it, or a driver that failed
            await self._on_interruption(section, error)

    async def _do_steps(self, section: Section) -> None:
        await self._tick()
        if section.stop is not None and section.stop.config in self._added:
            await self._confirm_added()
        if section.stop is not None:
            self._pace.begin_stop()
        await self._journal.progressed(self.progress)
        for step in section.steps:
            if await self._heed_requests() or (isinstance(step, Move) and await self._confirm_again()):
                self._agenda.appendleft(section)
                return
            await self._execution.perform(step)
            if isinstance(step, MeasurePoint):  # stored: whatever fails now, it is not measured again
                self._on_measured(step.stop)
            await self._tick()

    async def _confirm_again(self) -> bool:
        """Have a person confirm where records were refused since the last time; returns whether one did."""
        refused = self._journal.interrupted
        if refused is None:
            return False
        why = f"The database could not be written for a while ({refused.rstrip('.')}); nothing is missing."
        await self._wait_for_person(SessionState.AWAITING_CONFIRMATION, f"{why} {CELL_CLEAR}")
        return True

    async def _confirm_added(self) -> None:
        asked = frozenset(self._added)
        what = "The configurations that were added to the plan come next."
        await self._wait_before([stop for stop in self._plan.stops if stop.config in asked], what)
        self._added -= asked  # not those that came while the question was open

    def _on_measured(self, stop: PlannedStop) -> None:
        self._done.add(stop.config)
        self._pace.end_stop(measured=True)
        self._measured = True
        self._failures_in_a_row = 0

    async def _tick(self) -> None:
        self._now_s = await self._cell.clock.now_s()
        self._pace.tick(self._now_s)

    async def _on_interruption(self, section: Section, error: Exception) -> None:
        if isinstance(error, MotionForbiddenError):
            if self._standing.wish is not None:  # asked for between two looks; the next section heeds it
                self._agenda.appendleft(section)
                return
        else:
            await self._cell.tracker.close()
            await self._cell.robot_controller.close()
        await self._wait_for_person(
            SessionState.AWAITING_CONFIRMATION, f"{_sentence(str(error))} Put it right. {CELL_CLEAR}"
        )
        await self._take_up_again(section, str(error))

    async def _take_up_again(self, section: Section, reason: str) -> None:
        stop = section.stop
        if stop is None:
            self._agenda.appendleft(section)
        elif stop.config not in self._done:
            self._interrupted_at[stop.config] += 1
            if self._interrupted_at[stop.config] < _INTERRUPTIONS_PER_STOP:
                self._agenda.appendleft(section)
            else:
                await self._skip(stop, f"The session was interrupted here twice: {reason}")
        if stop is not None and self._execution.fixed_nests.registered:
            self._agenda.appendleft(references(len(self._cell.fixed_nests)))
        if section != opening():
            self._agenda.appendleft(opening())

    async def _on_foreign_tracker(self, section: Section, question: str) -> None:
        await self._wait_for_person(SessionState.AWAITING_CONFIRMATION, f"{question} {CELL_CLEAR}")
        if section != opening():
            self._agenda.appendleft(section)
        if self._execution.fixed_nests.registered:  # also of one that was put back: it was moved
            self._execution.fixed_nests.distrust()
            self._agenda.appendleft(registration(self._plan, len(self._cell.fixed_nests)))
        self._agenda.appendleft(opening())

    async def _on_failed_measurement(self, section: Section, reason: str) -> None:
        stop = section.stop
        if stop is None:
            await self._pause(f"While {section.title}: {reason}")
            self._agenda.appendleft(section)
            return
        self._failures_in_a_row += 1
        suspect = not self._measured or self._failures_in_a_row >= self._plan.failures_in_a_row
        if suspect and stop.config not in self._paused_at:
            self._paused_at.add(stop.config)
            await self._pause(
                f"Configuration {stop.config} could not be measured: {_sentence(reason)} "
                f"{self._why_suspect()} Check the tracker and its line of sight, then resume."
            )
            self._agenda.appendleft(section)
        else:
            await self._skip(stop, reason)

    def _why_suspect(self) -> str:
        if not self._measured:
            return "Nothing has been measured since the session was last started."
        return f"It is number {self._failures_in_a_row} in a row."

    async def _on_attention_needed(self, section: Section, reason: str) -> None:
        await self._pause(reason)
        self._agenda.appendleft(section)
        if self._execution.fixed_nests.registered:
            self._execution.fixed_nests.distrust()
            self._agenda.appendleft(registration(self._plan, len(self._cell.fixed_nests)))

    async def _pause(self, reason: str) -> None:
        await self._wait_for_person(SessionState.PAUSED, reason)

    async def _skip(self, stop: PlannedStop, reason: str) -> None:
        await self._journal.stop_skipped(StopSkipped(stop.config, self._now_s, reason))
        self._pace.end_stop(measured=False)


def _sentence(text: str) -> str:
    """Return `text` with a full stop; drivers' errors come with and without."""
    return text if text.rstrip().endswith((".", "!", "?")) else f"{text.rstrip()}."
