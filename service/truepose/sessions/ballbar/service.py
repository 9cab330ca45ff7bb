"""Ballbar sessions: how they are planned, what runs them, how they are seen and counted."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Final, TypeAlias

from truepose.analysis.campaigns.ballbar import assemble_ballbar_campaign
from truepose.domain.ballbar import BallbarPlan
from truepose.domain.campaign import Campaign
from truepose.domain.cell import BallbarKit
from truepose.domain.errors import text_of
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.robot import FramePlacement
from truepose.domain.session import SessionState
from truepose.messages.message import message
from truepose.planning.workspace.bodies import bodies_of
from truepose.sessions.ballbar.cell import BallbarCell, PreCalibrate
from truepose.sessions.ballbar.dry_run import check_plan
from truepose.sessions.ballbar.planning import (
    BallbarPlanRequest,
    Sight,
    kit_of,
    look_past_fixture_in,
    path_warnings_of_plan,
)
from truepose.sessions.ballbar.removal_check import BarPutAway
from truepose.sessions.ballbar.runner import BallbarRunner
from truepose.sessions.ballbar.situation import Situation, situation
from truepose.sessions.ballbar.valid_readings import counting
from truepose.sessions.engine.commands import CommandName, OperatorCommand
from truepose.sessions.engine.interlocks import motion_limits
from truepose.sessions.engine.robot import WatchfulRobot
from truepose.sessions.engine.states import has_ended, words
from truepose.sessions.engine.ways import look_in
from truepose.sessions.errors import NotNowError
from truepose.sessions.kind_service import SessionKindService
from truepose.sessions.requests import RequestsUnderWay
from truepose.sessions.service import Attendance, SessionService
from truepose.storage.ledger.entries import SessionLedger
from truepose.storage.queries import Part
from truepose.storage.records import LedgerRecord, Page, RequestKey, SessionRecord, SessionSetup
from truepose_drivers.api import MotionLimits


@dataclass(frozen=True, slots=True)
class Fixed:
    """What of a session never changes."""

    name: str
    setup: SessionSetup
    plan: BallbarPlan
    sight: Sight

    @property
    def kit(self) -> BallbarKit:
        """What the ballbar comes with."""
        return kit_of(self.setup)


@dataclass(frozen=True, slots=True)
class BallbarView(Fixed):
    """A ballbar session as it stands now."""

    id: int
    situation: Situation
    attendance: Attendance


_LOG: Final = logging.getLogger(__name__)
NOBODY_RUNS: Final = message("session.program_stopped")
_REMEMBERED: Final = 8  # sessions whose plan and judges wait in memory for the next look at them
_PLAN_KEPT_S: Final = 30.0  # a tablet that lost its network is back by then
MakePreCalibrator: TypeAlias = Callable[[SessionSetup], PreCalibrate]
ChoosePoses: TypeAlias = Callable[[SessionSetup, BallbarPlanRequest], Awaitable[BallbarPlan]]
MakeRunner: TypeAlias = Callable[..., BallbarRunner]


class BallbarSessions(SessionKindService[BallbarRunner]):
    """Sessions in which a person in the cell connects the ballbar."""

    roles = frozenset({"ballbar"})
    called = "ballbar session"
    no_tracker = "session.refused.act_of_ballbar"
    by_calibrator = True
    shown_on_tablet = True

    def __init__(
        self,
        desk: SessionService,
        make_precalibrator: MakePreCalibrator,
        choose: ChoosePoses,
        make_runner: MakeRunner = BallbarRunner,
    ) -> None:
        super().__init__(desk)
        self._removal = BarPutAway(desk.sessions, desk.ledger, desk.rack, desk.note)
        self._make_precalibrator = make_precalibrator
        self._choose = choose
        self._make_runner = make_runner
        self._fixed: dict[int, Fixed] = {}
        self._plans = RequestsUnderWay[int](kept_s=_PLAN_KEPT_S)

    async def plan(
        self, name: str, setup: SessionSetup, wish: BallbarPlanRequest, key: RequestKey | None = None
    ) -> int:
        """Store a planned session and return its number.

        To choose poses takes a while: a request that is repeated meanwhile waits for the same choice. Once
        nobody waits it ends; that of a key goes on a little, for whoever asks again.
        Raises NoBallbarError, PlanRefusedError, KeyReusedError, and what the choice of poses raises.
        """
        if key is None:
            return await self._plan(name, setup, wish, None)
        # Before the choice of poses, which takes a minute: a repeated request finds what the first one made.
        made = await self.desk.sessions.answered(key)
        if made is not None:
            return made
        return await self._plans.shared(key.key, key, lambda: self._plan_once(name, setup, wish, key))

    async def _plan_once(
        self, name: str, setup: SessionSetup, wish: BallbarPlanRequest, key: RequestKey
    ) -> int:
        """Plan unless that was done between the question whether it was and the answer."""
        made = await self.desk.sessions.answered(key)
        return await self._plan(name, setup, wish, key) if made is None else made

    async def _plan(
        self, name: str, setup: SessionSetup, wish: BallbarPlanRequest, key: RequestKey | None
    ) -> int:
        plan = wish.given or await self._choose(setup, wish)
        await self.require_possible(setup, plan)
        given = plan is wish.given
        notice = (
            await asyncio.to_thread(path_warnings_of_plan, setup.cell, plan, kit_of(setup)) if given else ""
        )
        return await self.desk.sessions.add(name, setup, plan, key, notice)

    async def require_possible(self, setup: SessionSetup, plan: BallbarPlan) -> None:
        """Raise PlanRefusedError where robot or kit cannot do what is planned."""
        robot, limits = setup.cell.robot, setup.cell.limits.joints
        await asyncio.to_thread(check_plan, plan, kit_of(setup), robot, motion_limits(robot, limits))

    async def view(self, session_id: int) -> BallbarView:
        """Return a session as it stands; raises NotFoundError."""
        fixed = await self._what_is_fixed(session_id)
        kept, now = await self.desk.lines_and_attendance(session_id)
        runner = self.running(session_id)
        by_nobody = [record.entry for record in kept]
        # The runner's own situation where there is one: it knows halts and refusals that are not on record
        # yet.
        found = _run_by_nobody(fixed, by_nobody) if runner is None else runner.situation
        return BallbarView(fixed.name, fixed.setup, fixed.plan, fixed.sight, session_id, found, now)

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
        entries = [record.entry for record in await self.desk.ledger.whole(session_id)]
        counts = await asyncio.to_thread(counting, fixed.plan, fixed.kit, entries)
        return assemble_ballbar_campaign(f"session {session_id}", fixed.setup, fixed.kit, counts)

    async def entries(self, session_id: int, page: Page) -> Part[LedgerRecord]:
        """Return what happened, oldest first; raises NotFoundError."""
        await self.get(session_id)
        return await self.desk.ledger.page(session_id, page)

    # what the desk asks for

    async def stored_plan(self, session_id: int) -> BallbarPlan:
        """Return what a session does; raises NotFoundError."""
        return await self.desk.sessions.ballbar_plan(session_id)

    def require_startable(self, record: SessionRecord, act: OperatorCommand) -> None:
        """Raise NotNowError where a session has ended, or is planned and would not be started."""
        planned = record.state is SessionState.PLANNED
        if has_ended(record.state) or (planned and act.name is not CommandName.START):
            raise NotNowError(
                message(
                    "session.refused.session_act", session=record.id, state=words(record.state), act=act.name
                )
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

    async def admit(self, session_id: int, act: OperatorCommand) -> OperatorCommand:
        """Return an act with why the ballbar counts as off; see `BarPutAway`."""
        return await self._removal.judged(session_id, act)

    async def recover(self, record: SessionRecord) -> None:
        """Take up a session at once: its ledger says where it stands, and it awaits a person."""
        try:
            await self.desk.take_up(self, record)
        except Exception as error:
            # A cell file without its ballbar, whatever else: one session must not keep the service
            # from starting. The log keeps the traceback, the session a sentence.
            _LOG.exception("session %d could not be resumed", record.id)
            await self.desk.sessions.note(record.id, message("session.not_taken_up", why=text_of(error)))

    def _cell(self, setup: SessionSetup, speed: MotionLimits) -> BallbarCell:
        cell = self.desk.present.bound(setup.cell)
        bodies = bodies_of(cell)
        return BallbarCell(
            ballbar=self.desk.rack.ballbar,
            robot_controller=WatchfulRobot(self.desk.rack.robot, cell.robot.joint_limits),
            clock=self.desk.rack.clock,
            robot=cell.robot,
            look_at_ways=look_in(bodies),
            look_past_fixture=look_past_fixture_in(bodies),
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
            sight = await asyncio.to_thread(Sight, setup, plan, kit_of(setup))
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
    found = situation(fixed.plan, fixed.kit, entries)
    if found.state not in {SessionState.RUNNING, SessionState.PAUSING, SessionState.ABORTING}:
        return found
    # Also of one whose end was asked for: it can be asked for again, and any other act has it take place.
    entered = SessionState.AWAITING_CONFIRMATION
    waits = LedgerEntry("", EntryKind.CONTROL, entries[-1].time_s, text=NOBODY_RUNS, entered=entered)
    return situation(fixed.plan, fixed.kit, [*entries, waits])
