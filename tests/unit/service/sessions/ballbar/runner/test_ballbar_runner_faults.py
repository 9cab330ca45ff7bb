"""Ballbar sessions in which something goes wrong: doubts, pulled cables, halts and restarts."""

import asyncio
from dataclasses import replace

import pytest

from tests.helpers.domain.asking import question
from tests.unit.service.sessions.ballbar.fakes import HOME, Bench
from tests.unit.service.sessions.ballbar.sessions import (
    CUP,
    LEG,
    NEXT_LEG,
    PLAN,
    POSE,
    found,
    joints,
    make_plan,
    make_pose,
)
from truepose.domain.errors import UnderdeterminedError
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.messages.message import message
from truepose.sessions.engine.commands import CommandName
from truepose.sessions.errors import (
    NotNowError,
)
from truepose_drivers.errors import ConnectionLostError, NoReplyError, TargetRefusedError


@pytest.mark.parametrize(
    ("fault", "first"), [(NoReplyError, LEG), (ConnectionLostError, f"{LEG}/initialise")]
)
async def test_a_pulled_cable_is_shown_and_the_session_goes_on_when_it_is_back(fault, first):
    async with Bench(PLAN).at(LEG) as bench:
        bench.bar.lost = fault
        bench.bar.plugged = False
        await bench.clock.advance(3.0)
        assert bench.runner._readings.sample.state == "no_signal"
        assert bench.now.state is SessionState.RUNNING

        bench.bar.plugged = True
        await bench.clock.advance(5.0)  # the longest wait before the next attempt is 4 s

        assert bench.runner._readings.sample.state == "in_range"
        assert bench.present == first  # a gauge without supply has lost its zero, a silent counter has not
        await bench.until(NEXT_LEG)
        (entry,) = bench.kept(LEG)
        assert entry.length.initialisation == (3 if first == LEG else 4)


async def test_a_clock_of_the_cell_that_fails_has_the_session_await_a_person_and_go_on():
    async with Bench(PLAN).at(LEG) as bench:
        tell = bench.clock.now_s

        async def say_nothing():
            raise NoReplyError("the cell's clock says nothing")

        bench.clock.now_s = say_nothing
        await bench.clock.advance(1.0)
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        question = english(bench.now.question)
        assert question.startswith("the cell's clock says nothing. Correct this, then confirm.")
        assert not bench.running.done()

        bench.clock.now_s = tell
        await bench.press(CommandName.CONFIRM)

        await bench.until(None)
        assert bench.now.state is SessionState.FINISHED


async def test_a_robot_that_is_gone_has_the_session_await_a_person_and_go_on():
    async with Bench(PLAN).at(LEG) as bench:
        bench.robot.plugged = False
        await bench.clock.advance(1.0)
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        await bench.press(CommandName.CONFIRM)
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION  # it is still gone

        bench.robot.plugged = True
        await bench.press(CommandName.CONFIRM)

        await bench.until(None)
        assert bench.now.state is SessionState.FINISHED


@pytest.mark.parametrize("fault", [ConnectionLostError("cut"), TargetRefusedError("joint 3")])
async def test_a_motion_that_fails_is_asked_for_again(fault):
    async with Bench(PLAN).at(CUP) as bench:
        bench.robot.fault = fault

        await bench.do()

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        await bench.press(CommandName.CONFIRM)
        assert bench.present == CUP
        assert not bench.now.confirmed
        await bench.do()
        assert bench.present == "placement-1/cup-1/clamp"


@pytest.mark.parametrize(
    ("name", "state"),
    [
        (CommandName.PAUSE, SessionState.PAUSED),
        (CommandName.STOP, SessionState.AWAITING_CONFIRMATION),
        (CommandName.ABORT, SessionState.ABORTED),
    ],
)
async def test_a_halt_during_a_motion_lets_it_end_and_sends_nothing_more(name, state):
    async with Bench(PLAN).at(POSE) as bench:
        before = len(bench.robot.moves)
        await bench.press(CommandName.CONFIRM)
        await bench.clock.advance(0.5)
        assert bench.runner.robot_moving

        outcome = await bench.press(name)
        await bench.clock.advance(5.0)

        assert "ends first" in english(outcome.sentence)
        assert bench.robot.moves[before:] == [joints(1.5)]  # not on to the target
        assert bench.now.state is state


async def test_a_way_on_which_the_arm_was_halted_is_gone_on_with_from_there():
    stops = (joints(5), joints(6), joints(7))
    plan = make_plan((1, 2), settle_s=0.1)
    (place,) = plan.placements
    poses = (make_pose(1, via_rad=stops), *place.poses[1:])
    async with Bench(replace(plan, placements=(replace(place, poses=poses),))).at(POSE) as bench:
        before = len(bench.robot.moves)
        await bench.press(CommandName.CONFIRM)
        while len(bench.robot.moves) < before + 2:
            await bench.clock.advance(0.1)
        await bench.press(CommandName.STOP)
        await bench.clock.advance(2.0)

        await bench.press(CommandName.CONFIRM)
        await bench.do()

        assert bench.robot.moves[before:] == [*stops, joints(1)]


async def test_a_planned_way_on_which_something_touches_by_now_waits_for_a_person_who_was_told():
    blocked = joints(1.5)

    async def look(ways):
        return message("room.be_ready") if blocked in map(tuple, ways.end_rad.tolist()) else ""

    async with Bench(PLAN, look_at_ways=look).at(POSE) as bench:
        before = len(bench.robot.moves)

        await bench.do()

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert "Be ready to stop the arm" in english(bench.now.question)
        assert len(bench.robot.moves) == before
        await bench.press(CommandName.CONFIRM)
        await bench.do()
        assert bench.robot.moves[before:] == [blocked, joints(1)]


async def test_a_way_that_is_none_of_the_plans_is_looked_at_with_the_fixture_that_stands_there():
    seen = []

    async def look(place, cup, ways):
        seen.append((place.number, cup, tuple(ways.start_rad[0].tolist())))
        return ""

    async with Bench(PLAN, look_past_fixture=look).at(POSE) as bench:
        bench.robot.joints = elsewhere = (0.9, *joints(1)[1:-1], 0.1)
        await bench.clock.advance(1.0)
        await bench.press(CommandName.STOP)
        await bench.press(CommandName.CONFIRM)
        await bench.do()

    assert seen == [(1, 1, HOME), (1, None, elsewhere)]


async def test_a_halt_that_is_asked_for_while_a_motion_is_being_confirmed_comes_first():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.until("placement-1/cup-2/move")  # nothing keeps this motion from beginning at once
        before = list(bench.robot.moves)

        confirmed, _ = await asyncio.gather(
            bench.press(CommandName.CONFIRM), bench.press(CommandName.STOP), return_exceptions=True
        )
        await bench.clock.advance(5.0)

        assert isinstance(confirmed, NotNowError)  # it was of the motion, not of what is asked since
        assert bench.robot.moves == before
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION


async def test_after_a_pause_the_cell_is_looked_at_again():
    async with Bench(PLAN).at(CUP) as bench:
        await bench.press(CommandName.PAUSE)

        await bench.press(CommandName.RESUME)
        await bench.clock.advance(5.0)

        assert bench.robot.moves == []
        assert bench.present == CUP
        await bench.do()
        assert bench.present == "placement-1/cup-1/clamp"


async def test_after_a_restart_the_same_step_is_there_and_nothing_moves_before_a_person_confirms():
    async with Bench(PLAN).at(POSE) as bench:
        await bench.press(CommandName.CONFIRM)
        await bench.clock.advance(0.5)
        before = list(bench.robot.moves)

        await bench.restart()
        await bench.clock.advance(10.0)

        assert bench.present == POSE
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert bench.robot.moves == before
        await bench.press(CommandName.CONFIRM)
        await bench.clock.advance(10.0)
        assert bench.robot.moves == before  # that was the session, not the motion
        await bench.until(None)


async def test_every_reading_survives_a_restart_at_every_step():
    async with Bench(PLAN) as bench:
        await bench.start()
        while bench.present is not None:
            await bench.do()
            if bench.present is None:
                break
            step_id, measured = bench.present, bench.now.progress.readings
            await bench.restart()
            assert (bench.present, bench.now.progress.readings) == (step_id, measured)
            await bench.press(CommandName.CONFIRM)

        assert bench.now.state is SessionState.FINISHED
        assert all(len(bench.kept(step.id)) <= 1 for step in bench.now.steps)


async def test_an_arm_that_was_moved_while_the_program_was_off_loses_its_stop():
    async with Bench(PLAN).at(LEG) as bench:
        await bench.kill()
        bench.robot.joints = joints(7)
        await bench.restart()

        await bench.press(CommandName.CONFIRM)

        assert bench.present == "placement-1/pose-1/move/detach"
        assert bench.now.outcomes["placement-1/pose-1/leg-1-1"].kind == "open"


async def test_a_pre_calibration_that_fails_pauses_and_can_be_tried_again_or_left_out():
    async with Bench(PLAN) as bench:
        bench.oracle.answer = UnderdeterminedError("Six legs are too few.")
        await bench.start()
        while bench.now.state is SessionState.RUNNING:
            await bench.do()
        assert bench.now.state is SessionState.PAUSED
        assert "Six legs are too few." in english(question(bench.runner))
        assert bench.present == "placement-1/precalibrate-1"

        await bench.press(CommandName.RESUME)
        await bench.clock.advance(0.1)
        assert bench.oracle.asked == 2
        await bench.press(CommandName.SKIP, reason="no time")
        await bench.press(CommandName.RESUME)

        assert bench.present == "placement-1/pose-2/move"


async def test_what_is_wrong_with_a_pre_calibration_is_no_reason_to_lose_the_session():
    async with Bench(PLAN) as bench:
        bench.oracle.answer = found(make_pose(2, legs=((1, 1),)))
        await bench.start()

        while bench.now.state is SessionState.RUNNING:
            await bench.do()

        assert "Configuration 2 has 1 ballbar lengths" in english(question(bench.runner))


async def test_a_pose_to_which_no_clear_way_was_found_is_left_out_with_the_reason():
    async with Bench(make_plan((1, 2, 3), precalibrate_after=1, stable_s=0.2, settle_s=0.1)) as bench:
        bench.oracle.answer = found(make_pose(3))
        await bench.start()

        await bench.until(None)

        left_out = bench.now.outcomes["placement-1/pose-2/leg-1-1"]
        assert (left_out.kind, english(left_out.text)) == (
            "skipped",
            "The pre-calibration found no collision-free path to this pose.",
        )
        assert joints(2) not in bench.robot.moves
        assert bench.now.outcomes["placement-1/pose-3/leg-1-1"].kind == "measured"


async def test_the_end_does_not_wait_for_a_pre_calibration():
    async with Bench(PLAN) as bench:
        bench.oracle.clock, bench.oracle.duration_s = bench.clock, 1000.0
        await bench.start()
        await bench.until("placement-1/precalibrate-1")
        await bench.clock.advance(1.0)

        await bench.press(CommandName.ABORT)
        await bench.clock.advance(1.0)

        assert await bench.running is SessionState.ABORTED
