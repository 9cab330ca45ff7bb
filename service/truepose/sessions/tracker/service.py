"""Tracker sessions: whether this cell can do a plan, how they start, what may be added to them."""

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from truepose.domain.cell import Cell
from truepose.domain.ledger import LedgerEntry
from truepose.domain.session import PlannedStop, SessionPlan
from truepose.messages.message import Text, message
from truepose.planning.tracker.added_stops import Addition, WantedStop, addition
from truepose.planning.workspace.bodies import CellBodies, bodies_of, first_obstruction
from truepose.planning.workspace.path_clearance import path_obstruction, ways_between
from truepose.sessions.engine.ledger import Ledger
from truepose.sessions.engine.robot import WatchfulRobot
from truepose.sessions.engine.states import has_ended, words
from truepose.sessions.engine.ways import judged_ways, look_in, refuse_blocked
from truepose.sessions.errors import NotNowError
from truepose.sessions.kind_service import UnattendedSessionService
from truepose.sessions.service import SessionService
from truepose.sessions.tracker.cell import SessionCell
from truepose.sessions.tracker.dry_run import check_plan, motion_limits
from truepose.sessions.tracker.runner import TrackerRunner
from truepose.sessions.tracker.state import situation
from truepose.sessions.tracker.steps import extended_plan
from truepose.storage.ledger.added_stops import AddedStopsRepository
from truepose.storage.ledger.entries import SessionLedger
from truepose.storage.records import AddedStops, RequestKey, SessionRecord, SessionSetup
from truepose_drivers.api import MotionLimits


def path_warnings_of_plan(cell: Cell, plan: SessionPlan) -> Text:
    """Return what to watch on the ways of a plan; raises PlanRefusedError where this cell cannot do it."""
    require_fit(cell, plan)
    bodies = bodies_of(cell)
    refuse_blocked(first_obstruction(bodies, plan.stops, plan.approach_offset_rad))
    return judged_ways(bodies, ways_between(plan.stops, plan.approach_offset_rad))


def judged_addition(cell: Cell, plan: SessionPlan, added: Sequence[PlannedStop]) -> Text:
    """Return what to watch on the ways to added stops; raises PlanRefusedError where one cannot be."""
    # With the last stop of the plan, from where the arm comes to the first that is added.
    return judged_ways(bodies_of(cell), ways_between((*plan.stops[-1:], *added), plan.approach_offset_rad))


def require_fit(cell: Cell, plan: SessionPlan, done: frozenset[int] = frozenset()) -> None:
    """Raise PlanRefusedError for what no session can do; configurations in `done` need not be reached."""
    limits = motion_limits(cell.robot, cell.limits.joints or cell.robot.joint_limits, plan)
    check_plan(plan, cell.robot, cell.nests, cell.fixed_nests, limits, done)


def refuse_below_floor(
    bodies: CellBodies, stops: Sequence[PlannedStop], approach_offset_rad: float | None
) -> None:
    """Raise PlanRefusedError for the first stop, else the first way to one, that leads through the floor."""
    refuse_blocked(first_obstruction(bodies, stops, approach_offset_rad, floor_only=True))
    refuse_blocked(path_obstruction(bodies, ways_between(stops, approach_offset_rad), floor_only=True))


WhenFinished = Callable[[int], Awaitable[None]]
MakeRunner = Callable[[SessionPlan, SessionCell, Ledger, tuple[LedgerEntry, ...]], TrackerRunner]


@dataclass(frozen=True, slots=True)
class WantedStops:
    """Configurations that a person wants to add to a session."""

    configurations: Sequence[WantedStop]
    leave_out_unfit: bool = False
    diagnosis_id: int | None = None  # which proposed them, to be run again


class TrackerSessions(UnattendedSessionService[TrackerRunner]):
    """Sessions in which the tracker measures and nobody is in the cell."""

    roles = frozenset({"calibration", "validation"})
    called = "tracker session"
    no_tracker = ""

    def __init__(
        self,
        desk: SessionService,
        additions: AddedStopsRepository,
        when_finished: WhenFinished,
        make_runner: MakeRunner = TrackerRunner,
    ) -> None:
        super().__init__(desk)
        self._additions = additions
        self._when_finished = when_finished
        self._make_runner = make_runner

    async def add_stops(
        self, session_id: int, wanted: WantedStops, person: str, key: RequestKey | None = None
    ) -> Addition:
        """Add configurations to the plan of a session that has not ended; return them as its stops.

        Before the robot goes there a person is asked, as before every first motion. A diagnosis that is
        named is run again once the session has finished. Raises NotFoundError, NotNowError,
        PersonMissingError, PersonUnknownError, WorkSpaceError, PlanRefusedError, CellChangedError,
        KeyReusedError.
        """
        desk = self.desk
        name = desk.present.require_person(person)
        async with desk.turn:  # two additions at once must not take the same numbers
            await self.get(session_id)
            earlier = None if key is None else await self._additions.answered(key)
            if earlier is not None:
                return Addition(earlier.stops, ())
            await desk.present.require_unchanged()
            plan = await desk.sessions.plan(session_id)
            cell = desk.present.bound((await desk.sessions.setup(session_id)).cell)
            found = addition(cell, plan, wanted.configurations, leave_out_unfit=wanted.leave_out_unfit)
            notice = await asyncio.to_thread(judged_addition, cell, plan, found.stops)
            added = AddedStops(session_id, name, found.stops, wanted.diagnosis_id)
            await self._take_up(added, cell, plan, key)
            return replace(found, notice=notice)

    async def _take_up(
        self, added: AddedStops, cell: Cell, plan: SessionPlan, key: RequestKey | None
    ) -> None:
        async def keep() -> None:
            await self._additions.add(added, key)

        runner = self.running(added.session_id)
        if runner is not None:
            await runner.add_stops(added.stops, keep)
            return
        # Asked only now: the session may have ended since.
        record = await self.get(added.session_id)
        if has_ended(record.state):
            raise NotNowError(
                message("session.refused.session_plan_another", session=record.id, state=words(record.state))
            )
        entries = [line.entry for line in await self.desk.ledger.whole(record.id)]
        require_fit(cell, extended_plan(plan, added.stops), _done(plan, cell, entries))
        await keep()

    # what the desk asks for

    async def stored_plan(self, session_id: int) -> SessionPlan:
        """Return what a session does, with what was added to it; raises NotFoundError."""
        return await self.desk.sessions.plan(session_id)

    def of_another_kind(self, record: SessionRecord) -> NotNowError:
        """Return what is raised of a session of another kind."""
        return NotNowError(message(self.desk.kind_of(record).no_tracker, session=record.id))

    async def runner(
        self, record: SessionRecord, setup: SessionSetup, ledger: SessionLedger
    ) -> TrackerRunner:
        """Return what runs a session, from the lines of its ledger; nothing moves yet."""
        plan = await self.desk.sessions.plan(record.id)
        first_pass = await self.desk.is_first_pass(setup)
        cell = self._cell(setup, await self.desk.speed_limits(setup), first_pass=first_pass)
        # Only what is left: the arm does not go again to what was measured, whatever the floor is said to be
        # by now.
        left = situation(plan, len(cell.fixed_nests), ledger.earlier).left
        bodies = bodies_of(self.desk.present.bound(setup.cell))
        await asyncio.to_thread(refuse_below_floor, bodies, left, plan.approach_offset_rad)
        # On a thread: it goes through the whole plan first.
        return await asyncio.to_thread(self._make_runner, plan, cell, ledger, ledger.earlier)

    async def follow(self, session_id: int) -> None:
        """Do what was wanted after the session."""
        await self._when_finished(session_id)

    def _cell(self, setup: SessionSetup, speed: MotionLimits, *, first_pass: bool) -> SessionCell:
        rack, cell = self.desk.rack, self.desk.present.bound(setup.cell)
        return SessionCell(
            tracker=rack.tracker if cell.camera is None else rack.camera,
            robot_controller=WatchfulRobot(rack.robot, cell.robot.joint_limits),
            clock=rack.clock,
            robot=cell.robot,
            base=cell.base_nominal,
            nests=cell.nests,
            fixed_nests=cell.fixed_nests,
            look_at_ways=look_in(bodies_of(cell)),
            tracker_position_mm=cell.tracker_position_mm,
            fixed_nests_seen_mm=cell.fixed_nests_seen_mm,
            joint_limits=cell.limits.joints or cell.robot.joint_limits,
            speed_limits=speed,
            first_pass=first_pass,
            certified_lengths=cell.certified_lengths,
            attachment=setup.attachment,
            expected=rack.expected("tracker" if cell.camera is None else "pose_tracker"),
            camera=cell.camera,
        )


def _done(plan: SessionPlan, cell: Cell, entries: Iterable[LedgerEntry]) -> frozenset[int]:
    """Return the configurations that were measured or skipped."""
    left = {stop.config for stop in situation(plan, len(cell.fixed_nests), entries).left}
    return frozenset(stop.config for stop in plan.stops) - left
