"""A ballbar session on a disk that takes its time or takes nothing, and on answers that come late."""

import asyncio

import pytest

from tests.unit.service.sessions.ballbar.fakes import Bench, turns
from tests.unit.service.sessions.ballbar.sessions import CUP, LEG, PLAN, POSE, make_plan
from truepose.domain.session import SessionState
from truepose.sessions.engine.commands import CommandName, OperatorCommand
from truepose.sessions.errors import NotNowError


class DiskFullError(Exception):
    """The disk takes nothing."""


def take_time(bench, lasts_s):
    """Have every line take so long to reach the disk."""
    keep = bench.disk.append

    async def append(entry):
        await bench.clock.sleep(lasts_s)
        return await keep(entry)

    bench.disk.append = append


def press(bench, name, key, step_id=None, tablet="one"):
    return asyncio.create_task(bench.runner.act(OperatorCommand(name, "Eva", tablet, key, step_id)))


async def begin_motion(bench, step_id):
    """Confirm a motion and return once the arm is under way."""
    confirmed = press(bench, CommandName.CONFIRM, "c", step_id)
    for _ in range(40):
        await bench.clock.advance(0.05)
        if bench.robot.under_way:
            break
    assert bench.robot.under_way
    await confirmed


async def test_the_button_and_the_ballbar_do_not_wait_for_each_other():
    async with Bench(PLAN).at(LEG) as bench:
        await bench.clear_hands(LEG)
        take_time(bench, 0.5)  # longer than a length must stand still to be stored by itself
        bench.hands.do_as_asked(LEG)
        handed_over = press(bench, CommandName.HAND_OVER, "h", tablet="two")
        await turns()

        stored = press(bench, CommandName.STORE, "s", LEG, tablet="two")
        await bench.clock.advance(5.0)

        assert handed_over.done()
        assert stored.done()
        stored.exception()  # either may have been first
        assert len(bench.kept(LEG)) == 1


async def test_the_end_may_be_asked_for_while_a_pause_is_being_kept():
    async with Bench(PLAN).at(CUP) as bench:
        take_time(bench, 0.4)
        bench.robot.motion_s = 0.2  # it ends before the pause is on the disk
        await begin_motion(bench, CUP)
        paused = press(bench, CommandName.PAUSE, "p")
        await turns()

        ended = press(bench, CommandName.ABORT, "a")
        await bench.clock.advance(5.0)

        assert (await paused).entry < (await ended).entry
        assert bench.now.state is SessionState.ABORTED


async def test_a_stop_that_the_disk_does_not_take_stops_all_the_same():
    async with Bench(PLAN).at(POSE) as bench:
        before = len(bench.robot.moves)
        await begin_motion(bench, POSE)

        async def append(entry):
            raise DiskFullError

        bench.disk.append = append
        with pytest.raises(DiskFullError):
            await press(bench, CommandName.STOP, "s")
        await bench.clock.advance(5.0)

        assert len(bench.robot.moves) == before + 1  # not on to the target
        with pytest.raises(DiskFullError):
            await bench.running


@pytest.mark.parametrize("ending", [True, False])
async def test_a_failure_on_a_full_disk_is_on_record_once_there_is_room(ending):
    async with Bench(PLAN).at(CUP) as bench:
        if ending:
            await begin_motion(bench, CUP)
            await bench.press(CommandName.ABORT, step_id=None)
        bench.disk.fill()
        bench.runner._readings.poll = unplugged
        await bench.clock.advance(1.0)

        assert not bench.running.done()
        bench.disk.make_room()
        with pytest.raises(RuntimeError, match="a mistake of the program"):
            await bench.running
        assert bench.states()[-1] is (SessionState.ABORTED if ending else SessionState.AWAITING_CONFIRMATION)


async def unplugged(*_, **__):
    raise RuntimeError("a mistake of the program")


async def test_a_run_ends_with_what_failed_first_also_where_that_cannot_be_put_on_record():
    async with Bench(PLAN).at(LEG) as bench:

        async def lost():
            raise DiskFullError

        bench.runner._readings.poll = unplugged
        bench.clock.now_s = lost
        await bench.clock.advance(1.0)

        with pytest.raises(RuntimeError, match="a mistake of the program") as raised:
            await bench.running
        assert raised.value.__notes__ == ["The error could not be saved either (DiskFullError): "]


async def test_a_button_pressed_before_the_restart_is_on_record_comes_after_it():
    async with Bench(PLAN).at(CUP) as bench:
        await bench.kill()
        bench.runner = bench._runner()

        confirmed = press(bench, CommandName.CONFIRM, "c")
        bench.running = asyncio.create_task(bench.runner.run())
        await confirmed
        await bench.clock.advance(1.0)

        assert bench.states()[-2:] == [SessionState.AWAITING_CONFIRMATION, SessionState.RUNNING]
        assert bench.now.state is SessionState.RUNNING
        assert bench.robot.moves == []


async def test_nothing_moves_on_a_statement_that_was_under_way_for_long():
    plan = make_plan((1, 2), state_age_s=0.05, settle_s=0.1)
    async with Bench(plan).at(CUP) as bench:
        read = bench.robot.read_joints

        async def late():
            await asyncio.sleep(0.2)  # of the wall's clock; the statement carries the time of its arrival
            return await read()

        bench.robot.read_joints = late
        await bench.press(CommandName.CONFIRM)
        for _ in range(100):
            await bench.clock.advance(0.01)
            await asyncio.sleep(0.02)

        assert bench.robot.moves == []
        assert bench.now.state is SessionState.AWAITING_CONFIRMATION


async def test_a_pose_is_skipped_also_where_the_ballbar_was_to_be_put_on_its_calibrator():
    async with Bench(PLAN).at(LEG) as bench:
        await bench.replug()
        assert bench.present == f"{LEG}/initialise"

        await bench.press(CommandName.SKIP, reason="it will not come back")

        assert bench.present == "placement-1/pose-1/detach"
        await bench.press(CommandName.BACK)
        assert bench.present == f"{LEG}/initialise"


async def test_a_skip_names_its_step_also_while_the_session_rests():
    async with Bench(PLAN) as bench:
        bench.oracle.answer = RuntimeError("no memory")
        await bench.start()
        await bench.until("placement-1/precalibrate-1")
        await bench.clock.advance(0.5)
        assert bench.now.state is SessionState.PAUSED

        with pytest.raises(NotNowError, match="precalibrate-1"):
            await bench.press(CommandName.SKIP, reason="not wanted", step_id=None)


async def test_who_begins_to_watch_a_run_that_is_over_is_let_go():
    async with Bench(PLAN) as bench:
        await bench.start()
        await bench.kill()

        seen = [sample async for sample in bench.runner.live()]

        assert seen == []
