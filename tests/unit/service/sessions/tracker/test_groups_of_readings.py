"""A test of drift on a fake cell: approaches of their own, work between groups, an early end."""

import asyncio
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain import asking
from tests.helpers.domain.asking import question
from tests.helpers.machine import HANGS_S
from tests.unit.service.sessions.tracker.fakes import NESTS, FakeCell, make_plan
from tests.unit.service.sessions.tracker.operators import PatientOperator, run_session, until
from truepose.domain.ledger import EntryKind
from truepose.domain.session import PlannedStop, SessionState, Work
from truepose.messages.catalogue import english
from truepose.sessions.engine.commands import CommandName, OperatorCommand
from truepose.sessions.errors import PlanRefusedError
from truepose.sessions.tracker.dry_run import dry_run
from truepose.sessions.tracker.runner import TrackerRunner
from truepose.sessions.tracker.state import situation

_HERE = (0.0, 0.3, 0.1, 0.0, 0.4, 0.0)
_FROM = (0.1, 0.3, 0.1, 0.0, 0.4, 0.0)
_ROUND = ((0.2, 0.4, 0.0, 0.0, 0.5, 0.1), (0.0, 0.5, 0.2, 0.1, 0.3, 0.0))
_EVERY_S = 1800.0


def drift_plan(groups, **changes):
    """Two visits a group, half an hour between two groups."""
    stops = tuple(
        PlannedStop(
            2 * group + visit + 1,
            _HERE,
            1,
            begin_rad=_FROM,
            group=group + 1,
            work=Work(_EVERY_S * group, _ROUND) if group and not visit else None,
        )
        for group in range(groups)
        for visit in range(2)
    )
    return make_plan(
        stops=stops, role="validation", approach_offset_rad=None, ends_when_settled=True, **changes
    )


class WarmingTracker:
    """The arm goes along x by a way over the hours since the first reading."""

    def __init__(self, cell, way_mm):
        self._cell, self._way_mm, self._first_s = cell, way_mm, None
        self._measure = cell.tracker.measure_point
        cell.tracker.measure_point = self.measure_point

    async def measure_point(self, *, duration_s):
        if self._cell.tracker.on_the_arm:
            now_s = self._cell.clock.time_s
            self._first_s = now_s if self._first_s is None else self._first_s
            self._cell.tracker.arm_error_mm = np.array([self._way_mm((now_s - self._first_s) / 3600), 0, 0])
        return await self._measure(duration_s=duration_s)


async def test_a_visit_begins_where_its_stop_says(cell):
    await run_session(cell, drift_plan(1))

    assert cell.robot.moves == [_FROM, _HERE, _FROM, _HERE]
    assert [point.group for point in cell.journal.points] == [1, 1]


async def test_whoever_starts_it_is_told_that_it_begins_from_cold():
    cell, operator = FakeCell(), PatientOperator()
    await run_session(cell, drift_plan(2), operator)
    killed = tuple(entry for entry in cell.journal.entries if entry.time_s < 1000.0 + _EVERY_S)
    later = PatientOperator()
    await run_session(FakeCell(), drift_plan(2), later, entries=killed)
    other = PatientOperator()
    await run_session(FakeCell(), make_plan(1), other)

    assert [("from cold" in one.questions[0]) for one in (operator, later, other)] == [True, False, False]


async def test_the_arm_works_until_the_next_group_is_due(cell):
    await run_session(cell, drift_plan(2))

    times = [point.time_s for point in cell.journal.points]
    assert _EVERY_S < times[2] - times[0] < _EVERY_S + 20.0  # a motion, rest and a reading later
    worked = cell.robot.moves[4:-4]
    assert worked[:4] == [*_ROUND, *_ROUND]
    assert set(worked) == set(_ROUND)
    assert len(worked) > 100


@pytest.mark.parametrize("later_s", range(5))
async def test_a_round_is_gone_to_its_end(later_s):
    """The way to the next visit was looked at from the last place of a round, and from no other."""
    cell = FakeCell()
    plan = drift_plan(2)
    due = replace(plan.stops[2], work=Work(_EVERY_S + later_s, _ROUND))

    await run_session(cell, replace(plan, stops=(*plan.stops[:2], due, plan.stops[3])))

    assert cell.robot.moves[4:-4] == [*_ROUND] * (len(cell.robot.moves[4:-4]) // 2)


async def test_whoever_goes_on_within_a_round_goes_to_its_next_place(cell):
    runner = TrackerRunner(drift_plan(2), cell.cell, cell.journal)

    async def pause_in_the_midst():
        if len(cell.robot.moves) == 4:  # on the way to the first place
            await asking.pause(runner, "Eva")

    cell.robot.before_move = pause_in_the_midst
    await PatientOperator().attend_from_the_start(runner)

    assert SessionState.PAUSED in [state for state, _, _ in cell.journal.states]
    assert cell.robot.moves[4:8] == [*_ROUND, *_ROUND]


async def test_work_before_a_visit_that_is_left_out_ends_with_its_round(cell):
    runner = TrackerRunner(drift_plan(2), cell.cell, cell.journal)

    async def leave_out():
        if len(cell.robot.moves) == 6:  # the first place of the second round
            act = OperatorCommand(CommandName.SKIP, "Eva", key="k", step_id="stop-3", reason="no time")
            await runner.act(act)

    cell.robot.before_move = leave_out

    assert await PatientOperator().attend_from_the_start(runner) is SessionState.FINISHED
    assert cell.robot.moves[4:] == [*_ROUND, *_ROUND, _FROM, _HERE]
    assert [point.config for point in cell.journal.points] == [1, 2, 4]


async def test_nobody_works_on_before_a_person_looked_where_lines_could_not_be_written(cell):
    runner = TrackerRunner(drift_plan(2), cell.cell, cell.journal)

    async def fill():
        if len(cell.robot.moves) == 3:  # to the last visit before the work
            cell.journal.fill()

    cell.robot.before_move = fill
    run = asyncio.create_task(runner.run())
    await until(lambda: runner.state is SessionState.AWAITING_CONFIRMATION)
    await asking.confirm(runner, "Eva")
    await asyncio.wait_for(cell.journal.refused.wait(), HANGS_S)
    cell.journal.make_room()
    await until(lambda: runner.state is SessionState.AWAITING_CONFIRMATION or len(cell.robot.moves) > 4)
    run.cancel()
    await asyncio.gather(run, return_exceptions=True)

    assert "could not be written for a while" in english(question(runner))
    assert len(cell.robot.moves) == 4


async def test_a_killed_service_goes_on_working_as_if_it_had_not_been_gone(cell):
    await run_session(cell, drift_plan(3))
    entries = cell.journal.entries
    begun = [
        k for k, entry in enumerate(entries) if (entry.kind, entry.step_id) == (EntryKind.BEGUN, "stop-5")
    ]
    killed = tuple(entries[: begun[0] + 1])  # while it works before the third group
    later = FakeCell()
    later.clock.time_s = killed[-1].time_s + 600.0

    ended = await run_session(later, drift_plan(3), entries=killed)

    assert ended is SessionState.FINISHED
    assert [point.config for point in later.journal.points] == [5, 6]
    first_s = cell.journal.points[0].time_s
    assert 2 * _EVERY_S < later.journal.points[0].time_s - first_s < 2 * _EVERY_S + 20.0


async def test_a_clock_that_began_anew_does_not_stretch_the_wait(cell):
    await run_session(cell, drift_plan(2))
    killed = tuple(entry for entry in cell.journal.entries[:-1] if entry.time_s < 1000.0 + _EVERY_S)
    later = FakeCell()
    later.clock.time_s = 5.0

    await run_session(later, drift_plan(2), entries=killed)

    assert later.journal.points[0].time_s < 5.0 + 2 * _EVERY_S


async def test_a_group_that_is_late_is_measured_at_once(cell):
    plan = drift_plan(2)
    await run_session(cell, plan)
    killed = tuple(entry for entry in cell.journal.entries if entry.time_s < 1000.0 + _EVERY_S)
    later = FakeCell()
    later.clock.time_s = 1000.0 + 3 * _EVERY_S

    await run_session(later, plan, entries=killed)

    assert set(later.robot.moves).isdisjoint(_ROUND)


async def test_a_robot_that_got_warm_ends_the_test(cell):
    WarmingTracker(cell, lambda hours: 1.0 - np.exp(-2.0 * hours))

    ended = await run_session(cell, drift_plan(13))

    assert ended is SessionState.FINISHED
    assert len(cell.journal.points) == 2 * 6  # until 2.5 h: exp(-2 * 1.5) of the first hour's rate is left
    assert "less than a tenth" in cell.journal.states[-1][1]
    assert cell.journal.skipped == []


async def test_a_robot_that_drifts_on_is_measured_to_the_end(cell):
    WarmingTracker(cell, lambda hours: 0.05 * hours)

    await run_session(cell, drift_plan(7))

    assert len(cell.journal.points) == 14
    assert cell.journal.states[-1][1] == "Every configuration was measured or skipped."


async def test_the_rest_takes_at_least_until_the_last_group_is_due(cell):
    plan = drift_plan(3)
    await run_session(cell, plan)
    entries = cell.journal.entries
    second = [k for k, entry in enumerate(entries) if entry.kind is EntryKind.MEASURED][1]

    now = situation(plan, 3, entries[: second + 1])

    assert now.progress.remaining_s == pytest.approx(2 * _EVERY_S, abs=30.0)


def test_work_outside_the_limits_is_refused(cell):
    stop = PlannedStop(4, _HERE, 1, work=Work(60.0, ((0.0, 9.0, 0.0, 0.0, 0.0, 0.0),)))

    outside = "The warm-up motions before configuration 4 lie outside the limits"
    with pytest.raises(PlanRefusedError, match=outside):
        TrackerRunner(make_plan(stops=(stop,)), cell.cell, cell.journal)


def test_a_plan_takes_as_long_as_its_last_group_is_late():
    cell = FakeCell().cell

    run = dry_run(drift_plan(3), cell.robot, cell.base, NESTS, 3)

    assert 2 * _EVERY_S <= run.duration_s < 2 * _EVERY_S + 200.0
