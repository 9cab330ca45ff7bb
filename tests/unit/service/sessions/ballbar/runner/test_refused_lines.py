"""A ballbar session whose lines are refused: nothing moves, nothing is lost, and it goes on by itself."""

import asyncio

import pytest

from tests.unit.service.sessions.ballbar.fakes import Bench, turns
from tests.unit.service.sessions.ballbar.runner.test_slow_disk import begin_motion
from tests.unit.service.sessions.ballbar.sessions import CUP, LEG, PLAN, POSE, make_plan
from truepose.domain.errors import RecordRefusedError
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.sessions.engine.commands import CommandName


async def test_a_length_that_is_refused_is_stored_once_the_disk_takes_it():
    async with Bench(PLAN).at(LEG) as bench:
        await bench.clear_hands(LEG)
        bench.disk.fill()
        bench.hands.do_as_asked(LEG)
        await bench.clock.advance(3.0)

        assert bench.present == LEG
        assert bench.kept(LEG) == []
        assert "cannot be written (database or disk is full). Nothing moves." in english(bench.runner.trouble)
        bench.disk.make_room()
        await bench.clock.advance(1.0)

        assert len(bench.kept(LEG)) == 1
        assert bench.runner.trouble is None
        assert not bench.running.done()


async def test_an_arrival_that_is_refused_is_on_record_later_and_the_arm_stays():
    async with Bench(PLAN).at(CUP) as bench:
        await begin_motion(bench, CUP)
        bench.disk.fill()
        await bench.clock.advance(10.0)
        moved = len(bench.robot.moves)

        assert bench.present == CUP
        bench.disk.make_room()
        await bench.clock.advance(1.0)

        assert bench.present != CUP
        assert len(bench.robot.moves) == moved


@pytest.mark.parametrize(
    ("name", "state"),
    [
        (CommandName.PAUSE, SessionState.PAUSED),
        (CommandName.STOP, SessionState.AWAITING_CONFIRMATION),
        (CommandName.ABORT, SessionState.ABORTED),
    ],
)
@pytest.mark.parametrize("moving", [True, False])
async def test_a_halt_that_is_refused_holds_and_is_kept_later(name, state, moving):
    async with Bench(PLAN).at(POSE) as bench:
        before = len(bench.robot.moves)
        if moving:
            await begin_motion(bench, POSE)
        bench.disk.fill()
        with pytest.raises(RecordRefusedError):
            await bench.press(name, step_id=None)
        await bench.clock.advance(10.0)

        assert len(bench.robot.moves) == before + moving  # not on to the target
        assert bench.now.state is SessionState.RUNNING
        bench.disk.make_room()
        await bench.clock.advance(1.0)

        assert bench.now.state is bench.states()[-1] is state
        assert len(bench.robot.moves) == before + moving
        if state is not SessionState.ABORTED:
            await bench.press(
                CommandName.RESUME if name is CommandName.PAUSE else CommandName.CONFIRM, step_id=None
            )
            await bench.until(LEG)


async def test_an_end_that_is_refused_at_a_pause_does_not_come_back_at_the_resumption():
    async with Bench(PLAN).at(POSE) as bench:
        await bench.press(CommandName.PAUSE)
        bench.disk.fill()
        with pytest.raises(RecordRefusedError):
            await bench.press(CommandName.ABORT)
        bench.disk.make_room()
        await bench.clock.advance(1.0)

        assert bench.now.state is SessionState.PAUSED
        await bench.press(CommandName.RESUME)
        await bench.until(LEG)
        assert bench.now.state is SessionState.RUNNING


async def test_a_confirmation_that_is_refused_moves_nothing_then_or_later():
    async with Bench(PLAN).at(CUP) as bench:
        bench.disk.fill()
        with pytest.raises(RecordRefusedError):
            await bench.press(CommandName.CONFIRM)
        bench.disk.make_room()
        await bench.clock.advance(10.0)

        assert bench.robot.moves == []
        assert bench.present == CUP


async def test_every_line_of_a_session_may_be_refused_once():
    async with Bench(make_plan((1,), stable_s=0.2, settle_s=0.1)) as bench:
        keep, turn = bench.disk.append, False

        async def append(entry):
            nonlocal turn
            turn = not turn
            if turn:
                raise RecordRefusedError("database is locked")
            return await keep(entry)

        bench.disk.append = append
        bench.disk.make_room()
        while bench.now.state is not SessionState.FINISHED:
            if CommandName.START in bench.now.acts:
                await press_until_kept(bench, CommandName.START, None)
                continue
            await bench.clear_hands(bench.present)
            bench.hands.do_as_asked(bench.present)
            if CommandName.CONFIRM in bench.now.acts:
                await press_until_kept(bench, CommandName.CONFIRM, bench.present)
            await bench.clock.advance(0.5)

        measured = [entry.step_id for entry in bench.disk.entries if entry.length is not None]
        assert len(measured) == len(set(measured))
        assert await bench.running is SessionState.FINISHED


async def press_until_kept(bench, name, step_id):
    for _ in range(5):
        try:
            await bench.press(name, step_id=step_id)
        except RecordRefusedError:
            continue
        break
    await turns()


async def test_a_session_that_is_taken_up_on_a_full_disk_waits_for_it():
    async with Bench(PLAN).at(CUP) as bench:
        bench.disk.fill()
        await bench.restart()
        await asyncio.sleep(0)

        assert bench.now.state is SessionState.AWAITING_CONFIRMATION
        assert bench.runner.trouble is not None
        bench.disk.make_room()
        await turns()

        assert bench.states()[-1] is SessionState.AWAITING_CONFIRMATION
        await bench.press(CommandName.CONFIRM, step_id=None)
        assert bench.now.state is SessionState.RUNNING
