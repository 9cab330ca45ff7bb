"""Tracker sessions on the simulated cell, over TCP through the real drivers, in cell time.

How exact sessions are on other robots: `tests/thorough/system/sessions/test_exact_sessions.py`.
"""

import asyncio
import time
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.machine import HANGS_S
from tests.system.session_bench import LOOK_S, Bench, bench
from tests.unit.service.sessions.tracker.operators import PatientOperator
from truepose.domain.session import SessionState
from truepose.planning.tracker.plans import plan_calibration, plan_validation
from truepose.sessions.tracker.reflector_monitor import _PERIOD_S
from truepose.sessions.tracker.runner import TrackerRunner
from truepose_drivers.abb_open_abb.driver import OpenAbbRobot, TimeOuts
from truepose_drivers.transports.tcp import TcpLink

SCENARIO = "irb120-tilted"


async def run(opened: Bench, plan, operator=None) -> SessionState:
    runner = TrackerRunner(plan, opened.cell, opened.journal)
    running = asyncio.create_task(runner.run())
    async with asyncio.timeout(HANGS_S):
        return await (operator or PatientOperator(look_s=LOOK_S)).attend(runner, running)


async def true_errors(opened: Bench):
    """Readings minus the simulator's noise-free positions [mm], shape (n, 3)."""
    points = opened.journal.points
    answer = await opened.ask(
        op="positions",
        joints_rad=[point.commanded_rad for point in points],
        nests=[point.nest for point in points],
    )
    return np.array([point.position_world_mm for point in points]) - np.array(answer["positions_mm"])


async def test_a_calibration_session_measures_every_chosen_configuration_to_the_trackers_noise():
    async with bench(SCENARIO, seed=11) as opened:
        plan = plan_calibration(opened.space, 40, seed=1, n_candidates=500)

        ended = await run(opened, plan)

        errors = await true_errors(opened)
    assert ended is SessionState.FINISHED
    assert opened.journal.skipped == []
    assert [point.config for point in opened.journal.points] == [stop.config for stop in plan.stops]
    # tracker 0.0155 mm per axis at 2.6 m, robot 0.0035, registration 0.003: 0.016; the standard
    # deviation of 45 x 3 values is known to 6 %, four of these are allowed for
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(0.016, rel=0.25)
    # the registration shifts all readings together; 0.005 mm for its own uncertainty and 45 readings
    assert np.linalg.norm(errors.mean(axis=0)) < 4 * 0.005


async def test_directions_and_joints_are_kept_as_the_robot_reports_them():
    async with bench(SCENARIO, seed=12) as opened:
        await run(opened, plan_validation(opened.space, 5, seed=3))

    for point in opened.journal.points:
        assert point.direction == (1,) * 6
        off_deg = np.degrees(np.subtract(point.reported_rad, point.commanded_rad))
        assert np.max(np.abs(off_deg)) <= 0.005 + 1e-9  # the protocol's two decimals


async def test_a_tracker_blinded_after_the_registration_pauses_at_the_first_configuration():
    async with bench(SCENARIO, seed=13) as opened:
        operator = PatientOperator(patience=1, look_s=LOOK_S)

        async def blind_after_the_first_look(entry):
            if entry.registration is not None:
                blinded_s = await opened.clock.now_s() + 60.0
                await opened.ask(op="fault", kind="tracker_blinded", from_s=blinded_s)
            read = entry.fixed_nest
            if read is not None and (read.phase, read.fixed_nest) == ("reference", 3):
                await opened.clock.sleep(60.0)

        opened.journal.before = blind_after_the_first_look

        ended = await run(opened, plan_validation(opened.space, 6, seed=2), operator)

    assert ended is SessionState.ABORTED
    assert opened.journal.points == []
    assert "Configuration 1 could not be measured" in operator.questions[1]


async def test_a_reflector_left_out_of_its_nest_skips_the_configurations_that_need_it():
    async with bench(SCENARIO, seed=16) as opened:
        plan = plan_validation(opened.space, 12, seed=5)
        needing = [stop.config for stop in plan.stops if stop.nest == 2]
        assert needing
        assert needing[0] != 1
        await opened.ask(op="fault", kind="smr_missing", nest=2)
        patient_with_rows = replace(plan, failures_in_a_row=20)

        ended = await run(opened, patient_with_rows)

    assert ended is SessionState.FINISHED
    assert [skipped.config for skipped in opened.journal.skipped] == needing


async def test_a_fixed_nest_that_is_knocked_pauses_the_session():
    async with bench(SCENARIO, seed=17) as opened:
        operator = PatientOperator(patience=1, look_s=LOOK_S)

        async def knock_after_the_fifth(entry):
            if entry.point is not None and entry.point.config == 5:
                await opened.ask(op="fault", kind="fixed_nest_moved", nest=2, by_mm=[0.3, 0.0, 0.0])

        opened.journal.before = knock_after_the_fifth

        ended = await run(opened, plan_validation(opened.space, 15, seed=6), operator)

    assert ended is SessionState.ABORTED
    assert len(opened.journal.points) == 10
    assert "nest 2 by 0." in operator.questions[1]


async def test_a_session_waits_in_the_time_of_the_cell_alone(monkeypatch):
    look_s = 0.01
    waited_s, sleep = [], asyncio.sleep

    async def counted(duration_s, *result):
        began_s = time.monotonic()
        try:
            return await sleep(duration_s, *result)
        finally:  # who looks whether the arm stands still has hardly begun to wait when it has arrived
            slept_s = min(duration_s, time.monotonic() - began_s)
            waited_s.extend([slept_s] if duration_s not in {look_s, _PERIOD_S} else [])

    async with bench(SCENARIO, seed=18) as opened:
        plan = plan_validation(opened.space, 40, seed=7)
        monkeypatch.setattr(asyncio, "sleep", counted)

        ended = await run(opened, plan, PatientOperator(look_s=look_s))

        cell_s = await opened.cell.clock.now_s()
    assert ended is SessionState.FINISHED
    assert cell_s > 40 * 4.0  # s of settling and reading a configuration
    # Nobody sleeps in the machine's own time but the operator and whoever shows where the beam is, who look
    # now and then. Guards that look at a device begin a sleep; on a busy machine these add up to a second.
    assert sum(waited_s) < 0.02 * cell_s


async def test_lines_that_stall_are_waited_for():
    async with bench(SCENARIO, seed=31) as opened:
        operator = PatientOperator(look_s=LOOK_S)
        await opened.ask(op="fault", kind="line_stalls")

        ended = await run(opened, plan_validation(opened.space, 3, seed=9), operator)

    assert ended is SessionState.FINISHED
    assert [point.config for point in opened.journal.points] == [1, 2, 3]
    assert len(operator.questions) == 1


@pytest.mark.parametrize("kind", ["robot_hangs", "robot_refuses"])
async def test_a_robot_that_says_nothing_waits_for_a_person_and_goes_on(kind):
    async with bench(SCENARIO, seed=19) as opened:
        impatient = TimeOuts(motion_s=2.0)  # in wall time; the motion itself costs none
        robot = OpenAbbRobot(TcpLink(**opened.robot_address), opened.clock, time_outs=impatient)
        opened.cell = replace(opened.cell, robot_controller=robot)
        await opened.ask(op="fault", kind=kind, move=4)
        # the driver waits for the longest motion at the speed set
        fast = replace(
            plan_validation(opened.space, 4, seed=8), tool_speed_mm_s=1e5, orientation_speed_rad_s=100.0
        )
        operator = PatientOperator(look_s=LOOK_S)

        ended = await run(opened, fast, operator)
        await robot.close()

    assert ended is SessionState.FINISHED
    assert len(operator.questions) == 2
    assert "pendant" in operator.questions[1]
    assert [point.config for point in opened.journal.points] == [1, 2, 3, 4]
