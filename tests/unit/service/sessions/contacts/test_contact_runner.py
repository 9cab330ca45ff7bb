"""Sessions of closed loops on a cell of plain objects: questions, ways, readings, faults, restarts."""

import asyncio
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from tests.helpers.domain import asking
from tests.unit.service.sessions.contacts.fakes import RADII_MM, Bench, planned
from tests.unit.service.sessions.tracker import operators
from tests.unit.service.sessions.tracker.fakes import IRB120
from tests.unit.service.sessions.tracker.operators import PatientOperator
from truepose.domain.robot import FramePlacement, JointRange
from truepose.domain.session import SessionState
from truepose.messages.message import message
from truepose.sessions.contact.dry_run import minutes_of
from truepose.sessions.contact.runner import ContactRunner
from truepose.sessions.contact.state import Question
from truepose.sessions.engine.nominal_arm import nominal_chain
from truepose.sessions.errors import NotNowError, PersonMissingError, PlanRefusedError
from truepose_drivers.errors import (
    BusyError,
    ConfigurationError,
    ConnectionLostError,
    NotInitialisedError,
    TargetRefusedError,
)

PLAN = planned()
until = partial(operators.until, turns=20_000)  # a stop takes some hundred turns of the event loop


@pytest.fixture
def bench():
    return Bench()


def runner_of(bench, plan=PLAN, **changes):
    return ContactRunner(plan, bench.cell(**changes), bench.journal, tuple(bench.journal.entries))


async def run(bench, patience=10, plan=PLAN, **changes):
    operator = PatientOperator(patience)
    state = await operator.attend_from_the_start(runner_of(bench, plan, **changes))
    return state, operator.questions


async def confirmed(bench):
    """Begin a session and confirm all that it asks; return it with its task."""
    runner = runner_of(bench)
    task = asyncio.create_task(runner.run())
    for _ in Question:
        await until(lambda: runner.prompt is not None)
        await asking.confirm(runner, "Eva")
    return runner, task


def at(joints):
    return pytest.approx(joints, abs=1e-12)


async def test_everything_is_asked_before_anything_moves_and_then_read(bench):
    operator, moved = PatientOperator(), []
    operator.before_answer = lambda _: moved.append(len(bench.robot.moves))

    state = await operator.attend_from_the_start(runner_of(bench))

    assert state is SessionState.FINISHED
    assert moved == [0, 0, 0]
    fixture, zero, clear = operator.questions
    assert "sphere 1 at (400, 0, 150) mm" in fixture
    assert "zero it" in zero
    assert "emergency stop" in clear
    assert [taken.config for taken in bench.read] == [stop.config for stop in PLAN.stops]


async def test_whoever_confirms_that_the_cell_is_clear_is_told_what_touches_on_the_ways(bench):
    async def look(ways):
        return message("room.be_ready") if len(ways.start_rad) > 1 else ""

    state, questions = await run(bench, look_at_ways=look)

    assert state is SessionState.FINISHED
    assert ["Be ready to stop the arm" in asked for asked in questions] == [False, False, True]


async def test_a_null_that_leads_where_something_touches_costs_its_stop_and_asks_nobody(bench):
    async def look(ways):
        return message("room.be_ready") if len(ways.start_rad) == 1 and bench.robot.moves else ""

    state, questions = await run(bench, look_at_ways=look)

    assert (state, len(questions)) == (SessionState.FINISHED, 3)
    assert [one.config for one in bench.journal.skipped] == [1, 4, 5]  # else back along its own way
    assert all("Be ready to stop the arm" in one.reason for one in bench.journal.skipped)


async def test_a_probe_is_read_at_its_zero_where_it_truly_touches(bench):
    await run(bench)

    for taken in bench.read:
        assert abs(taken.reading_mm[0]) <= PLAN.null_mm
        bench.robot.joints = taken.commanded_rad
        pushed_mm = bench.probe._pushed_mm()
        assert taken.reading_mm == (pytest.approx(-pushed_mm, abs=1e-9),)
        assert taken.targets == (1,)
        assert taken.axes == ()


async def test_the_arm_comes_and_goes_by_the_planned_way(bench):
    await run(bench)

    way = PLAN.stops[0].way_rad
    back = bench.robot.moves.index(way[0], 1)
    first = bench.robot.moves[: back + 1]
    assert first[: len(way)] == [at(place) for place in way]
    assert first[1 - len(way) :] == [at(place) for place in reversed(way[:-1])]


async def test_no_gauge_is_ever_pushed_further_than_its_stroke_without_the_margin(bench):
    await run(bench)

    assert 0.0 < bench.probe.deepest_mm <= PLAN.stroke_mm - PLAN.margin_mm


async def test_a_sphere_that_stands_too_near_is_left_alone(bench):
    bench.probe.centre_mm = np.add(bench.probe.centre_mm, (0.0, 0.0, 8.0))  # towards the probe

    await run(bench, patience=5)

    assert any("is not at its planned position" in skipped.reason for skipped in bench.journal.skipped)
    assert bench.probe.deepest_mm <= PLAN.stroke_mm
    assert bench.robot.moves[-1] in [stop.way_rad[0] for stop in PLAN.stops]


async def test_a_sphere_that_is_not_there_is_no_reading(bench):
    bench.probe.centre_mm = np.array([400.0, 0.0, -500.0])

    await run(bench, patience=4)

    assert bench.read == []
    assert all("is not in contact" in skipped.reason for skipped in bench.journal.skipped)


async def test_a_stop_whose_zero_is_beyond_the_limits_is_left_out_and_nobody_is_asked_for_ever(bench):
    places = np.array([place for stop in PLAN.stops for place in stop.way_rad])
    limits = tuple(map(JointRange, places.min(axis=0).tolist(), places.max(axis=0).tolist()))

    state, _ = await run(bench, patience=20, joint_limits=limits)

    assert state is SessionState.FINISHED
    assert any("would exceed the limits: joint" in skipped.reason for skipped in bench.journal.skipped)
    assert all(
        np.all(np.abs(np.clip(move, places.min(axis=0), places.max(axis=0)) - move) < 1e-6)
        for move in bench.robot.moves
    )


async def test_a_gauge_that_counts_the_other_way_round_is_noticed(bench):
    bench.probe.sign = -1.0

    _, questions = await run(bench, patience=3)

    assert "reading increases as the gauge extends" in questions[3]
    assert bench.read == []


async def test_a_lost_gauge_has_a_person_look_and_the_stop_begins_again(bench):
    bench.probe.lost_after = 25

    state, questions = await run(bench)

    assert state is SessionState.FINISHED
    assert questions[3].startswith("the gauge's cable is out")
    assert len({taken.config for taken in bench.read}) == len(bench.read) == len(PLAN.stops)


async def test_a_lost_robot_in_the_middle_of_an_approach_goes_back_by_the_way_it_came(bench):
    way = PLAN.stops[0].way_rad
    bench.robot.faults[3] = ConnectionLostError("the robot's link is down")

    state, _ = await run(bench)

    after = bench.robot.moves[4:]
    assert state is SessionState.FINISHED
    assert after[0] in way
    assert way.index(after[0]) < 3
    assert len(bench.read) == len(PLAN.stops)


SECOND = PLAN.stops[1]


def refuse_once(bench, device, name, error, when):
    """Have a device refuse what it is asked by `name`, the first time that `when` holds of it.

    Returns a list of the number of motions that had begun by then.
    """
    asked, begun = getattr(device, name), []

    async def refuse(*given):
        if not begun and when(*given):
            begun.append(len(bench.robot.moves))
            raise error
        return await asked(*given)

    setattr(device, name, refuse)
    return begun


def refuse_the_second_target(bench, error):
    return refuse_once(
        bench, bench.robot, "move_joints", error, lambda target_rad: target_rad == at(SECOND.joints_rad)
    )


def way_back(bench, begun):
    """Return by which places of its second stop's way the arm went to where nothing is near."""
    way = [at(place) for place in SECOND.way_rad]
    after = bench.robot.moves[begun[0] :]
    return [way.index(place) for place in after[: after.index(way[0]) + 1]]


@pytest.mark.parametrize("refusal", [TargetRefusedError("out of reach"), BusyError("the robot is busy")])
async def test_after_a_refused_motion_the_arm_goes_back_by_the_way_it_came(bench, refusal):
    begun = refuse_the_second_target(bench, refusal)

    state, _ = await run(bench)

    assert state is SessionState.FINISHED
    assert [(skipped.config, skipped.reason) for skipped in bench.journal.skipped] == [(2, str(refusal))]
    assert way_back(bench, begun) == [4, 3, 2, 1, 0]


async def test_after_a_gauge_refused_to_answer_the_arm_goes_back_by_the_way_it_came(bench):
    refusal = BusyError("the unit refuses to tell its values")
    begun = refuse_once(
        bench, bench.probe, "read_channels", refusal, lambda: bench.robot.joints == at(SECOND.joints_rad)
    )

    state, _ = await run(bench)

    assert state is SessionState.FINISHED
    assert [skipped.config for skipped in bench.journal.skipped] == [2]
    assert way_back(bench, begun) == [5, 4, 3, 2, 1, 0]


async def test_an_arm_that_cannot_leave_its_target_asks_a_person_and_leaves_by_the_way_it_came(bench):
    refused = refuse_the_second_target(bench, TargetRefusedError("out of reach"))
    begun = refuse_once(
        bench, bench.robot, "move_joints", BusyError("somebody drives the robot"), lambda _: bool(refused)
    )

    state, questions = await run(bench)

    assert state is SessionState.FINISHED
    assert questions[3].startswith("somebody drives the robot")
    assert way_back(bench, begun) == [4, 3, 2, 1, 0]
    assert [taken.config for taken in bench.read] == [stop.config for stop in PLAN.stops]


async def test_an_arm_that_could_not_leave_its_target_leaves_by_the_same_way_after_a_restart(bench):
    refused = refuse_the_second_target(bench, TargetRefusedError("out of reach"))
    begun = refuse_once(
        bench, bench.robot, "move_joints", BusyError("somebody drives the robot"), lambda _: bool(refused)
    )
    runner, task = await confirmed(bench)
    await until(lambda: runner.state is SessionState.PAUSED)
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)

    state, _ = await run(bench)

    assert state is SessionState.FINISHED
    assert way_back(bench, begun) == [4, 3, 2, 1, 0]


async def test_speeds_that_the_robot_cannot_have_ask_a_person_while_the_arm_is_on_its_way(bench):
    begun = refuse_once(
        bench,
        bench.robot,
        "set_limits",
        ConfigurationError("no robot goes so slowly"),
        lambda _: bench.robot.joints == at(SECOND.way_rad[2]),
    )

    state, questions = await run(bench)

    assert state is SessionState.FINISHED
    assert questions[3].startswith("no robot goes so slowly")
    assert way_back(bench, begun) == [1, 0]
    assert bench.journal.skipped == []


async def test_a_robot_that_was_stopped_on_its_way_does_not_move_before_a_person_has_looked(bench):
    begun = refuse_the_second_target(bench, NotInitialisedError("a protective stop: look, then confirm"))
    operator, moved = PatientOperator(10), []
    operator.before_answer = lambda _: moved.append(len(bench.robot.moves))

    state = await operator.attend_from_the_start(runner_of(bench))

    assert state is SessionState.FINISHED
    assert moved[3:] == begun
    assert way_back(bench, begun) == [4, 3, 2, 1, 0]


async def test_a_refused_target_of_wires_asks_a_person_since_nobody_looked_at_the_way_from_there(bench):
    stops = tuple(replace(stop, way_rad=stop.way_rad[-1:]) for stop in PLAN.stops)
    begun = refuse_the_second_target(bench, TargetRefusedError("out of reach"))
    operator, moved = PatientOperator(10), []
    operator.before_answer = lambda _: moved.append(len(bench.robot.moves))

    state = await operator.attend_from_the_start(runner_of(bench, replace(PLAN, loop="wires", stops=stops)))

    assert state is SessionState.FINISHED
    assert [skipped.config for skipped in bench.journal.skipped] == [2]
    assert operator.questions[3].startswith("out of reach")
    assert moved[3:] == begun == [1]


async def test_an_arm_that_somebody_drove_elsewhere_goes_straight_to_where_nothing_is_near(bench):
    bench.robot.joints = (0.3, 0.2, -0.1, 0.0, 0.5, 0.0)

    await run(bench)

    assert bench.robot.moves[0] == at(PLAN.stops[0].way_rad[0])
    assert bench.robot.limits is not None


async def test_a_restarted_session_asks_for_the_cell_and_goes_on_with_the_stop_it_was_at(bench):
    bench.robot.before_move = lambda: asyncio.sleep(0)
    interrupted = asyncio.create_task(PatientOperator().attend_from_the_start(runner_of(bench)))
    await until(lambda: len(bench.read) == 2)
    interrupted.cancel()
    await asyncio.gather(interrupted, return_exceptions=True)
    bench.probe.connected = bench.robot.connected = False

    state, questions = await run(bench)

    assert state is SessionState.FINISHED
    assert len(questions) == 1
    assert "The service was restarted" in questions[0]
    assert "emergency stop" in questions[0]
    assert [taken.config for taken in bench.read] == [stop.config for stop in PLAN.stops]


async def test_a_session_that_was_restarted_before_its_fixture_stood_asks_for_that_again(bench):
    first = runner_of(bench)
    task = asyncio.create_task(first.run())
    await until(lambda: first.prompt is not None)
    task.cancel()
    await asyncio.gather(task, return_exceptions=True)

    _, questions = await run(bench)

    assert [Question.FIXTURE.value in text.lower() or "Bolt" in text for text in questions] == [
        True,
        False,
        False,
    ]


async def test_a_pause_while_the_arm_creeps_is_kept_and_nothing_moves_until_it_is_resumed(bench):
    runner, task = await confirmed(bench)
    bench.robot.before_move = lambda: asking.pause(runner, "Eva")

    await until(lambda: runner.state is SessionState.PAUSED)

    moves = len(bench.robot.moves)
    bench.robot.before_move = None
    for _ in range(100):
        await asyncio.sleep(0)
    assert len(bench.robot.moves) == moves == 1
    await asking.resume(runner, "Eva")
    assert await task is SessionState.FINISHED
    assert len(bench.read) == len(PLAN.stops)


async def test_a_refused_line_is_kept_once_and_somebody_looks_before_the_next_motion(bench):
    operator = PatientOperator(10)
    bench.robot.before_move = lambda: asyncio.sleep(0)
    session = asyncio.create_task(operator.attend_from_the_start(runner_of(bench)))
    await until(lambda: len(bench.read) == 1)
    bench.journal.fill()
    await bench.journal.refused.wait()
    moves = len(bench.robot.moves)
    for _ in range(100):
        await asyncio.sleep(0)
    assert len(bench.robot.moves) == moves

    bench.journal.make_room()

    assert await session is SessionState.FINISHED
    assert any("could not be written" in question for question in operator.questions)
    assert len({taken.config for taken in bench.read}) == len(bench.read) == len(PLAN.stops)


async def test_another_gauge_than_the_cell_file_names_measures_nothing(bench):
    bench.probe.serial = "7"

    state, questions = await run(bench, patience=3, gauge_serial="8")

    assert state is SessionState.ABORTED
    assert "serial number 7 instead of 8" in questions[2]
    assert bench.robot.moves == []


async def test_another_robot_than_the_cell_file_names_does_not_move(bench):
    _, questions = await run(bench, patience=3, robot_serial="120-2")

    assert "A different robot answers" in questions[2]
    assert bench.robot.moves == []


async def test_a_box_with_another_number_of_gauges_is_told(bench):
    two = bench.cell()
    cell = replace(two, gauges=two.gauges * 2)
    operator = PatientOperator(2)

    await operator.attend_from_the_start(ContactRunner(PLAN, cell, bench.journal))

    assert "has 2 gauges, but the session reads 1" in operator.questions[2]


async def test_nobody_confirms_without_a_name_or_what_is_not_asked(bench):
    runner = runner_of(bench)
    task = asyncio.create_task(runner.run())
    await until(lambda: runner.prompt is not None)

    with pytest.raises(PersonMissingError):
        await asking.confirm(runner, " ")
    with pytest.raises(NotNowError):
        await asking.resume(runner, "Eva")
    await asking.end(runner, "Eva")

    assert await task is SessionState.ABORTED
    assert bench.robot.moves == []


def leaping(stop):
    """The stop, touched in one step of 5 mm."""
    return replace(stop, way_rad=(*stop.way_rad[:3], stop.way_rad[-1]))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"stops": (leaping(PLAN.stops[0]),)}, "half the stroke, 2.50 mm"),
        ({"stops": (replace(PLAN.stops[0], way_rad=PLAN.stops[0].way_rad[:3]),)}, "too few points"),
        ({"stops": ()}, "no configuration"),
        ({"margin_mm": 2.6}, "half the stroke"),
        ({"touch_speed_mm_s": 0.0}, "touch_speed_mm_s"),
        ({"stroke_mm": 2.2}, "half the stroke, 1.10 mm"),
        ({"targets": ()}, "does not list"),
        ({"stops": (PLAN.stops[0], PLAN.stops[0])}, "twice"),
    ],
)
def test_a_plan_that_cannot_be_done_is_refused_beforehand(bench, changes, sentence):
    plan = type(PLAN)(**{
        **{name: getattr(PLAN, name) for name in PLAN.__dataclass_fields__},
        **changes,
    })

    with pytest.raises(PlanRefusedError, match=sentence):
        runner_of(bench, plan)


def test_a_plan_takes_its_ways_there_and_back_fast_and_its_last_steps_slowly():
    seconds = 0.0
    for stop in PLAN.stops:
        tool_mm = nominal_chain(IRB120, FramePlacement(), np.array(stop.way_rad)).origin[-1]
        fast, slow = np.split(np.linalg.norm(np.diff(tool_mm, axis=0), axis=1), [2])
        seconds += 2.0 * (
            fast.sum() / PLAN.tool_speed_mm_s + slow.sum() / PLAN.touch_speed_mm_s + PLAN.settle_s
        )

    assert minutes_of(PLAN, IRB120, FramePlacement()) == pytest.approx(seconds / 60.0)


def test_the_probe_is_taken_to_where_its_centre_is_as_far_from_the_sphere_as_both_radii():
    assert PLAN.targets[0].zero_mm == RADII_MM
