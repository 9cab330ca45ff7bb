"""Sessions under way: one at a time, each a task of the service, found again after a restart.

The runner decides what a session does; here is who runs it. What was running when the service ended is
found awaiting confirmation: nothing moves until a named person has confirmed.
"""

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

from truepose.domain.cell import Cell
from truepose.domain.errors import RecordRefusedError
from truepose.domain.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.people import readable_name
from truepose.domain.session import PlannedStop, SessionPlan, SessionState
from truepose.operation.ballbar.aside import require_ballbar_aside
from truepose.operation.devices import Rack
from truepose.operation.one_at_a_time import UNDER_WAY, refuse_beside_another
from truepose.operation.present_cell import PresentCell, speed_limits
from truepose.operation.session_ledger import SessionLedger
from truepose.planning.tracker.added_stops import Addition, WantedStop, addition
from truepose.planning.work_volume.cell_bodies import CellBodies, bodies_of
from truepose.planning.work_volume.room_at_stops import what_is_in_the_way
from truepose.planning.work_volume.room_on_ways import ways_between, what_blocks_a_way, what_to_watch
from truepose.sequencing.engine.ledger import Ledger
from truepose.sequencing.engine.motion.plausible_robot import WatchfulRobot
from truepose.sequencing.engine.states import after_restart, has_ended, words
from truepose.sequencing.errors import NotNowError, PlanRefusedError
from truepose.sequencing.tracker.cell import SessionCell
from truepose.sequencing.tracker.dry_run import check_plan, motion_limits
from truepose.sequencing.tracker.plans import extended_plan
from truepose.sequencing.tracker.runner import TrackerRunner
from truepose.sequencing.tracker.situation import situation
from truepose.storage.measurement.added_stops import AddedStopsRepository
from truepose.storage.measurement.ledger import LedgerRepository
from truepose.storage.measurement.sessions import SessionRepository
from truepose.storage.records import AddedStops, RequestKey, SessionRecord, SessionSetup

_LOG: Final = logging.getLogger(__name__)
_RESTARTED: Final = "The service was restarted during the session; look at the cell, then confirm."
_STOPPED: Final = "The service was stopped during the session; look at the cell, then confirm."
WhenFinished = Callable[[int], Awaitable[None]]
MakeRunner = Callable[[SessionPlan, SessionCell, Ledger, tuple[LedgerEntry, ...]], TrackerRunner]


@dataclass(frozen=True, slots=True)
class WantedStops:
    """Configurations that a person wants to add to a session."""

    configurations: Sequence[WantedStop]
    leave_out_unfit: bool = False
    diagnosis_id: int | None = None  # which proposed them, to be run again


@dataclass(frozen=True, slots=True)
class _UnderWay:
    session_id: int
    runner: TrackerRunner
    task: asyncio.Task[None]


class SessionDesk:
    """Starts sessions and passes on what persons ask of them."""

    def __init__(
        self,
        sessions: SessionRepository,
        ledger: LedgerRepository,
        additions: AddedStopsRepository,
        rack: Rack,
        when_finished: WhenFinished,
        make_runner: MakeRunner = TrackerRunner,
        present: PresentCell | None = None,
    ) -> None:
        self._sessions = sessions
        self._ledger = ledger
        self._additions = additions
        self._rack = rack
        self._when_finished = when_finished
        self._make_runner = make_runner
        self._present = present or PresentCell()
        self._under_way: _UnderWay | None = None
        self._tasks: set[asyncio.Task[None]] = set()  # of sessions, with what follows their end
        self._turn = asyncio.Lock()  # two clients that start at once must not start two sessions

    async def recover(self) -> None:
        """Set the state of sessions that an earlier service left running; nothing moves."""
        await self._leave(_RESTARTED)

    async def start(self, session_id: int) -> str:
        """Start a planned session and return what a person is asked before anything moves.

        Raises NotFoundError, NotNowError, DeviceInUseError, MissingDeviceError, PlanRefusedError,
        CellChangedError.
        """
        await self._present.require_unchanged()
        async with self._turn:
            record = await self._get(session_id)
            if record.state is not SessionState.PLANNED:
                raise NotNowError(
                    f"Session {session_id} is {words(record.state)}; only a planned one starts."
                )
            await refuse_beside_another(self._sessions, session_id)
            self._present.require_same_robot((await self._sessions.setup(session_id)).cell)
            return await self._launch(record)

    async def confirm(self, session_id: int, person: str, accepted_serial: str = "") -> str:
        """Confirm what the session asks; takes up a session that a restart interrupted.

        `accepted_serial` is that of a tracker that the session questions. Raises NotFoundError, NotNowError,
        PersonMissingError, PersonUnknownError, PlanRefusedError, CellChangedError.
        """
        name = self._present.require_person(person)
        await self._present.require_unchanged()
        async with self._turn:
            record = await self._get(session_id)
            orphaned = self._running(session_id) is None
            if orphaned and record.state is SessionState.AWAITING_CONFIRMATION:
                await self._launch(record)
        runner = self._require(record)
        await self._require_ballbar_aside(session_id)
        return await runner.confirm(name, accepted_serial)

    async def pause(self, session_id: int, person: str | None) -> str:
        """Ask for a pause; returns when it takes effect. Raises NotFoundError, NotNowError.

        Anybody may, whatever they are called.
        """
        return await self._require(await self._get(session_id)).request_pause(readable_name(person))

    async def resume(self, session_id: int, person: str) -> str:
        """Continue a paused session.

        Raises NotFoundError, NotNowError, PersonMissingError, PersonUnknownError, CellChangedError.
        """
        name = self._present.require_person(person)
        await self._present.require_unchanged()
        runner = self._require(await self._get(session_id))
        await self._require_ballbar_aside(session_id)
        return await runner.resume(name)

    async def abort(self, session_id: int, person: str | None) -> str:
        """Ask for the end; returns when it takes effect. Raises NotFoundError, NotNowError.

        Anybody may, whatever they are called.
        """
        name = readable_name(person)
        async with self._turn:
            record = await self._get(session_id)
            runner = self._running(session_id)
            if runner is None and not has_ended(record.state):
                # Planned, or left by an earlier service: nobody runs it, so nothing is in motion.
                reason = "The end was asked for."
                await self._enter(session_id, SessionState.ABORTED, reason, name)
                return "The session has ended; nothing was in motion."
        return await self._require(record).request_abort(name)

    async def add_stops(
        self, session_id: int, wanted: WantedStops, person: str, key: RequestKey | None = None
    ) -> Addition:
        """Add configurations to the plan of a session that has not ended; return them as its stops.

        Before the robot goes there a person is asked, as before every first motion. A diagnosis that is
        named is run again once the session has finished. Raises NotFoundError, NotNowError,
        PersonMissingError, PersonUnknownError, WorkSpaceError, PlanRefusedError, CellChangedError,
        KeyReusedError.
        """
        name = self._present.require_person(person)
        async with self._turn:  # two additions at once must not take the same numbers
            await self._get(session_id)
            earlier = None if key is None else await self._additions.answered(key)
            if earlier is not None:
                return Addition(earlier.stops, ())
            await self._present.require_unchanged()
            plan = await self._sessions.plan(session_id)
            cell = self._present.bound((await self._sessions.setup(session_id)).cell)
            found = addition(cell, plan, wanted.configurations, leave_out_unfit=wanted.leave_out_unfit)
            notice = await asyncio.to_thread(_judged_ways, bodies_of(cell), plan, found.stops)
            added = AddedStops(session_id, name, found.stops, wanted.diagnosis_id)
            await self._take_up(added, cell, plan, key)
            return replace(found, notice=notice)

    async def _take_up(
        self, added: AddedStops, cell: Cell, plan: SessionPlan, key: RequestKey | None
    ) -> None:
        async def keep() -> None:
            await self._additions.add(added, key)

        runner = self._running(added.session_id)
        if runner is not None:
            await runner.add_stops(added.stops, keep)
            return
        # Asked only now: the session may have ended since.
        record = await self._get(added.session_id)
        left = {stop.config for stop in await self._left(record.id, plan, cell)}
        done = frozenset(stop.config for stop in plan.stops if stop.config not in left)
        _refuse_unfit(record, cell, extended_plan(plan, added.stops), done)
        await keep()

    def question(self, session_id: int) -> str | None:
        """Return what the session asks a person now."""
        runner = self._running(session_id)
        return None if runner is None else runner.question

    def state(self, session_id: int) -> SessionState | None:
        """Return the state that its question belongs to; None of a session that is not under way."""
        runner = self._running(session_id)
        return None if runner is None else runner.state

    def trouble(self, session_id: int) -> str | None:
        """Return why the session waits for the disk; None where it does not."""
        runner = self._running(session_id)
        return None if runner is None else runner.trouble

    async def close(self) -> None:
        """Stop what is under way; a motion in progress ends by itself, nothing follows it."""
        if self._under_way is not None:
            self._under_way.task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._under_way.task
        await asyncio.gather(*self._tasks)
        try:
            await self._leave(_STOPPED)
        except RecordRefusedError as error:  # the next service finds the session and says so itself
            _LOG.warning("what is under way was left as it is: %s", error)

    async def _leave(self, reason: str) -> None:
        for record in await self._sessions.in_state(*UNDER_WAY):
            if record.role == "ballbar":
                continue  # its ledger says where it stands
            state = after_restart(record.state)
            if state is not record.state:
                await self._enter(record.id, state, reason, control=Control.RESTARTED)

    async def _launch(self, record: SessionRecord) -> str:
        await self._sessions.require_intact(record.id)
        plan = await self._sessions.plan(record.id)
        cell = self._cell(await self._sessions.setup(record.id))
        entries = await self._entries(record.id)
        left = situation(plan, len(cell.fixed_nests), entries).left
        if cell.bodies is not None:
            await asyncio.to_thread(_refuse_below_floor, cell.bodies, left, plan.approach_offset_rad)
        ledger = SessionLedger(record.id, self._ledger, None)
        # On a thread: it goes through the whole plan first.
        runner = await asyncio.to_thread(self._make_runner, plan, cell, ledger, entries)
        self._rack.lend(record.id)
        task = asyncio.create_task(self._run(record.id, runner), name=f"session {record.id}")
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        self._under_way = _UnderWay(record.id, runner, task)
        # The question comes first, the state that it puts the session in once the journal has it.
        while not task.done() and (runner.question is None or runner.state is SessionState.PLANNED):
            if runner.trouble is not None:
                await self._give_back_unstarted(task)
                raise RecordRefusedError(f"Session {record.id} was not started. {runner.trouble}")
            await asyncio.sleep(0.001)
        return runner.question or ""

    async def _give_back_unstarted(self, task: asyncio.Task[None]) -> None:
        task.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await task

    async def _run(self, session_id: int, runner: TrackerRunner) -> None:
        try:
            state = await runner.run()
        except Exception:
            # The runner has recorded the failure where the disk let it; the log keeps the traceback.
            _LOG.exception("session %d failed", session_id)
            return
        finally:
            self._rack.take_back()
            self._under_way = None
        if state is SessionState.FINISHED:
            await self._follow(session_id)

    async def _require_ballbar_aside(self, session_id: int) -> None:
        setup = await self._sessions.setup(session_id)
        await require_ballbar_aside(self._rack, setup.cell.ballbar)

    async def _follow(self, session_id: int) -> None:
        try:
            await self._when_finished(session_id)
        except Exception:
            # The session has finished well; what should have followed is in the log.
            _LOG.exception("what should have followed session %d failed", session_id)

    def _cell(self, setup: SessionSetup) -> SessionCell:
        cell = self._present.bound(setup.cell)
        return SessionCell(
            tracker=self._rack.tracker,
            robot_controller=WatchfulRobot(self._rack.robot, cell.robot.joint_limits),
            clock=self._rack.clock,
            robot=cell.robot,
            base=cell.base_nominal,
            nests=cell.nests,
            fixed_nests=cell.fixed_nests,
            tracker_position_mm=cell.tracker_position_mm,
            fixed_nests_seen_mm=cell.fixed_nests_seen_mm,
            joint_limits=cell.limits.joints or cell.robot.joint_limits,
            speed_limits=speed_limits(cell.limits),
            certified_lengths=cell.certified_lengths,
            attachment=setup.attachment,
            expected=self._rack.expected(),
            bodies=bodies_of(cell),
        )

    async def _entries(self, session_id: int) -> tuple[LedgerEntry, ...]:
        return tuple(record.entry for record in await self._ledger.page(session_id))

    async def _left(self, session_id: int, plan: SessionPlan, cell: Cell) -> tuple[PlannedStop, ...]:
        return situation(plan, len(cell.fixed_nests), await self._entries(session_id)).left

    async def _enter(
        self,
        session_id: int,
        state: SessionState,
        reason: str,
        person: str | None = None,
        control: Control | None = None,
    ) -> None:
        """Put on record that a session that nobody runs has entered a state."""
        entries = await self._entries(session_id)
        time_s = entries[-1].time_s if entries else 0.0
        entry = LedgerEntry(
            "", EntryKind.CONTROL, time_s, person, text=reason, entered=state, control=control
        )
        await self._ledger.append(session_id, entry)

    async def _get(self, session_id: int) -> SessionRecord:
        record = await self._sessions.get(session_id)
        if record.role == "ballbar":
            raise NotNowError(
                f"Session {session_id} is one with the ballbar; ask it at ballbar-sessions/{session_id}/acts."
            )
        return record

    def _running(self, session_id: int) -> TrackerRunner | None:
        under_way = self._under_way
        return under_way.runner if under_way is not None and under_way.session_id == session_id else None

    def _require(self, record: SessionRecord) -> TrackerRunner:
        runner = self._running(record.id)
        if runner is None:
            raise NotNowError(f"Session {record.id} is {words(record.state)}; nothing of it is under way.")
        return runner


def _refuse_below_floor(
    bodies: CellBodies, stops: Sequence[PlannedStop], approach_offset_rad: float | None
) -> None:
    """Raise PlanRefusedError for the first stop, else the first way to one, that leads through the floor."""
    ways = ways_between(stops, approach_offset_rad)
    blocked = what_is_in_the_way(bodies, stops, approach_offset_rad, floor_only=True)
    blocked = blocked or what_blocks_a_way(bodies, ways, floor_only=True)
    if blocked is not None:
        raise PlanRefusedError(blocked)


def _judged_ways(bodies: CellBodies, plan: SessionPlan, added: Sequence[PlannedStop]) -> str:
    """Return what to watch on the ways to added stops; raises PlanRefusedError where one cannot be."""
    ways = ways_between((*plan.stops[-1:], *added), plan.approach_offset_rad)
    blocked = what_blocks_a_way(bodies, ways)
    if blocked is not None:
        raise PlanRefusedError(blocked)
    return what_to_watch(bodies, ways)


def _refuse_unfit(record: SessionRecord, cell: Cell, plan: SessionPlan, done: frozenset[int]) -> None:
    """Raise NotNowError for a session that has ended, PlanRefusedError for stops outside the limits."""
    if has_ended(record.state):
        raise NotNowError(
            f"Session {record.id} is {words(record.state)}; plan a new one for what is missing."
        )
    limits = motion_limits(cell.robot, cell.limits.joints or cell.robot.joint_limits, plan)
    check_plan(plan, cell.robot, cell.nests, cell.fixed_nests, limits, done)
