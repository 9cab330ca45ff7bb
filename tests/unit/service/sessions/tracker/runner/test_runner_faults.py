"""Runs in which something goes wrong: what is tried again, skipped, or waits for a person."""

import pytest

from tests.unit.service.sessions.stand_ins import refuse
from tests.unit.service.sessions.tracker.fakes import make_plan
from tests.unit.service.sessions.tracker.operators import PatientOperator, run_session
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.sessions.engine.prompts import CELL_CLEAR
from truepose_drivers.errors import (
    BeamBrokenError,
    BusyError,
    ConnectionLostError,
    DriverError,
    DriverFaultError,
    ImplausibleReadingError,
    NoReplyError,
    ReflectorNotFoundError,
    TargetRefusedError,
)

LOST = ConnectionLostError("the cable was pulled")


async def test_a_large_two_face_error_pauses_before_anything_moves(cell):
    cell.tracker.two_face_mm = 0.2
    operator = PatientOperator(patience=1)

    ended = await run_session(cell, make_plan(), operator)

    assert ended is SessionState.ABORTED
    assert "two-face error is 0.200 mm" in operator.questions[1]
    assert cell.robot.moves == []


async def test_a_blinded_tracker_pauses_the_session_at_the_first_configuration(cell):
    operator = PatientOperator(patience=1)

    async def go_blind():
        cell.tracker.blind = True

    cell.robot.before_move = go_blind

    await run_session(cell, make_plan(5), operator)

    assert "Configuration 1 could not be measured" in operator.questions[1]
    assert len(cell.robot.moves) == 2  # approach and stop of the first configuration
    assert cell.journal.skipped == []


async def test_after_the_tracker_can_see_again_the_first_configuration_is_measured(cell):
    operator = PatientOperator()

    async def go_blind_once():
        cell.tracker.blind = len(operator.questions) == 1

    def see_again(question):
        cell.tracker.blind = False

    cell.robot.before_move = go_blind_once
    operator.before_answer = see_again

    ended = await run_session(cell, make_plan(3), operator)

    assert ended is SessionState.FINISHED
    assert [point.config for point in cell.journal.points] == [1, 2, 3]


async def test_a_configuration_that_fails_again_after_the_pause_is_skipped(cell):
    hidden = make_plan(3).stops[0].joints_rad

    async def hide_one_configuration():
        cell.tracker.blind = False

    cell.robot.before_move = hide_one_configuration
    find = cell.tracker.find_reflector

    async def find_unless_hidden(near_mm, *, search_radius_mm):
        cell.tracker.blind = cell.robot.joints == hidden
        await find(near_mm, search_radius_mm=search_radius_mm)

    cell.tracker.find_reflector = find_unless_hidden

    ended = await run_session(cell, make_plan(3))

    assert ended is SessionState.FINISHED
    assert [skipped.config for skipped in cell.journal.skipped] == [1]
    assert [point.config for point in cell.journal.points] == [2, 3]


async def test_one_reflector_not_found_later_is_skipped_with_its_reason(cell):
    plan = make_plan(4)
    gone = ReflectorNotFoundError("no reflector near nest 1")
    refuse(cell.tracker, "find_reflector", gone, lambda _: cell.robot.joints == plan.stops[2].joints_rad)

    ended = await run_session(cell, plan)

    assert ended is SessionState.FINISHED
    assert [(s.config, s.reason) for s in cell.journal.skipped] == [(3, "no reflector near nest 1")]
    assert [point.config for point in cell.journal.points] == [1, 2, 4]


async def test_three_failures_in_a_row_pause_the_session(cell):
    plan = make_plan(9)
    operator = PatientOperator(patience=1)
    in_fog = [stop.joints_rad for stop in plan.stops[2:]]
    fog = ReflectorNotFoundError("fog")
    refuse(cell.tracker, "find_reflector", fog, lambda _: cell.robot.joints in in_fog)

    await run_session(cell, plan, operator)

    _, asked = operator.questions[:2]
    assert "Configuration 5 could not be measured: fog. This is failure number 3 in a row." in asked
    assert [skipped.config for skipped in cell.journal.skipped] == [3, 4]


async def test_a_beam_broken_once_is_found_again_at_the_same_stop(cell):
    operator = PatientOperator()
    broken = BeamBrokenError("the beam was interrupted")
    refuse(cell.tracker, "measure_point", broken, lambda: bool(cell.robot.moves), once=True)

    ended = await run_session(cell, make_plan(2), operator)

    assert ended is SessionState.FINISHED
    assert len(operator.questions) == 1
    assert len(cell.robot.moves) == 4
    assert [point.config for point in cell.journal.points] == [1, 2]


@pytest.mark.parametrize("fault", [LOST, NoReplyError("the robot says nothing")])
async def test_a_lost_robot_waits_for_a_person_and_goes_on_where_it_was(fault, cell):
    cell.robot.faults = {5: fault}  # on the way to configuration 3
    operator = PatientOperator()

    ended = await run_session(cell, make_plan(5), operator)

    assert ended is SessionState.FINISHED
    assert str(fault) in operator.questions[1]
    assert operator.questions[1].endswith(english(CELL_CLEAR))
    assert [point.config for point in cell.journal.points] == [1, 2, 3, 4, 5]
    assert cell.tracker.initialised == 2


@pytest.mark.parametrize(
    "fault",
    [
        DriverFaultError("driver acme failed in measure_point (ValueError: The device has no langid)"),
        ImplausibleReadingError("device of driver acme: it states a point 1e+09 m away"),
        DriverError("a word of a driver of somebody else's"),
        LOST,
    ],
    ids=lambda fault: type(fault).__name__,
)
async def test_a_driver_that_fails_in_a_reading_has_the_session_wait_and_repeats_nothing(fault, cell):
    refuse(cell.tracker, "measure_point", fault, lambda: len(cell.journal.points) == 2, once=True)
    operator = PatientOperator()

    ended = await run_session(cell, make_plan(4), operator)

    assert ended is SessionState.FINISHED
    assert str(fault) in operator.questions[1]
    assert [point.config for point in cell.journal.points] == [1, 2, 3, 4]
    assert cell.tracker.initialised == 2
    assert len(cell.journal.registrations) == 1  # the fixed nests are where they were


async def test_a_clock_lost_right_after_a_reading_was_stored_does_not_repeat_it(cell):
    refuse(cell.clock, "now_s", LOST, lambda: len(cell.journal.points) == 2, once=True)

    ended = await run_session(cell, make_plan(4))

    assert ended is SessionState.FINISHED
    assert [point.config for point in cell.journal.points] == [1, 2, 3, 4]


async def test_a_configuration_on_which_the_robot_stops_twice_is_left_out(cell):
    plan = make_plan(3)
    silent = NoReplyError("the robot says nothing")
    refuse(cell.robot, "move_joints", silent, lambda target_rad: target_rad == plan.stops[1].joints_rad)

    ended = await run_session(cell, plan)

    assert ended is SessionState.FINISHED
    assert [point.config for point in cell.journal.points] == [1, 3]
    assert "interrupted here twice" in cell.journal.skipped[0].reason


async def test_a_refused_target_is_skipped_with_the_robots_words(cell):
    cell.robot.faults = {3: TargetRefusedError("joint 2 out of range")}

    ended = await run_session(cell, make_plan(3))

    assert ended is SessionState.FINISHED
    assert [(s.config, s.reason) for s in cell.journal.skipped] == [(2, "joint 2 out of range")]


@pytest.mark.parametrize("refusal", [TargetRefusedError("joint 2 out of range"), BusyError("it still moves")])
@pytest.mark.parametrize("refused", [2, 3], ids=["the approach", "the stop"])
async def test_after_a_refused_motion_a_person_looks_at_a_way_that_nobody_planned(refused, refusal, cell):
    cell.robot.faults = {refused: refusal}
    operator, moved = PatientOperator(), []
    operator.before_answer = lambda _: moved.append(len(cell.robot.moves))

    ended = await run_session(cell, make_plan(3), operator)

    assert ended is SessionState.FINISHED
    assert moved == [0, refused + 1]
    assert operator.questions[1].lower().startswith(str(refusal))
    assert operator.questions[1].endswith(english(CELL_CLEAR))
    assert [point.config for point in cell.journal.points] == [1, 3]


async def test_a_robot_that_somebody_moved_waits_for_a_person(cell):
    operator = PatientOperator()

    async def jog_after_the_second(entry):
        if entry.point is not None and entry.point.config == 2:
            cell.robot.joints = tuple(joint + 0.1 for joint in cell.robot.joints)

    cell.journal.before = jog_after_the_second

    ended = await run_session(cell, make_plan(4), operator)

    assert ended is SessionState.FINISHED
    assert "5.73 deg away from its position after the last motion" in operator.questions[1]


async def test_an_arm_that_still_moves_when_a_person_confirms_is_left_alone(cell):
    operator = PatientOperator(patience=1)
    sleep = cell.clock.sleep

    async def creep(duration_s):
        cell.robot.joints = tuple(joint + 0.001 for joint in cell.robot.joints)
        await sleep(duration_s)

    cell.clock.sleep = creep

    await run_session(cell, make_plan(), operator)

    assert "The arm is still moving" in operator.questions[1]
    assert cell.robot.moves == []


async def test_an_arm_that_is_not_where_it_was_sent_is_not_measured(cell):
    operator = PatientOperator(patience=1)
    settle = cell.clock.sleep

    async def slip(duration_s):
        await settle(duration_s)
        cell.robot.misreport_rad = 0.01 if cell.robot.moves else 0.0

    cell.clock.sleep = slip

    await run_session(cell, make_plan(3), operator)

    assert "Joint 1 reports a position 0.573 deg from the commanded one" in operator.questions[1]
    assert cell.journal.points == []


async def test_a_stale_robot_state_forbids_motion(cell):
    cell.robot.reading_age_s = 2.5
    operator = PatientOperator(patience=1)

    await run_session(cell, make_plan(), operator)

    assert "2.5 s old; the limit is 2 s" in operator.questions[1]
    assert cell.robot.moves == []
