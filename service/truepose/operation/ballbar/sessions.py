"""Ballbar sessions under way: one at a time with the tracker's sessions, for they share the robot.

The ledger says where a session stands and the runner what comes next; here is who runs it, finds it again
after a restart, and sees to it that a request that is sent twice is done once.
"""

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass, replace
from typing import Any, Final, TypeAlias

from truepose.analysis.ballbar.assembly import assemble_ballbar_campaign
from truepose.domain.ballbar import BallbarPlan
from truepose.domain.campaign import Campaign
from truepose.domain.errors import TrueposeError
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.people import readable_name
from truepose.domain.robot import FramePlacement
from truepose.domain.session import SessionState
from truepose.operation.ballbar.counting import counting
from truepose.operation.ballbar.plans import BallbarWish, judged, kit_of
from truepose.operation.ballbar.view import BallbarView, Fixed, sight_of
from truepose.operation.devices import Rack
from truepose.operation.one_at_a_time import UNDER_WAY, refuse_beside_another
from truepose.operation.present_cell import PresentCell, speed_limits
from truepose.operation.requests_under_way import RequestsUnderWay
from truepose.operation.session_ledger import SessionLedger
from truepose.operation.watching import Watching
from truepose.sequencing.ballbar.cell import BallbarCell
from truepose.sequencing.ballbar.plan.dry_run import check_plan, motion_limits
from truepose.sequencing.ballbar.precalibration import PreCalibrator
from truepose.sequencing.ballbar.runner import BallbarRunner
from truepose.sequencing.ballbar.situation import Situation, situation
from truepose.sequencing.engine.acts import HALTS, LETS_MOVE, Act, ActName
from truepose.sequencing.engine.halts import ENDED_AT_REST
from truepose.sequencing.engine.motion.plausible_robot import WatchfulRobot
from truepose.sequencing.engine.states import has_ended, words
from truepose.sequencing.errors import NotNowError
from truepose.storage.errors import NotFoundError
from truepose.storage.measurement.ledger import LedgerRepository
from truepose.storage.measurement.sessions import SessionRepository
from truepose.storage.records import ActAnswer, LedgerRecord, Page, RequestKey, SessionRecord, SessionSetup

_LOG: Final = logging.getLogger(__name__)
NOBODY_RUNS: Final = "The program failed and does not run this session now; nothing moves."
_END_ASKED_FOR: Final = "The end was asked for; nothing was in motion."
_PLAN_KEPT_S: Final = 30.0  # a tablet that lost its network is back by then
MakePreCalibrator: TypeAlias = Callable[[SessionSetup], PreCalibrator]
ChoosePoses: TypeAlias = Callable[[SessionSetup, BallbarWish], Awaitable[BallbarPlan]]
MakeRunner: TypeAlias = Callable[..., BallbarRunner]


@dataclass(frozen=True, slots=True)
class _UnderWay:
    session_id: int
    runner: BallbarRunner
    ledger: SessionLedger
    task: asyncio.Task[None]


class BallbarDesk:
    """Plans, runs and finds again ballbar sessions, and passes on what persons ask of them."""

    def __init__(
        self,
        sessions: SessionRepository,
        ledger: LedgerRepository,
        rack: Rack,
        make_precalibrator: MakePreCalibrator,
        choose: ChoosePoses,
        make_runner: MakeRunner = BallbarRunner,
        present: PresentCell | None = None,
    ) -> None:
        self._sessions = sessions
        self._ledger = ledger
        self._rack = rack
        self._make_precalibrator = make_precalibrator
        self._choose = choose
        self._make_runner = make_runner
        self._present = present or PresentCell()
        self._under_way: _UnderWay | None = None
        self._fixed: dict[int, Fixed] = {}
        self._acts = RequestsUnderWay[ActAnswer]()
        self._plans = RequestsUnderWay[int](kept_s=_PLAN_KEPT_S)
        self.watching = Watching()
        self._turn = asyncio.Lock()  # two acts that start at once must not start two sessions

    async def plan(
        self, name: str, setup: SessionSetup, wish: BallbarWish, key: RequestKey | None = None
    ) -> int:
        """Store a planned session and return its number.

        To choose poses takes a while: a request that is repeated meanwhile waits for the same choice. Once
        nobody waits it ends; that of a key goes on a little, for whoever asks again.
        Raises NoBallbarError, PlanRefusedError, KeyReusedError, and what the choice of poses raises.
        """
        if key is None:
            return await self._plan(name, setup, wish, None)
        made = await self._sessions.answered(key)
        if made is not None:
            return made
        return await self._plans.shared(key.key, key, lambda: self._plan_once(name, setup, wish, key))

    async def _plan_once(self, name: str, setup: SessionSetup, wish: BallbarWish, key: RequestKey) -> int:
        """Plan unless that was done between the question whether it was and the answer."""
        made = await self._sessions.answered(key)
        return await self._plan(name, setup, wish, key) if made is None else made

    async def _plan(self, name: str, setup: SessionSetup, wish: BallbarWish, key: RequestKey | None) -> int:
        kit = kit_of(setup)
        plan = wish.given or await self._choose(setup, wish)
        cell = setup.cell
        limits = motion_limits(cell.robot, cell.limits.joints)
        await asyncio.to_thread(check_plan, plan, kit, cell.robot, limits)
        notice = await asyncio.to_thread(judged, cell, plan, kit) if plan is wish.given else ""
        number = await self._sessions.add(name, setup, plan, key)
        if notice:
            await self._sessions.note(number, notice)
        return number

    async def recover(self) -> None:
        """Take up what an earlier service left under way; it awaits a person, nothing moves."""
        for record in await self._sessions.in_state(*UNDER_WAY):
            if record.role == "ballbar":
                try:
                    await self._launch(record.id)
                except Exception as error:
                    # A cell file without its ballbar, whatever else: one session must not keep the service
                    # from starting. The log keeps the traceback, the session a sentence.
                    _LOG.exception("session %d was not taken up", record.id)
                    await self._sessions.note(record.id, f"The session was not taken up: {error}")

    async def act(self, session_id: int, act: Act, key: RequestKey) -> ActAnswer:
        """Do what a person asks, at most once for each key; the same key gets the same answer.

        Raises NotFoundError, KeyReusedError, NotNowError, PersonMissingError, PersonUnknownError,
        ReasonMissingError, WatchingTabletError, DeviceInUseError, MissingDeviceError, PlanRefusedError,
        CellChangedError; after an error nothing was kept and the key is free.
        """
        await self._require(session_id)
        return await self._acts.shared((session_id, key.key), key, lambda: self._decide(session_id, act, key))

    async def view(self, session_id: int) -> BallbarView:
        """Return a session as it stands; raises NotFoundError."""
        fixed = await self._what_is_fixed(session_id)
        under_way = self._of(session_id)
        if under_way is not None:
            runner = under_way.runner
            at_hand = runner.situation, runner.question, under_way.ledger.newest, runner.robot_moving
            return self._view(session_id, fixed, *at_hand, trouble=runner.trouble)
        kept = await self._ledger.page(session_id)
        found = _run_by_nobody(fixed, [record.entry for record in kept])
        newest = kept[-1].id if kept else None
        return self._view(session_id, fixed, found, None, newest, False)

    async def follow(self, session_id: int) -> AsyncIterator[BallbarView]:
        """Yield a session as it stands now and whenever that changes; raises NotFoundError.

        Nothing is asked of the database while the session is under way.
        """
        while True:
            news, under_way = self.watching.news, self._of(session_id)
            version = None if under_way is None else under_way.runner.version
            yield await self.view(session_id)
            await _change(news, under_way, version)

    def runner(self, session_id: int) -> BallbarRunner | None:
        """Return what runs a session; None where nobody does."""
        under_way = self._of(session_id)
        return None if under_way is None else under_way.runner

    def frame_of(self, placement: int) -> FramePlacement | None:
        """Return where the session under way wants the base fixture; None where nobody says."""
        if self._under_way is None:
            return None
        places = self._fixed[self._under_way.session_id].plan.placements
        return next((place.frame for place in places if place.number == placement), None)

    async def campaign(self, session_id: int) -> Campaign:
        """Return the campaign of what counts so far; raises NotFoundError, NothingMeasuredError."""
        fixed = await self._what_is_fixed(session_id)
        kit = kit_of(fixed.setup)
        entries = [record.entry for record in await self._ledger.page(session_id)]
        counts = await asyncio.to_thread(counting, fixed.plan, kit, entries)
        return assemble_ballbar_campaign(f"session {session_id}", fixed.setup, kit, counts)

    async def entries(self, session_id: int, page: Page) -> list[LedgerRecord]:
        """Return what happened, oldest first; raises NotFoundError."""
        await self._require(session_id)
        return await self._ledger.page(session_id, page)

    async def close(self) -> None:
        """Stop what is under way; a motion in progress ends by itself, nothing follows it."""
        if self._under_way is not None:
            self._under_way.task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._under_way.task

    async def _decide(self, session_id: int, act: Act, key: RequestKey) -> ActAnswer:
        known = await self._ledger.answer_to(session_id, key)
        if known is not None:
            return known
        kept = await self._ledger.entry_with(session_id, key.key)
        if kept is not None:  # the service was killed between the entry and its answer
            answer = ActAnswer("That was kept before the service was restarted.", kept.id)
        else:
            answer = await self._do(session_id, act)
        await self._ledger.keep_answer(session_id, key, answer)
        return answer

    async def _do(self, session_id: int, act: Act) -> ActAnswer:
        act = await self._judged(act)
        async with self._turn:
            under_way = self._of(session_id)
            if under_way is None:
                record = await self._require(session_id)
                if act.name is ActName.ABORT and not has_ended(record.state):
                    return await self._end_unstarted(session_id, act)
                await self._require_startable(record, act)
                under_way = await self._launch(session_id)
        try:
            done = await under_way.runner.act(act)
        except TrueposeError:
            await self._give_back_unstarted(under_way)
            raise
        return ActAnswer(done.sentence, done.entry)

    async def _judged(self, act: Act) -> Act:
        """Return the act under the name that is kept; raises what keeps it from being done.

        Anybody may halt the arm, whatever they are called.
        """
        if act.name in HALTS:
            return replace(act, person=readable_name(act.person) or "")
        person = self._present.require_person(act.person)
        if act.name in LETS_MOVE:
            await self._present.require_unchanged()
        return replace(act, person=person)

    async def _require_startable(self, record: SessionRecord, act: Act) -> None:
        """Raise NotNowError, DeviceInUseError, PlanRefusedError where nobody runs a session and none may."""
        planned = record.state is SessionState.PLANNED
        if has_ended(record.state) or (planned and act.name is not ActName.START):
            raise NotNowError(
                f"Session {record.id} is {words(record.state)}; '{act.name}' cannot be done now."
            )
        await refuse_beside_another(self._sessions, record.id)
        if planned:
            self._present.require_same_robot((await self._what_is_fixed(record.id)).setup.cell)

    async def _give_back_unstarted(self, under_way: _UnderWay) -> None:
        """Let others have the devices where a session was not started after all."""
        if under_way.runner.situation.state is SessionState.PLANNED and not under_way.task.done():
            under_way.task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await under_way.task
            self._release(under_way.task)

    async def _end_unstarted(self, session_id: int, act: Act) -> ActAnswer:
        now_s = await self._rack.clock.now_s()
        entry = LedgerEntry("", EntryKind.CONTROL, now_s, act.person, act.tablet, act.key, _END_ASKED_FOR)
        entry = replace(entry, entered=SessionState.ABORTED)
        number = await SessionLedger(session_id, self._ledger, None).append(entry)
        self.watching.tell()
        return ActAnswer(ENDED_AT_REST, number)

    async def _launch(self, session_id: int) -> _UnderWay:
        await self._sessions.require_intact(session_id)
        fixed = await self._what_is_fixed(session_id)
        kept = await self._ledger.page(session_id)
        ledger = SessionLedger(session_id, self._ledger, kept[-1].id if kept else None)
        runner = self._make_runner(
            fixed.plan,
            kit_of(fixed.setup),
            self._cell(fixed.setup),
            ledger,
            self._make_precalibrator(fixed.setup),
            entries=tuple(record.entry for record in kept),
            judges=fixed.sight.judges,
        )
        self._rack.lend(session_id)
        task = asyncio.create_task(self._run(session_id, runner), name=f"ballbar session {session_id}")
        task.add_done_callback(self._release)
        self._under_way = _UnderWay(session_id, runner, ledger, task)
        self.watching.tell()
        return self._under_way

    async def _run(self, session_id: int, runner: BallbarRunner) -> None:
        try:
            await runner.run()
        except Exception:
            # The runner has recorded the failure where the disk let it; the log keeps the traceback.
            _LOG.exception("session %d failed", session_id)

    def _release(self, task: asyncio.Task[None]) -> None:
        """Let others have the devices; a callback, for a task that is cancelled may never have begun."""
        if self._under_way is not None and self._under_way.task is task:
            self._rack.take_back()
            self._under_way = None
            self.watching.tell()

    def _cell(self, setup: SessionSetup) -> BallbarCell:
        cell = self._present.bound(setup.cell)
        return BallbarCell(
            ballbar=self._rack.ballbar,
            robot_controller=WatchfulRobot(self._rack.robot, cell.robot.joint_limits),
            clock=self._rack.clock,
            robot=cell.robot,
            joint_limits=cell.limits.joints,
            speed_limits=speed_limits(cell.limits),
            expected=self._rack.expected(),
            ballbar_device_serial=self._planned_serial(setup),
        )

    def _planned_serial(self, setup: SessionSetup) -> str:
        """Return the number that the cell file named for the ballbar's device at the planning."""
        name = self._rack.name_of("ballbar")
        return next((entry.serial_number for entry in setup.cell.devices if entry.name == name), "")

    def _view(
        self,
        session_id: int,
        fixed: Fixed,
        found: Situation,
        question: str | None,
        newest_entry: int | None,
        robot_moving: bool,
        trouble: str | None = None,
    ) -> BallbarView:
        return BallbarView(
            id=session_id,
            name=fixed.name,
            setup=fixed.setup,
            plan=fixed.plan,
            situation=found,
            question=question,
            newest_entry=newest_entry,
            robot_moving=robot_moving,
            trouble=trouble,
            sight=fixed.sight,
            watching=self.watching.count(session_id),
            motion_notice=self._rack.motion_notice,
            people=self._present.people,
        )

    async def _require(self, session_id: int) -> SessionRecord:
        record = await self._sessions.get(session_id)
        if record.role != "ballbar":
            raise NotFoundError("ballbar session", session_id)
        return record

    async def _what_is_fixed(self, session_id: int) -> Fixed:
        if session_id not in self._fixed:
            record = await self._require(session_id)
            setup = await self._sessions.setup(session_id)
            plan = await self._sessions.ballbar_plan(session_id)
            sight = await asyncio.to_thread(sight_of, setup, plan)
            self._fixed[session_id] = Fixed(record.name, setup, plan, sight)
        return self._fixed[session_id]

    def _of(self, session_id: int) -> _UnderWay | None:
        under_way = self._under_way
        return under_way if under_way is not None and under_way.session_id == session_id else None


def _run_by_nobody(fixed: Fixed, entries: list[LedgerEntry]) -> Situation:
    """Return where a session stands that nobody runs: it never says that it runs."""
    kit = kit_of(fixed.setup)
    found = situation(fixed.plan, kit, entries)
    if found.state not in {SessionState.RUNNING, SessionState.PAUSING, SessionState.ABORTING}:
        return found
    # Also of one whose end was asked for: it can be asked for again, and any other act has it take place.
    waits = LedgerEntry("", EntryKind.CONTROL, entries[-1].time_s, text=NOBODY_RUNS)
    return situation(fixed.plan, kit, [*entries, replace(waits, entered=SessionState.AWAITING_CONFIRMATION)])


async def _change(news: asyncio.Event, under_way: _UnderWay | None, version: int | None) -> None:
    """Return once there are news, or what is under way is no longer at this version."""
    waits: list[asyncio.Future[Any]] = [asyncio.ensure_future(news.wait())]
    if under_way is not None and version is not None:
        waits.append(asyncio.ensure_future(under_way.runner.changed(version)))
    try:
        await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for wait in waits:
            wait.cancel()
