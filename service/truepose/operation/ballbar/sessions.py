"""Ballbar sessions behind the desk: how they are planned, what runs them, how they are seen and counted."""

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import replace
from typing import Final, TypeAlias

from truepose.analysis.ballbar.assembly import assemble_ballbar_campaign
from truepose.domain.measurement.ballbar import BallbarPlan
from truepose.domain.measurement.campaign import Campaign
from truepose.domain.measurement.ledger import EntryKind, LedgerEntry
from truepose.domain.measurement.session import SessionState
from truepose.domain.robot import FramePlacement
from truepose.operation.ballbar.counting import counting
from truepose.operation.ballbar.plans import BallbarWish, judged, kit_of
from truepose.operation.ballbar.view import BallbarView, Fixed, sight_of
from truepose.operation.followers import change
from truepose.operation.requests_under_way import RequestsUnderWay
from truepose.operation.served_kind import ServedKind
from truepose.operation.sessions import SessionDesk
from truepose.sequencing.ballbar.cell import BallbarCell
from truepose.sequencing.ballbar.plan.dry_run import check_plan
from truepose.sequencing.ballbar.precalibration import PreCalibrator
from truepose.sequencing.ballbar.runner import BallbarRunner
from truepose.sequencing.ballbar.situation import Situation, situation
from truepose.sequencing.engine.acts import Act, ActName
from truepose.sequencing.engine.motion.limits import motion_limits
from truepose.sequencing.engine.motion.plausible_robot import WatchfulRobot
from truepose.sequencing.engine.states import has_ended, words
from truepose.sequencing.errors import NotNowError
from truepose.storage.measurement.ledger import SessionLedger
from truepose.storage.parts import Part
from truepose.storage.records import LedgerRecord, Page, RequestKey, SessionRecord, SessionSetup
from truepose_drivers.api import MotionLimits

_LOG: Final = logging.getLogger(__name__)
NOBODY_RUNS: Final = "The program failed and does not run this session now; nothing moves."
_REMEMBERED: Final = 8  # sessions whose plan and judges wait in memory for the next look at them
_PLAN_KEPT_S: Final = 30.0  # a tablet that lost its network is back by then
MakePreCalibrator: TypeAlias = Callable[[SessionSetup], PreCalibrator]
ChoosePoses: TypeAlias = Callable[[SessionSetup, BallbarWish], Awaitable[BallbarPlan]]
MakeRunner: TypeAlias = Callable[..., BallbarRunner]


class BallbarSessions(ServedKind[BallbarRunner]):
    """Sessions in which a person in the cell connects the ballbar."""

    roles = frozenset({"ballbar"})
    called = "ballbar session"

    def __init__(
        self,
        desk: SessionDesk,
        make_precalibrator: MakePreCalibrator,
        choose: ChoosePoses,
        make_runner: MakeRunner = BallbarRunner,
    ) -> None:
        super().__init__(desk)
        self._make_precalibrator = make_precalibrator
        self._choose = choose
        self._make_runner = make_runner
        self._fixed: dict[int, Fixed] = {}
        self._plans = RequestsUnderWay[int](kept_s=_PLAN_KEPT_S)

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
        made = await self.desk.sessions.answered(key)
        if made is not None:
            return made
        return await self._plans.shared(key.key, key, lambda: self._plan_once(name, setup, wish, key))

    async def _plan_once(self, name: str, setup: SessionSetup, wish: BallbarWish, key: RequestKey) -> int:
        """Plan unless that was done between the question whether it was and the answer."""
        made = await self.desk.sessions.answered(key)
        return await self._plan(name, setup, wish, key) if made is None else made

    async def _plan(self, name: str, setup: SessionSetup, wish: BallbarWish, key: RequestKey | None) -> int:
        plan = wish.given or await self._choose(setup, wish)
        await self.require_possible(setup, plan)
        given = plan is wish.given
        notice = await asyncio.to_thread(judged, setup.cell, plan, kit_of(setup)) if given else ""
        number = await self.desk.sessions.add(name, setup, plan, key)
        if notice:
            await self.desk.sessions.note(number, notice)
        return number

    async def require_possible(self, setup: SessionSetup, plan: BallbarPlan) -> None:
        """Raise PlanRefusedError where robot or kit cannot do what is planned."""
        robot, limits = setup.cell.robot, setup.cell.limits.joints
        await asyncio.to_thread(check_plan, plan, kit_of(setup), robot, motion_limits(robot, limits))

    async def view(self, session_id: int) -> BallbarView:
        """Return a session as it stands; raises NotFoundError."""
        fixed = await self._what_is_fixed(session_id)
        runner, under_way = self.running(session_id), self.desk.under_way(session_id)
        if runner is None or under_way is None:
            kept = await self.desk.ledger.whole(session_id)
            found = _run_by_nobody(fixed, [record.entry for record in kept])
            return self._view(session_id, fixed, found, kept[-1].id if kept else None)
        now = runner.moment
        return replace(
            self._view(session_id, fixed, runner.situation, under_way.ledger.newest),
            question=now.question,
            prompt_id=now.prompt_id,
            robot_moving=runner.robot_moving,
            trouble=now.trouble,
        )

    def _view(self, session_id: int, fixed: Fixed, found: Situation, newest_entry: int | None) -> BallbarView:
        return BallbarView(
            id=session_id,
            name=fixed.name,
            setup=fixed.setup,
            plan=fixed.plan,
            situation=found,
            newest_entry=newest_entry,
            sight=fixed.sight,
            watching=self.desk.watching.count(session_id),
            motion_notice=self.desk.rack.motion_notice,
            people=self.desk.present.people,
        )

    async def follow_views(self, session_id: int) -> AsyncIterator[BallbarView]:
        """Yield a session as it stands now and whenever that changes; raises NotFoundError.

        Nothing is asked of the database while the session is under way.
        """
        while True:
            news, runner = self.desk.watching.news, self.running(session_id)
            version = None if runner is None else runner.version
            yield await self.view(session_id)
            await change(news, runner, version)

    def frame_of(self, placement: int) -> FramePlacement | None:
        """Return where the session under way wants the base fixture; None where nobody says."""
        now = self.desk.now
        if now is None or now.kind is not self:
            return None
        fixed = self._fixed.get(now.session_id)
        places = () if fixed is None else fixed.plan.placements
        return next((place.frame for place in places if place.number == placement), None)

    async def campaign(self, session_id: int) -> Campaign:
        """Return the campaign of what counts so far; raises NotFoundError, NothingMeasuredError."""
        fixed = await self._what_is_fixed(session_id)
        kit = kit_of(fixed.setup)
        entries = [record.entry for record in await self.desk.ledger.whole(session_id)]
        counts = await asyncio.to_thread(counting, fixed.plan, kit, entries)
        return assemble_ballbar_campaign(f"session {session_id}", fixed.setup, kit, counts)

    async def entries(self, session_id: int, page: Page) -> Part[LedgerRecord]:
        """Return what happened, oldest first; raises NotFoundError."""
        await self.get(session_id)
        return await self.desk.ledger.page(session_id, page)

    # what the desk asks for

    def require_startable(self, record: SessionRecord, act: Act) -> None:
        """Raise NotNowError where a session has ended, or is planned and would not be started."""
        planned = record.state is SessionState.PLANNED
        if has_ended(record.state) or (planned and act.name is not ActName.START):
            raise NotNowError(
                f"Session {record.id} is {words(record.state)}; '{act.name}' cannot be done now."
            )

    async def runner(
        self, record: SessionRecord, setup: SessionSetup, ledger: SessionLedger
    ) -> BallbarRunner:
        """Return what runs a session, from the lines of its ledger; nothing moves yet."""
        fixed = await self._what_is_fixed(record.id)
        return self._make_runner(
            fixed.plan,
            kit_of(setup),
            self._cell(setup, await self.desk.speed_limits(setup)),
            ledger,
            self._make_precalibrator(setup),
            entries=ledger.earlier,
            judges=fixed.sight.judges,
        )

    async def recover(self, record: SessionRecord) -> None:
        """Take up a session at once: its ledger says where it stands, and it awaits a person."""
        try:
            await self.desk.take_up(self, record)
        except Exception as error:
            # A cell file without its ballbar, whatever else: one session must not keep the service
            # from starting. The log keeps the traceback, the session a sentence.
            _LOG.exception("session %d was not taken up", record.id)
            await self.desk.sessions.note(record.id, f"The session was not taken up: {error}")

    def _cell(self, setup: SessionSetup, speed: MotionLimits) -> BallbarCell:
        cell = self.desk.present.bound(setup.cell)
        return BallbarCell(
            ballbar=self.desk.rack.ballbar,
            robot_controller=WatchfulRobot(self.desk.rack.robot, cell.robot.joint_limits),
            clock=self.desk.rack.clock,
            robot=cell.robot,
            joint_limits=cell.limits.joints,
            speed_limits=speed,
            expected=self.desk.rack.expected(),
            ballbar_device_serial=self._planned_serial(setup),
        )

    def _planned_serial(self, setup: SessionSetup) -> str:
        """Return the number that the cell file named for the ballbar's device at the planning."""
        name = self.desk.rack.name_of("ballbar")
        return next((entry.serial_number for entry in setup.cell.devices if entry.name == name), "")

    async def _what_is_fixed(self, session_id: int) -> Fixed:
        found = self._fixed.pop(session_id, None)
        if found is None:
            record = await self.get(session_id)
            setup = await self.desk.sessions.setup(session_id)
            plan = await self.desk.sessions.ballbar_plan(session_id)
            sight = await asyncio.to_thread(sight_of, setup, plan)
            found = Fixed(record.name, setup, plan, sight)
        self._fixed[session_id] = found  # the one that was asked for last comes last
        self._forget_others()
        return found

    def _forget_others(self) -> None:
        """Forget what was not asked for lately, but for the session under way."""
        for number in [*self._fixed][:-_REMEMBERED]:
            if self.desk.under_way(number) is None:
                del self._fixed[number]


def _run_by_nobody(fixed: Fixed, entries: list[LedgerEntry]) -> Situation:
    """Return where a session stands that nobody runs: it never says that it runs."""
    kit = kit_of(fixed.setup)
    found = situation(fixed.plan, kit, entries)
    if found.state not in {SessionState.RUNNING, SessionState.PAUSING, SessionState.ABORTING}:
        return found
    # Also of one whose end was asked for: it can be asked for again, and any other act has it take place.
    waits = LedgerEntry("", EntryKind.CONTROL, entries[-1].time_s, text=NOBODY_RUNS)
    return situation(fixed.plan, kit, [*entries, replace(waits, entered=SessionState.AWAITING_CONFIRMATION)])
