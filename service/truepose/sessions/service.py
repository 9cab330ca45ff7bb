"""The session service: runs sessions of every kind, one at a time, and passes on what persons ask of them.

The ledger says where a session stands and the runner what comes next; here is who runs it, finds it again
after a restart, and sees to it that a request that is sent twice is done once. Nothing moves by any of this:
what was under way when the service ended awaits a named person.
"""

import asyncio
import logging
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

from truepose.domain.errors import RecordRefusedError, TrueposeError
from truepose.domain.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.people import readable_name
from truepose.domain.session import SessionState
from truepose.messages.message import Text, message
from truepose.sessions.cell import CurrentCell, speed_limits
from truepose.sessions.devices import DeviceRegistry
from truepose.sessions.engine.commands import ANSWERS, HALTS, LETS_MOVE, CommandName, OperatorCommand
from truepose.sessions.engine.halts import ENDED_AT_REST
from truepose.sessions.engine.interlocks import reduced_limits
from truepose.sessions.engine.prompts import Prompt
from truepose.sessions.engine.runner import SessionRunner
from truepose.sessions.engine.states import ASKS, has_ended, words
from truepose.sessions.errors import DeviceInUseError, NotNowError
from truepose.sessions.followers import TabletCounter, change
from truepose.sessions.kinds import SessionKind
from truepose.sessions.requests import RequestsUnderWay
from truepose.storage.ledger.entries import LedgerRepository, SessionLedger
from truepose.storage.ledger.sessions import SessionRepository
from truepose.storage.records import CommandAnswer, LedgerRecord, RequestKey, SessionRecord, SessionSetup
from truepose_drivers.api import MotionLimits

_LOG: Final = logging.getLogger(__name__)
_END_ASKED_FOR: Final = message("session.end_asked.still")
_UNDER_WAY: Final = tuple(
    state for state in SessionState if state is not SessionState.PLANNED and not has_ended(state)
)
_KEPT_BEFORE: Final = message("session.kept_before")


@dataclass(frozen=True, slots=True)
class UnderWay:
    """A session, and the task that runs it."""

    session_id: int
    kind: SessionKind[Any]
    runner: SessionRunner[Any]
    ledger: SessionLedger
    task: asyncio.Task[None]


@dataclass(frozen=True, slots=True)
class Attendance:
    """Who runs, follows and is asked by a session now, whatever its kind."""

    newest_entry: int | None  # of its ledger; of one that nobody runs only where its lines were read
    watching: int  # tablets that follow it
    people: tuple[str, ...]  # who may have the arm move; empty: whoever gives a name
    motion_notice: Text | None  # what whoever lets the arm move has to know of its controller
    prompt: Prompt | None = None
    trouble: Text | None = None  # why the session waits for the disk
    robot_moving: bool = False


class SessionService:
    """Starts sessions, passes on acts, gives the devices back; kinds of sessions stand behind it."""

    def __init__(
        self,
        sessions: SessionRepository,
        ledger: LedgerRepository,
        rack: DeviceRegistry,
        present: CurrentCell | None = None,
    ) -> None:
        self.sessions = sessions
        self.ledger = ledger
        self.rack = rack
        self.present = present or CurrentCell()
        self.watching = TabletCounter()
        self.turn = asyncio.Lock()  # two acts that start at once must not start two sessions
        self.now: UnderWay | None = None
        self._kinds: list[SessionKind[Any]] = []
        self._acts = RequestsUnderWay[CommandAnswer]()
        self._tasks: set[asyncio.Task[None]] = set()  # of sessions, with what follows their end

    async def admitted(
        self, kind: SessionKind[Any], session_id: int, act: OperatorCommand
    ) -> OperatorCommand:
        """Return an act that lets the arm move as the other kinds admit it; raises their refusals."""
        # A bar that hangs in the cell concerns every kind of session, and only the ballbar's knows of it
        # (decision 0079).
        for other in self._kinds:
            act = act if other is kind else await other.admit(session_id, act)
        return act

    async def is_first_pass(self, setup: SessionSetup) -> bool:
        """Whether no session of a real robot has finished yet."""
        cell = setup.cell
        # By name and serial number: the second arm of a type has a first session as well.
        return not setup.simulated and not await self.sessions.has_finished(
            cell.robot.name, cell.robot_serial_number
        )

    async def speed_limits(self, setup: SessionSetup) -> MotionLimits:
        """Return the speeds above which nothing moves; reduced ones before the first session has finished."""
        speed = speed_limits(self.present.bound(setup.cell).limits)
        return reduced_limits(speed) if await self.is_first_pass(setup) else speed

    def serve(self, kind: SessionKind[Any]) -> None:
        """Run sessions of this kind too."""
        self._kinds.append(kind)

    def under_way(self, session_id: int) -> UnderWay | None:
        """Return a session with the task that runs it; None where nobody does."""
        return self.now if self.now is not None and self.now.session_id == session_id else None

    def attendance(self, session_id: int) -> Attendance:
        """Return who runs, follows and is asked by a session now."""
        people, under_way = self.present.people, self.under_way(session_id)
        newest = None if under_way is None else under_way.ledger.newest
        found = Attendance(newest, self.watching.count(session_id), people, self.rack.motion_notice)
        if under_way is None:
            return found
        now = under_way.runner.moment
        prompt = None if now.prompt is None else replace(now.prompt, people=people)
        return replace(found, prompt=prompt, trouble=now.trouble, robot_moving=now.robot_moving)

    async def lines_and_attendance(self, session_id: int) -> tuple[Sequence[LedgerRecord], Attendance]:
        """Return the lines of a session that nobody runs, none of one under way, and its attendance."""
        kept = () if self.under_way(session_id) else await self.ledger.whole(session_id)
        now = self.attendance(session_id)
        # Asked again: the session may have been taken up while its lines were read.
        if self.under_way(session_id) is None:
            now = replace(now, newest_entry=kept[-1].id if kept else None)
        return kept, now

    async def changes(self, session_id: int) -> AsyncIterator[None]:
        """Yield now, and whenever a session or who follows it has changed."""
        while True:
            # The event first: whatever changes after it wakes this loop, also while the caller is still busy
            # with what was yielded.
            news, under_way = self.watching.news, self.under_way(session_id)
            runner = None if under_way is None else under_way.runner
            version = None if runner is None else runner.version
            yield
            await change(news, runner, version)

    async def live(self, session_id: int) -> AsyncIterator[Any]:
        """Yield what the instrument of a session sees, whenever the session is under way."""
        while True:
            news, under_way = self.watching.news, self.under_way(session_id)
            if under_way is not None:
                async for sample in under_way.runner.live():
                    yield sample
            await news.wait()  # also behind a run that is over, until there is another one

    async def recover(self) -> None:
        """Find what an earlier service left under way; it awaits a person, nothing moves."""
        for kind, record in await self._left():
            await kind.recover(record)

    async def close(self) -> None:
        """Stop what is under way; a motion in progress ends by itself, nothing follows it."""
        if self.now is not None:
            await self._stop(self.now)
        # With what follows the end of sessions: a diagnosis that is being queued is not cut off.
        await asyncio.gather(*self._tasks, return_exceptions=True)
        try:
            for kind, record in await self._left():
                await kind.leave(record)
        except RecordRefusedError as error:  # the next service finds the session and says so itself
            _LOG.warning("sessions in progress were left as they are: %s", error)

    async def _left(self) -> list[tuple[SessionKind[Any], SessionRecord]]:
        records = await self.sessions.in_state(*_UNDER_WAY)
        return [(kind, record) for record in records for kind in self._kinds if kind.owns(record)]

    def kind_of(self, record: SessionRecord) -> SessionKind[Any]:
        """Return the kind of a session."""
        return next(kind for kind in self._kinds if kind.owns(record))

    async def act(
        self, session_id: int, act: OperatorCommand, key: RequestKey | None = None
    ) -> CommandAnswer:
        """Do what a person asks, at most once for each key; the same key gets the same answer.

        Raises NotFoundError, KeyReusedError, NotNowError, PersonMissingError, PersonUnknownError,
        ReasonMissingError, WatchingTabletError, DeviceInUseError, MissingDeviceError, PlanRefusedError,
        CellChangedError; after these nothing was kept and the key is free. RecordRefusedError where the disk
        refuses the act or its answer; an act that was kept is found by its key when it is sent again.
        """
        kind = self.kind_of(await self.sessions.get(session_id))
        if key is None:
            return await self._do(kind, session_id, act)
        name = (session_id, key.key)
        return await self._acts.shared(name, key, lambda: self._decide(kind, session_id, act, key))

    async def _decide(
        self, kind: SessionKind[Any], session_id: int, act: OperatorCommand, key: RequestKey
    ) -> CommandAnswer:
        known = await self.ledger.answer_to(session_id, key)
        if known is not None:
            return known
        kept = await self.ledger.entry_with(session_id, key.key)
        if kept is not None:  # the service was killed between the entry and its answer
            answer = CommandAnswer(_KEPT_BEFORE, kept.id)
        else:
            answer = await self._do(kind, session_id, act)
        # Before it is sent: a client that never gets the answer asks again, maybe after a restart.
        try:
            await self.ledger.keep_answer(session_id, key, answer)
        except RecordRefusedError:
            # What is on record later has its key there; a halt that holds is not answered with an error.
            if answer.entry is not None:
                raise
        return answer

    async def _do(self, kind: SessionKind[Any], session_id: int, act: OperatorCommand) -> CommandAnswer:
        act = await self._judged(act)
        running = self.under_way(session_id)
        if running is not None:
            # Only of a session that runs: of one that nobody runs yet the question of an earlier run is void,
            # and is put anew (decision 0080).
            _require_question_named(act, running.runner)
        # A halt does not wait for somebody's turn.
        under_way = running or await self._taken_up(kind, session_id, act)
        if isinstance(under_way, CommandAnswer):
            return under_way
        try:
            done = await under_way.runner.ask(await kind.prepare(session_id, act))
        except TrueposeError:
            await self._give_back_unstarted(under_way)
            raise
        return CommandAnswer(done.sentence, done.entry)

    async def _taken_up(
        self, kind: SessionKind[Any], session_id: int, act: OperatorCommand
    ) -> UnderWay | CommandAnswer:
        """Have a session run as an act asks for; an answer where the act ends it as it stands."""
        # Two acts that begin at once must not begin two sessions.
        async with self.turn:
            under_way = self.under_way(session_id)
            if under_way is not None:
                return under_way
            record = await kind.get(session_id)
            # Without taking it up: no device is needed to end what nobody runs, and none may be there.
            if act.name is CommandName.ABORT and not has_ended(record.state):
                return await self._end_unstarted(session_id, act)
            kind.require_startable(record, act)
            return await self.start(kind, record)

    async def _judged(self, act: OperatorCommand) -> OperatorCommand:
        """Return the act under the name that is kept; raises what keeps it from being done.

        Anybody may halt the arm, whatever they are called.
        """
        if act.name in HALTS:
            return replace(act, person=readable_name(act.person) or "")
        person = self.present.require_person(act.person)
        if act.name in LETS_MOVE:
            # At every act that lets the arm move: whoever tightened a limit in the cell file means the next
            # motion (decision 0019).
            await self.present.require_unchanged()
        return replace(act, person=person)

    async def _end_unstarted(self, session_id: int, act: OperatorCommand) -> CommandAnswer:
        """End a session that nobody runs: planned, or left by an earlier service."""
        number = await self.enter(session_id, SessionState.ABORTED, _END_ASKED_FOR, act)
        self.watching.tell()
        return CommandAnswer(ENDED_AT_REST, number)

    async def note(self, session_id: int, step_id: str, text: Text) -> None:
        """Put a sentence on record of a session, by whoever runs it; raises RecordRefusedError."""
        under_way = self.under_way(session_id)
        if under_way is not None:
            await under_way.runner.note(step_id, text)
        else:
            time_s = await self._last_time_s(session_id)
            await self.ledger.append(session_id, LedgerEntry(step_id, EntryKind.NOTED, time_s, text=text))

    async def enter(
        self,
        session_id: int,
        state: SessionState,
        reason: Text,
        act: OperatorCommand | None = None,
        control: Control | None = None,
    ) -> int:
        """Put on record that a session that nobody runs has entered a state; returns the line's number."""
        time_s = await self._last_time_s(session_id)
        entry = LedgerEntry("", EntryKind.CONTROL, time_s, text=reason, entered=state, control=control)
        if act is not None:
            entry = replace(entry, person=act.person or None, tablet=act.tablet or None, key=act.key)
        return await self.ledger.append(session_id, entry)

    async def _last_time_s(self, session_id: int) -> float:
        """Return the cell time of the last line of a session that nobody runs."""
        kept = await self.ledger.whole(session_id)
        return kept[-1].entry.time_s if kept else 0.0

    async def start(self, kind: SessionKind[Any], record: SessionRecord) -> UnderWay:
        """Have a session run beside which no other is under way; the caller holds `turn`.

        Raises DeviceInUseError, MissingDeviceError, PlanRefusedError.
        """
        # Asked of the records and not of `now`: a session that waits for a person after a restart has the
        # cell as well, although nobody runs it.
        for other in await self.sessions.in_state(*_UNDER_WAY):
            if other.id != record.id:
                raise DeviceInUseError(
                    message("session.refused.one_at_a_time", session=other.id, state=words(other.state))
                )
        if record.state is SessionState.PLANNED:
            self.present.require_same_robot((await self.sessions.setup(record.id)).cell)
        return await self.take_up(kind, record)

    async def take_up(self, kind: SessionKind[Any], record: SessionRecord) -> UnderWay:
        """Have a session run from where its ledger ends; the caller holds `turn`, or nobody acts yet."""
        # Before anything is built on its ledger: a line that was changed could let the arm go where nobody
        # planned it to (decision 0024).
        await self.sessions.require_intact(record.id)
        ledger = await self.ledger.of_session(record.id)
        runner = await kind.runner(record, await self.sessions.setup(record.id), ledger)
        # Nothing is awaited from here to `now`: devices are never lent to a session that nobody knows of.
        self.rack.lend(record.id, runner.robot)
        task = asyncio.create_task(self._run(kind, record.id, runner), name=f"session {record.id}")
        self._tasks.add(task)
        # A callback as well, for a task that is cancelled may never have begun.
        task.add_done_callback(self._release)
        task.add_done_callback(self._tasks.discard)
        self.now = under_way = UnderWay(record.id, kind, runner, ledger, task)
        self.watching.tell()
        try:
            await kind.begun(record.id, runner)
        except RecordRefusedError:
            await self._stop(under_way)
            raise
        return under_way

    async def _run(self, kind: SessionKind[Any], session_id: int, runner: SessionRunner[Any]) -> None:
        state = None
        try:
            state = await runner.run()
        except Exception:
            # The runner has recorded the failure where the disk let it; the log keeps the traceback.
            _LOG.exception("session %d failed", session_id)
        # Before what follows the session: nothing of that needs the devices.
        self._release(asyncio.current_task())
        if state is SessionState.FINISHED:
            await self._follow(kind, session_id)

    async def _follow(self, kind: SessionKind[Any], session_id: int) -> None:
        try:
            await kind.follow(session_id)
        except Exception:
            # The session has finished well; what should have followed is in the log.
            _LOG.exception("the follow-up of session %d failed", session_id)

    def _release(self, task: asyncio.Task[None] | None) -> None:
        """Let others have the devices."""
        if self.now is not None and self.now.task is task:
            self.rack.take_back()
            self.now = None
            self.watching.tell()

    async def _give_back_unstarted(self, under_way: UnderWay) -> None:
        """Let others have the devices where a session was not started after all."""
        if under_way.runner.state is SessionState.PLANNED and not under_way.task.done():
            await self._stop(under_way)

    async def _stop(self, under_way: UnderWay) -> None:
        under_way.task.cancel()
        # Not awaited itself: that of whoever stops it would pass for the task's own cancellation.
        await asyncio.wait({under_way.task})
        self._release(under_way.task)


def _require_question_named(act: OperatorCommand, runner: SessionRunner[Any]) -> None:
    """Raise NotNowError where the session waits for an answer and this one does not say to what it is one."""
    asked = runner.prompt if runner.state in ASKS else None
    # An answer without its question is a habit: it would confirm whatever is asked when it arrives (decision
    # 0080).
    if act.name in ANSWERS and act.prompt_id is None and asked is not None:
        raise NotNowError(message("session.refused.question_not_named", prompt=asked.id))
