"""A whole session on a fake cell: what is measured, what is kept, what happens when something fails."""

import asyncio
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain import asking
from tests.helpers.domain.asking import question
from tests.unit.service.sessions.tracker.fakes import IRB120, NESTS, FakeCell, make_plan, make_stop
from tests.unit.service.sessions.tracker.operators import PatientOperator, begun, run_session, until
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.sessions.engine.nominal_arm import nest_in_world
from truepose.sessions.engine.prompts import CELL_CLEAR
from truepose.sessions.errors import NotNowError, PersonMissingError
from truepose.sessions.tracker.runner import TrackerRunner


def states(cell):
    return [state for state, _, _ in cell.journal.states]


async def test_every_planned_configuration_is_measured_and_stored_once(cell):
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


async def test_a_stop_is_kept_with_everything_known_of_it(cell):
    cell.cell = replace(cell.cell, attachment=4)
    stop = make_stop(1, nest=2)

    await run_session(cell, make_plan(stops=(stop, make_stop(2, nest=2, repeat_of=1))))

    first, second = cell.journal.points
    assert first.commanded_rad == first.reported_rad == stop.joints_rad
    assert (first.nest, first.attachment, first.temperature_c) == (2, 4, 23.1)
    assert (first.repeat_of, second.repeat_of) == (None, 1)
    assert first.time_s < second.time_s


async def test_every_stop_is_approached_from_below_on_all_joints(cell):
    plan = make_plan(2)

    await run_session(cell, plan)

    stops = [stop.joints_rad for stop in plan.stops]
    assert cell.robot.moves[1::2] == stops
    for before, stop in zip(cell.robot.moves[0::2], stops, strict=True):
        assert np.degrees(np.subtract(stop, before)) == pytest.approx([5.0] * 6)
    assert {point.direction for point in cell.journal.points} == {(1,) * 6}


async def test_without_an_approach_the_direction_is_that_of_the_way_from_stop_to_stop(cell):
    plan = make_plan(3, approach_offset_rad=None)

    await run_session(cell, plan)

    way = np.diff([(0.0,) * 6, *[stop.joints_rad for stop in plan.stops]], axis=0)
    assert [point.direction for point in cell.journal.points] == [tuple(np.sign(w)) for w in way]


async def test_nothing_moves_before_a_named_person_has_confirmed(cell):
    runner, running = await begun(cell, make_plan())
    with pytest.raises(PersonMissingError):
        await asking.confirm(runner, "  ")
    for _ in range(100):
        await asyncio.sleep(0)

    assert question(runner) == CELL_CLEAR
    assert cell.robot.moves == []
    await asking.confirm(runner, "Eva")
    assert await running is SessionState.FINISHED
    assert (SessionState.RUNNING, "Eva") in [(state, person) for state, _, person in cell.journal.states]


async def test_the_tracker_is_placed_in_the_world_before_the_robot_moves(cell):
    moves_at_registration = []

    async def note_moves(entry):
        if entry.registration is not None:
            moves_at_registration.append(len(cell.robot.moves))

    cell.journal.before = note_moves

    await run_session(cell, make_plan())

    assert moves_at_registration == [0]
    assert len([r for r in cell.journal.fixed if r.phase == "registration"]) == 15


async def test_fixed_nests_are_read_before_every_tenth_configuration_and_after(cell):
    await run_session(cell, make_plan(25))

    references = [reading for reading in cell.journal.fixed if reading.phase == "reference"]
    assert len(references) == 3 * 4  # before, after 10, after 20, after 25
    assert [reading.fixed_nest for reading in references] == [1, 2, 3] * 4


async def test_both_faces_are_compared_and_the_session_measures_on_the_first(cell):
    cell.tracker.two_face_mm = 0.02

    await run_session(cell, make_plan())

    # faces differ by 0.04 along z: half of it
    assert cell.journal.registrations[0].two_face_mm == pytest.approx(0.02, abs=1e-9)
    assert cell.tracker.face == 1


async def test_a_pause_takes_effect_at_the_end_of_the_motion_and_the_stop_begins_again(cell):
    runner, running = await begun(cell, make_plan(3))
    answers = []

    async def ask_for_a_pause_during_the_fourth_motion():
        if len(cell.robot.moves) == 3 and not answers:
            answers.append(await asking.pause(runner, "Eva"))

    cell.robot.before_move = ask_for_a_pause_during_the_fourth_motion
    await asking.confirm(runner, "Eva")

    await until(lambda: runner.state is SessionState.PAUSED)
    moves_while_paused = len(cell.robot.moves)
    await asking.resume(runner, "Eva")

    assert "cannot stop a motion under way" in english(answers[0])
    assert moves_while_paused == 4
    assert await running is SessionState.FINISHED
    assert len(cell.robot.moves) == 4 + 4  # stop 2 from its approach on, then stop 3
    assert [point.config for point in cell.journal.points] == [1, 2, 3]


async def test_an_abort_takes_effect_at_the_end_of_the_motion(cell):
    runner, running = await begun(cell, make_plan(3))

    async def ask_for_the_end():
        if len(cell.robot.moves) == 2:
            await asking.end(runner, "Eva")

    cell.robot.before_move = ask_for_the_end
    await asking.confirm(runner, "Eva")

    assert await running is SessionState.ABORTED
    assert len(cell.robot.moves) == 3
    assert states(cell)[-2:] == [SessionState.ABORTING, SessionState.ABORTED]


async def test_what_makes_no_sense_now_is_refused_with_a_sentence(cell):
    runner = TrackerRunner(make_plan(), cell.cell, cell.journal)

    with pytest.raises(NotNowError, match="planned; it cannot become pausing"):
        await asking.pause(runner)
    with pytest.raises(NotNowError, match="nothing to resume"):
        await asking.resume(runner, "Eva")
    assert english(await asking.end(runner, "Eva")) == "The session has ended; nothing was moving."
    with pytest.raises(NotNowError, match="already aborted"):
        await asking.end(runner, "Eva")

    assert await runner.run() is SessionState.ABORTED


def bump_the_tracker(cell):
    """Have the tracker be pushed by 0.3 mm after the tenth configuration."""

    async def push(entry):
        if entry.point is not None and entry.point.config == 10:
            cell.tracker.at = cell.tracker.at + np.array([0.0, 0.3, 0.0])

    cell.journal.before = push


async def test_a_fixed_nest_that_moved_pauses_and_resuming_places_the_tracker_anew(cell):
    operator = PatientOperator()
    bump_the_tracker(cell)

    ended = await run_session(cell, make_plan(12), operator)

    assert ended is SessionState.FINISHED
    assert "nest 1 by 0.300 mm" in operator.questions[1]
    assert "mm): the tracker has moved" in operator.questions[1]
    assert len(cell.journal.registrations) == 2
    last = cell.journal.points[-1]
    true = nest_in_world(IRB120, cell.cell.base, NESTS, last.commanded_rad, 1) + cell.tracker.arm_error_mm
    assert last.position_world_mm == pytest.approx(true, abs=1e-8)


async def test_a_fixed_nest_off_by_no_more_than_its_readings_scatter_has_not_moved(cell):
    cell.tracker.stated_mm = 0.11  # per coordinate: 0.3 mm is less than three times 0.19
    operator = PatientOperator()
    bump_the_tracker(cell)

    assert await run_session(cell, make_plan(12), operator) is SessionState.FINISHED
    assert len(operator.questions) == 1


async def test_a_reading_of_another_reflector_is_never_stored(cell):
    cell.tracker.arm_error_mm = np.array([9.0, 9.0, 0.0])  # 12.7 mm off, found only by a wide search
    find = cell.tracker.find_reflector

    async def find_widely(near_mm, *, search_radius_mm):
        await find(near_mm, search_radius_mm=search_radius_mm + 10.0)

    cell.tracker.find_reflector = find_widely
    operator = PatientOperator(patience=1)

    await run_session(cell, make_plan(), operator)

    assert "12.7 mm from the expected position of nest 1" in operator.questions[1]
    assert cell.journal.points == []


async def test_a_reading_that_scatters_is_refused_because_the_arm_is_not_at_rest(cell):
    operator = PatientOperator(patience=1)

    async def shake():
        cell.tracker.rms_mm = 0.3

    cell.robot.before_move = shake

    await run_session(cell, make_plan(), operator)

    assert "scatters by 0.300 mm" in operator.questions[1]


@pytest.mark.parametrize(("stated_mm", "taken"), [(0.1, True), (0.05, False)])
async def test_a_tracker_that_states_more_noise_may_scatter_by_it(stated_mm, taken, cell):
    cell.tracker.rms_mm = 0.3  # 0.35 is twice what 0.1 per coordinate comes to
    measure = cell.tracker.measure_point

    async def stating(*asked, **more):
        return replace(await measure(*asked, **more), covariance_mm2=np.diag([stated_mm**2] * 3).tolist())

    cell.tracker.measure_point = stating

    await run_session(cell, make_plan(), PatientOperator(patience=1))

    assert bool(cell.journal.points) is taken


@pytest.mark.parametrize("bad", [math.nan, math.inf])
async def test_a_reading_that_is_no_number_is_refused(bad, cell):
    operator = PatientOperator(patience=1)
    measure = cell.tracker.measure_point

    async def give_nonsense(*, duration_s):
        reading = await measure(duration_s=duration_s)
        return replace(reading, point_mm=(bad, 0.0, 0.0)) if cell.robot.moves else reading

    cell.tracker.measure_point = give_nonsense

    await run_session(cell, make_plan(), operator)

    assert "not a finite number" in operator.questions[1]
    assert cell.journal.points == []
