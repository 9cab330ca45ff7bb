"""A whole session on a fake cell: what is measured, what is kept, what happens when something fails."""

import asyncio
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain import asking
from tests.unit.service.sequencing.tracker.fakes import IRB120, NESTS, FakeCell, make_plan, make_stop
from tests.unit.service.sequencing.tracker.operators import PatientOperator, run_session, until
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.session import SessionState
from truepose.sequencing.engine.motion.nominal_arm import nest_in_world
from truepose.sequencing.engine.prompts import CELL_CLEAR
from truepose.sequencing.errors import NotNowError, PersonMissingError
from truepose.sequencing.tracker.runner import TrackerRunner
from truepose_drivers.api import Environment
from truepose_drivers.errors import (
    BeamBrokenError,
    ConnectionLostError,
    DeviceRefusedError,
    DriverError,
    DriverFaultError,
    ImplausibleReadingError,
    NoReplyError,
    ReflectorNotFoundError,
    TargetRefusedError,
)

LOST = ConnectionLostError("the cable was pulled")


def before_the_end(cell):
    """What a service had on disk that was killed just before the session had finished."""
    return tuple(cell.journal.entries[:-1])


def states(cell):
    return [state for state, _, _ in cell.journal.states]


async def test_every_planned_configuration_is_measured_and_stored_once():
    cell = FakeCell()

    ended = await run_session(cell, make_plan(12))

    assert ended is SessionState.FINISHED
    assert [point.config for point in cell.journal.points] == list(range(1, 13))
    assert states(cell) == [
        SessionState.AWAITING_CONFIRMATION,
        SessionState.RUNNING,
        SessionState.FINISHED,
    ]


async def test_a_stored_point_is_where_the_arm_truly_was_in_the_world():
    cell = FakeCell(azimuth_rad=-1.2)
    plan = make_plan(3)

    await run_session(cell, plan)

    for point, stop in zip(cell.journal.points, plan.stops, strict=True):
        true = nest_in_world(IRB120, cell.cell.base, NESTS, stop.joints_rad, stop.nest)
        # no noise: what remains is the rounding of doubles at 3 m
        assert point.position_world_mm == pytest.approx(true + cell.tracker.arm_error_mm, abs=1e-8)


async def test_a_stop_is_kept_with_everything_known_of_it():
    cell = FakeCell()
    cell.cell = replace(cell.cell, attachment=4)
    stop = make_stop(1, nest=2)

    await run_session(cell, make_plan(stops=(stop, make_stop(2, nest=2, repeat_of=1))))

    first, second = cell.journal.points
    assert first.commanded_rad == first.reported_rad == stop.joints_rad
    assert (first.nest, first.attachment, first.temperature_c) == (2, 4, 23.1)
    assert (first.repeat_of, second.repeat_of) == (None, 1)
    assert first.time_s < second.time_s


async def test_every_stop_is_approached_from_below_on_all_joints():
    cell = FakeCell()
    plan = make_plan(2)

    await run_session(cell, plan)

    stops = [stop.joints_rad for stop in plan.stops]
    assert cell.robot.moves[1::2] == stops
    for before, stop in zip(cell.robot.moves[0::2], stops, strict=True):
        assert np.degrees(np.subtract(stop, before)) == pytest.approx([5.0] * 6)
    assert {point.direction for point in cell.journal.points} == {(1,) * 6}


async def test_without_an_approach_the_direction_is_that_of_the_way_from_stop_to_stop():
    cell = FakeCell()
    plan = make_plan(3, approach_offset_rad=None)

    await run_session(cell, plan)

    way = np.diff([(0.0,) * 6, *[stop.joints_rad for stop in plan.stops]], axis=0)
    assert [point.direction for point in cell.journal.points] == [tuple(np.sign(w)) for w in way]


async def test_nothing_moves_before_a_named_person_has_confirmed():
    cell = FakeCell()
    runner = TrackerRunner(make_plan(), cell.cell, cell.journal)
    running = asyncio.create_task(runner.run())

    await until(lambda: runner.state is SessionState.AWAITING_CONFIRMATION)
    with pytest.raises(PersonMissingError):
        await asking.confirm(runner, "  ")
    for _ in range(100):
        await asyncio.sleep(0)

    assert runner.question == CELL_CLEAR
    assert cell.robot.moves == []
    await asking.confirm(runner, "Eva")
    assert await running is SessionState.FINISHED
    assert (SessionState.RUNNING, "Eva") in [(state, person) for state, _, person in cell.journal.states]


async def test_the_tracker_is_placed_in_the_world_before_the_robot_moves():
    cell = FakeCell()
    moves_at_registration = []
    registered = cell.journal.registered

    async def note_moves(registration):
        moves_at_registration.append(len(cell.robot.moves))
        await registered(registration)

    cell.journal.registered = note_moves

    await run_session(cell, make_plan())

    assert moves_at_registration == [0]
    assert len([r for r in cell.journal.fixed if r.phase == "registration"]) == 15


async def test_fixed_nests_are_read_before_every_tenth_configuration_and_after():
    cell = FakeCell()

    await run_session(cell, make_plan(25))

    references = [reading for reading in cell.journal.fixed if reading.phase == "reference"]
    assert len(references) == 3 * 4  # before, after 10, after 20, after 25
    assert [reading.fixed_nest for reading in references] == [1, 2, 3] * 4


async def test_both_faces_are_compared_and_the_session_measures_on_the_first():
    cell = FakeCell()
    cell.tracker.two_face_mm = 0.02

    await run_session(cell, make_plan())

    # faces differ by 0.04 along z: half of it
    assert cell.journal.registrations[0].two_face_mm == pytest.approx(0.02, abs=1e-9)
    assert cell.tracker.face == 1


async def test_a_large_two_face_error_pauses_before_anything_moves():
    cell = FakeCell()
    cell.tracker.two_face_mm = 0.2
    operator = PatientOperator(patience=1)

    ended = await run_session(cell, make_plan(), operator)

    assert ended is SessionState.ABORTED
    assert "two-face error is 0.200 mm" in operator.questions[1]
    assert cell.robot.moves == []


async def test_a_blinded_tracker_pauses_the_session_at_the_first_configuration():
    cell = FakeCell()
    operator = PatientOperator(patience=1)

    async def go_blind():
        cell.tracker.blind = True

    cell.robot.before_move = go_blind

    await run_session(cell, make_plan(5), operator)

    assert "Configuration 1 could not be measured" in operator.questions[1]
    assert len(cell.robot.moves) == 2  # approach and stop of the first configuration
    assert cell.journal.skipped == []


async def test_after_the_tracker_can_see_again_the_first_configuration_is_measured():
    cell = FakeCell()
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


async def test_a_configuration_that_fails_again_after_the_pause_is_skipped():
    cell = FakeCell()
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


async def test_one_reflector_not_found_later_is_skipped_with_its_reason():
    cell = FakeCell()
    plan = make_plan(4)
    cell.tracker.fixed_nests = cell.tracker.fixed_nests.copy()
    find = cell.tracker.find_reflector

    async def find_but_for_the_third(near_mm, *, search_radius_mm):
        if cell.robot.joints == plan.stops[2].joints_rad:
            raise ReflectorNotFoundError("no reflector near nest 1")
        await find(near_mm, search_radius_mm=search_radius_mm)

    cell.tracker.find_reflector = find_but_for_the_third

    ended = await run_session(cell, plan)

    assert ended is SessionState.FINISHED
    assert [(s.config, s.reason) for s in cell.journal.skipped] == [(3, "no reflector near nest 1")]
    assert [point.config for point in cell.journal.points] == [1, 2, 4]


async def test_three_failures_in_a_row_pause_the_session():
    cell = FakeCell()
    plan = make_plan(9)
    operator = PatientOperator(patience=1)
    find = cell.tracker.find_reflector

    async def find_the_first_two(near_mm, *, search_radius_mm):
        if cell.robot.joints in [stop.joints_rad for stop in plan.stops[2:]]:
            raise ReflectorNotFoundError("fog")
        await find(near_mm, search_radius_mm=search_radius_mm)

    cell.tracker.find_reflector = find_the_first_two

    await run_session(cell, plan, operator)

    assert "Configuration 5 could not be measured: fog. It is number 3 in a row." in operator.questions[1]
    assert [skipped.config for skipped in cell.journal.skipped] == [3, 4]


async def test_a_beam_broken_once_is_found_again_at_the_same_stop():
    cell = FakeCell()
    # 1 look each at three nests after the hit of the search, 10 for the faces, 15, 3; then the stops
    operator = PatientOperator()
    broken = []
    measure = cell.tracker.measure_point

    async def break_the_beam_once(*, duration_s):
        if cell.robot.moves and not broken:
            broken.append(True)
            raise BeamBrokenError("the beam was interrupted")
        return await measure(duration_s=duration_s)

    cell.tracker.measure_point = break_the_beam_once

    ended = await run_session(cell, make_plan(2), operator)

    assert ended is SessionState.FINISHED
    assert len(operator.questions) == 1
    assert len(cell.robot.moves) == 4
    assert [point.config for point in cell.journal.points] == [1, 2]


@pytest.mark.parametrize("fault", [LOST, NoReplyError("the robot says nothing")])
async def test_a_lost_robot_waits_for_a_person_and_goes_on_where_it_was(fault):
    cell = FakeCell()
    cell.robot.faults = {5: fault}  # on the way to configuration 3
    operator = PatientOperator()

    ended = await run_session(cell, make_plan(5), operator)

    assert ended is SessionState.FINISHED
    assert str(fault) in operator.questions[1]
    assert operator.questions[1].endswith(CELL_CLEAR)
    assert [point.config for point in cell.journal.points] == [1, 2, 3, 4, 5]
    assert cell.tracker.initialised == 2


@pytest.mark.parametrize(
    "fault",
    [
        DriverFaultError("driver acme failed in measure_point (ValueError: The device has no langid)"),
        ImplausibleReadingError("device of driver acme: it states a point 1e+09 m away"),
        DriverError("a word of a driver of somebody else's"),
    ],
    ids=lambda fault: type(fault).__name__,
)
async def test_a_driver_that_fails_has_the_session_wait_with_its_sentence(fault):
    cell = FakeCell()
    measure = cell.tracker.measure_point
    failed = []

    async def fail_once(*, duration_s):
        if len(cell.journal.points) == 2 and not failed:
            failed.append(True)
            raise fault
        return await measure(duration_s=duration_s)

    cell.tracker.measure_point = fail_once
    operator = PatientOperator()

    ended = await run_session(cell, make_plan(4), operator)

    assert ended is SessionState.FINISHED
    assert str(fault) in operator.questions[1]
    assert [point.config for point in cell.journal.points] == [1, 2, 3, 4]
    assert cell.tracker.initialised == 2


async def test_a_tracker_lost_in_the_middle_of_a_reading_loses_and_repeats_nothing():
    cell = FakeCell()
    measure = cell.tracker.measure_point
    lost = []

    async def lose_once(*, duration_s):
        if len(cell.journal.points) == 2 and not lost:
            lost.append(True)
            cell.tracker.connected = False
            raise LOST
        return await measure(duration_s=duration_s)

    cell.tracker.measure_point = lose_once

    ended = await run_session(cell, make_plan(4))

    assert ended is SessionState.FINISHED
    assert [point.config for point in cell.journal.points] == [1, 2, 3, 4]
    assert len(cell.journal.registrations) == 1  # the fixed nests are where they were


async def test_a_clock_lost_right_after_a_reading_was_stored_does_not_repeat_it():
    cell = FakeCell()
    now_s = cell.clock.now_s
    lost = []

    async def lose_once():
        if len(cell.journal.points) == 2 and not lost:
            lost.append(True)
            raise LOST
        return await now_s()

    cell.clock.now_s = lose_once

    ended = await run_session(cell, make_plan(4))

    assert ended is SessionState.FINISHED
    assert [point.config for point in cell.journal.points] == [1, 2, 3, 4]


async def test_a_configuration_on_which_the_robot_stops_twice_is_left_out():
    cell = FakeCell()
    plan = make_plan(3)
    move = cell.robot.move_joints

    async def hang_on_the_second(target_rad):
        if target_rad == plan.stops[1].joints_rad:
            raise NoReplyError("the robot says nothing")
        await move(target_rad)

    cell.robot.move_joints = hang_on_the_second

    ended = await run_session(cell, plan)

    assert ended is SessionState.FINISHED
    assert [point.config for point in cell.journal.points] == [1, 3]
    assert "interrupted here twice" in cell.journal.skipped[0].reason


async def test_a_refused_target_is_skipped_with_the_robots_words():
    cell = FakeCell()
    cell.robot.faults = {3: TargetRefusedError("joint 2 out of range")}

    ended = await run_session(cell, make_plan(3))

    assert ended is SessionState.FINISHED
    assert [(s.config, s.reason) for s in cell.journal.skipped] == [(2, "joint 2 out of range")]


async def test_a_robot_that_somebody_moved_waits_for_a_person():
    cell = FakeCell()
    operator = PatientOperator()
    point_taken = cell.journal.point_taken

    async def jog_after_the_second(point):
        reading_id = await point_taken(point)
        if point.config == 2:
            cell.robot.joints = tuple(joint + 0.1 for joint in cell.robot.joints)
        return reading_id

    cell.journal.point_taken = jog_after_the_second

    ended = await run_session(cell, make_plan(4), operator)

    assert ended is SessionState.FINISHED
    assert "5.73 deg away from where the last motion left it" in operator.questions[1]


async def test_an_arm_that_still_moves_when_a_person_confirms_is_left_alone():
    cell = FakeCell()
    operator = PatientOperator(patience=1)
    sleep = cell.clock.sleep

    async def creep(duration_s):
        cell.robot.joints = tuple(joint + 0.001 for joint in cell.robot.joints)
        await sleep(duration_s)

    cell.clock.sleep = creep

    await run_session(cell, make_plan(), operator)

    assert "The arm is still moving" in operator.questions[1]
    assert cell.robot.moves == []


async def test_an_arm_that_is_not_where_it_was_sent_is_not_measured():
    cell = FakeCell()
    operator = PatientOperator(patience=1)
    settle = cell.clock.sleep

    async def slip(duration_s):
        await settle(duration_s)
        cell.robot.misreport_rad = 0.01 if cell.robot.moves else 0.0

    cell.clock.sleep = slip

    await run_session(cell, make_plan(3), operator)

    assert "Joint 1 reports 0.573 deg away from where it was sent" in operator.questions[1]
    assert cell.journal.points == []


async def test_a_stale_robot_state_forbids_motion():
    cell = FakeCell()
    cell.robot.reading_age_s = 2.5
    operator = PatientOperator(patience=1)

    await run_session(cell, make_plan(), operator)

    assert "2.5 s old; the limit is 2 s" in operator.questions[1]
    assert cell.robot.moves == []


async def test_a_pause_takes_effect_at_the_end_of_the_motion_and_the_stop_begins_again():
    cell = FakeCell()
    runner = TrackerRunner(make_plan(3), cell.cell, cell.journal)
    answers = []

    async def ask_for_a_pause_during_the_fourth_motion():
        if len(cell.robot.moves) == 3 and not answers:
            answers.append(await asking.pause(runner, "Eva"))

    cell.robot.before_move = ask_for_a_pause_during_the_fourth_motion
    running = asyncio.create_task(runner.run())
    await until(lambda: runner.state is SessionState.AWAITING_CONFIRMATION)
    await asking.confirm(runner, "Eva")

    await until(lambda: runner.state is SessionState.PAUSED)
    moves_while_paused = len(cell.robot.moves)
    await asking.resume(runner, "Eva")

    assert "cannot be stopped" in answers[0]
    assert moves_while_paused == 4
    assert await running is SessionState.FINISHED
    assert len(cell.robot.moves) == 4 + 4  # stop 2 from its approach on, then stop 3
    assert [point.config for point in cell.journal.points] == [1, 2, 3]


async def test_an_abort_takes_effect_at_the_end_of_the_motion():
    cell = FakeCell()
    runner = TrackerRunner(make_plan(3), cell.cell, cell.journal)

    async def ask_for_the_end():
        if len(cell.robot.moves) == 2:
            await asking.end(runner, "Eva")

    cell.robot.before_move = ask_for_the_end
    running = asyncio.create_task(runner.run())
    await until(lambda: runner.state is SessionState.AWAITING_CONFIRMATION)
    await asking.confirm(runner, "Eva")

    assert await running is SessionState.ABORTED
    assert len(cell.robot.moves) == 3
    assert states(cell)[-2:] == [SessionState.ABORTING, SessionState.ABORTED]


async def test_what_makes_no_sense_now_is_refused_with_a_sentence():
    cell = FakeCell()
    runner = TrackerRunner(make_plan(), cell.cell, cell.journal)

    with pytest.raises(NotNowError, match="planned; it cannot become pausing"):
        await asking.pause(runner)
    with pytest.raises(NotNowError, match="nothing to resume"):
        await asking.resume(runner, "Eva")
    assert await asking.end(runner, "Eva") == "The session has ended; nothing was in motion."
    with pytest.raises(NotNowError, match="aborted already"):
        await asking.end(runner, "Eva")

    assert await runner.run() is SessionState.ABORTED


def bump_the_tracker(cell):
    """Have the tracker be pushed by 0.3 mm after the tenth configuration."""
    point_taken = cell.journal.point_taken

    async def push(point):
        if point.config == 10:
            cell.tracker.at = cell.tracker.at + np.array([0.0, 0.3, 0.0])
        return await point_taken(point)

    cell.journal.point_taken = push


async def test_a_fixed_nest_that_moved_pauses_and_resuming_places_the_tracker_anew():
    cell = FakeCell()
    operator = PatientOperator()
    bump_the_tracker(cell)

    ended = await run_session(cell, make_plan(12), operator)

    assert ended is SessionState.FINISHED
    assert "nest 1 by 0.300 mm" in operator.questions[1]
    assert "the tracker has moved" in operator.questions[1]
    assert len(cell.journal.registrations) == 2
    last = cell.journal.points[-1]
    true = nest_in_world(IRB120, cell.cell.base, NESTS, last.commanded_rad, 1) + cell.tracker.arm_error_mm
    assert last.position_world_mm == pytest.approx(true, abs=1e-8)


async def test_a_fixed_nest_off_by_no_more_than_its_readings_scatter_has_not_moved():
    cell = FakeCell()
    cell.tracker.stated_mm = 0.11  # per coordinate: 0.3 mm is less than three times 0.19
    operator = PatientOperator()
    bump_the_tracker(cell)

    assert await run_session(cell, make_plan(12), operator) is SessionState.FINISHED
    assert len(operator.questions) == 1


async def test_a_reading_of_another_reflector_is_never_stored():
    cell = FakeCell()
    cell.tracker.arm_error_mm = np.array([9.0, 9.0, 0.0])  # 12.7 mm off, found only by a wide search
    find = cell.tracker.find_reflector

    async def find_widely(near_mm, *, search_radius_mm):
        await find(near_mm, search_radius_mm=search_radius_mm + 10.0)

    cell.tracker.find_reflector = find_widely
    operator = PatientOperator(patience=1)

    await run_session(cell, make_plan(), operator)

    assert "12.7 mm from where nest 1 is expected" in operator.questions[1]
    assert cell.journal.points == []


async def test_a_reading_that_scatters_is_refused_because_the_arm_is_not_at_rest():
    cell = FakeCell()
    operator = PatientOperator(patience=1)

    async def shake():
        cell.tracker.rms_mm = 0.3

    cell.robot.before_move = shake

    await run_session(cell, make_plan(), operator)

    assert "scatters by 0.300 mm" in operator.questions[1]


@pytest.mark.parametrize(("stated_mm", "taken"), [(0.1, True), (0.05, False)])
async def test_a_tracker_that_states_more_noise_may_scatter_by_it(stated_mm, taken):
    cell = FakeCell()
    cell.tracker.rms_mm = 0.3  # 0.35 is twice what 0.1 per coordinate comes to
    measure = cell.tracker.measure_point

    async def stating(*asked, **more):
        return replace(await measure(*asked, **more), covariance_mm2=np.diag([stated_mm**2] * 3).tolist())

    cell.tracker.measure_point = stating

    await run_session(cell, make_plan(), PatientOperator(patience=1))

    assert bool(cell.journal.points) is taken


@pytest.mark.parametrize("bad", [math.nan, math.inf])
async def test_a_reading_that_is_no_number_is_refused(bad):
    cell = FakeCell()
    operator = PatientOperator(patience=1)
    measure = cell.tracker.measure_point

    async def give_nonsense(*, duration_s):
        reading = await measure(duration_s=duration_s)
        return replace(reading, point_mm=(bad, 0.0, 0.0)) if cell.robot.moves else reading

    cell.tracker.measure_point = give_nonsense

    await run_session(cell, make_plan(), operator)

    assert "no finite number" in operator.questions[1]
    assert cell.journal.points == []


async def test_a_restarted_session_asks_first_and_measures_only_what_is_missing():
    first = FakeCell()
    await run_session(first, make_plan(3))
    again = FakeCell()
    again.clock.time_s = first.clock.time_s
    entries = before_the_end(first)
    ran_s = first.journal.progress[-1].elapsed_s
    entries += (LedgerEntry("stop-4", EntryKind.SKIPPED, entries[-1].time_s, text="hidden"),)

    ended = await run_session(again, make_plan(6), entries=entries)

    assert ended is SessionState.FINISHED
    assert [point.config for point in again.journal.points] == [5, 6]
    assert again.journal.registrations == []  # the fixed nests agree with the one on disk
    assert states(again)[0] is SessionState.AWAITING_CONFIRMATION
    assert again.journal.progress[-1].done == 5
    assert again.journal.progress[-1].elapsed_s > ran_s


async def test_a_restart_after_the_tracker_was_moved_places_it_anew():
    first = FakeCell()
    await run_session(first, make_plan(1))
    again = FakeCell(azimuth_rad=0.4)
    operator = PatientOperator()

    ended = await run_session(again, make_plan(2), operator, before_the_end(first))

    assert ended is SessionState.FINISHED
    assert "Fixed nest 1 was not found" in operator.questions[1]
    assert len(again.journal.registrations) == 1


async def test_a_journal_that_cannot_write_ends_the_session_as_failed():
    cell = FakeCell()
    cell.journal.full_disk_at = 1

    with pytest.raises(OSError, match="no space left"):
        await run_session(cell, make_plan(3))

    assert states(cell)[-1] is SessionState.FAILED
    assert len(cell.robot.moves) == 4


async def test_the_time_left_is_learnt_from_the_pace_in_cell_time():
    cell = FakeCell()

    await run_session(cell, make_plan(20))

    after_ten = next(p for p in cell.journal.progress if p.done == 10)
    # a stop here: two motions of 1.5 s, 4 s of rest, 1 s to find, 1 s to measure: 9 s;
    # and two looks at the fixed nests, now and last: 1 s to find and 1 s to measure each of three
    assert after_ten.remaining_s == pytest.approx(102.0, rel=0.01)
    assert cell.journal.progress[-1].remaining_s == 0.0
    assert cell.journal.progress[0].remaining_s is None


async def test_time_in_which_a_person_is_awaited_is_not_counted():
    cell = FakeCell()
    operator = PatientOperator()

    def think(question):
        cell.clock.time_s += 3600.0

    operator.before_answer = think

    await run_session(cell, make_plan(2), operator)

    assert cell.journal.progress[-1].elapsed_s < 600.0


async def test_devices_introduce_themselves_in_the_record():
    cell = FakeCell()

    await run_session(cell, make_plan(1))

    assert "The tracker is Leica AT401, serial 390001, firmware 3.8." in cell.journal.notes
    assert any("scale agrees with the certified lengths" in note for note in cell.journal.notes)


async def test_what_the_tracker_measures_with_and_in_which_air_is_in_the_record():
    cell = FakeCell()
    cell.tracker.settings = "The tracker measures the reflector RRR 0.5in."

    await run_session(cell, make_plan(1))

    assert cell.tracker.settings in cell.journal.notes
    assert "The air at the tracker: 23.1 °C, 1013.0 hPa, 40 % humidity." in cell.journal.notes


@pytest.mark.parametrize(
    ("air", "told"),
    [
        (Environment(23.1, math.nan, math.nan), ["The air at the tracker: 23.1 °C."]),
        (Environment(math.nan, math.nan, math.nan), ["The air at the tracker: not stated."]),
        (DeviceRefusedError("no weather station"), []),
    ],
)
async def test_air_that_no_station_measures_is_not_made_up(air, told):
    cell = FakeCell()
    cell.tracker.air = air

    await run_session(cell, make_plan(1))

    assert [note for note in cell.journal.notes if note.startswith("The air")] == told
    assert not any("measures the" in note for note in cell.journal.notes)  # it says nothing of itself


async def test_a_cancelled_run_leaves_the_record_as_it_was():
    cell = FakeCell()
    runner = TrackerRunner(make_plan(), cell.cell, cell.journal)
    running = asyncio.create_task(runner.run())
    await until(lambda: runner.state is SessionState.AWAITING_CONFIRMATION)

    running.cancel()

    with pytest.raises(asyncio.CancelledError):
        await running
    assert states(cell) == [SessionState.AWAITING_CONFIRMATION]
