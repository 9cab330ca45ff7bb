"""What holds of every simulated controller that watches its client: motions, stops, lost links, refusals."""

import asyncio
from functools import partial

import numpy as np
import pytest

from tests.system.simulators.robots.arms import FanucBench, KukaBench, UniversalBench, WebBench
from truepose_drivers.errors import (
    ConnectFailedError,
    ConnectionLostError,
    NoReplyError,
    NotInitialisedError,
    TargetRefusedError,
)
from truepose_simulators.faults.kinds import EmergencyStop, ProtectiveStop, RobotHangs, RobotRefuses

pytestmark = pytest.mark.simulated_time

benches = partial(pytest.mark.parametrize, "make_bench")
every_bench = benches([FanucBench, KukaBench, UniversalBench, WebBench])


@every_bench
async def test_the_arm_moves_for_as_long_as_it_is_waited_for_and_rests_at_its_target(make_bench):
    bench = make_bench()
    robot = await bench.connected()

    await robot.move_joints(bench.target)
    moves = bench.cell.robot_moves
    reading = await robot.read_joints()
    await robot.close()

    assert not moves
    assert reading.joints_rad == pytest.approx(bench.target, abs=bench.reads_to_rad)
    assert bench.cell.robot.target_rad == pytest.approx(bench.target, abs=bench.arrives_to_rad)


@pytest.mark.parametrize(
    ("make_bench", "least_deg", "most_deg"),
    [
        (KukaBench, 16.2, 19.8),  # a second after it set off, at 5 % of 360 deg/s, and 10 %
        (WebBench, np.degrees(0.2), 60.0),
    ],
)
async def test_joints_are_read_while_the_arm_moves(make_bench, least_deg, most_deg):
    bench = make_bench()
    robot = await bench.connected()

    async with bench.moving(robot):
        first, second = [np.degrees((await robot.read_joints()).joints_rad[0]) for _ in range(2)]

    assert least_deg < first <= second < most_deg


@every_bench
async def test_an_arm_whose_service_is_gone_rests_within_a_second(make_bench):
    bench = make_bench()
    async with bench.moving(await bench.connected()) as motion:
        motion.cancel()

        assert await bench.rests_within(1.0)
        assert bench.gave_up()


@every_bench
async def test_an_arm_whose_network_is_gone_rests_within_a_second_and_nothing_goes_on(make_bench):
    bench = make_bench()
    async with bench.moving(await bench.connected()) as motion:
        bench.hang_up()

        assert await bench.rests_within(1.0)
        with pytest.raises(ConnectionLostError):
            await motion


@benches([FanucBench, KukaBench])
async def test_after_a_cut_link_the_arm_is_reached_within_five_seconds(make_bench):
    bench = make_bench()
    async with bench.moving(await bench.connected()):
        bench.hang_up()
        cut_s = asyncio.get_running_loop().time()

        again = await bench.connected()
        await again.read_joints()

        assert asyncio.get_running_loop().time() - cut_s < 5.0
        await asyncio.sleep(1.0)
        await again.move_joints(bench.target)
        assert bench.cell.robot.target_rad == pytest.approx(bench.target, abs=bench.arrives_to_rad)
        await again.close()


@pytest.mark.parametrize("kind", [EmergencyStop, ProtectiveStop])
@pytest.mark.parametrize(
    ("make_bench", "on_the_way", "before_it_is_released"),
    [
        (FanucBench, "fault", "SRVO-001"),
        (KukaBench, "stopped during the motion", "no program runs"),
        (UniversalBench, "stopped during the motion", "cannot move"),
        (WebBench, "stopped during the motion", "cannot move"),
    ],
)
async def test_a_stop_on_the_way_is_told_and_nothing_moves_before_it_is_released(
    make_bench, on_the_way, before_it_is_released, kind
):
    bench = make_bench()
    robot = await bench.connected()
    async with bench.moving(robot) as motion:
        bench.cell.add_fault(kind(for_s=3.0))
        with pytest.raises(NotInitialisedError, match=on_the_way):
            await motion
        await asyncio.sleep(0.1)  # programs look for a stop every 0.05 s
        assert not bench.cell.robot_moves
        stopped_at = bench.cell.robot.target_rad[0]
        with pytest.raises(NotInitialisedError, match=before_it_is_released):
            await robot.move_joints(bench.target)
        await asyncio.sleep(10.0)
        assert bench.cell.robot.target_rad[0] == stopped_at  # a release starts nothing

        await robot.move_joints(bench.target)

        assert bench.cell.robot.target_rad == pytest.approx(bench.target, abs=bench.arrives_to_rad)


@pytest.mark.parametrize(
    ("make_bench", "beyond_deg", "said_of_it", "said_of_a_fault"),
    [
        (FanucBench, (175.0, 0.0, 0.0, 0.0, 0.0, 0.0), "MOTN-017", "MOTN-023"),
        (KukaBench, (0.0, 50.0, 90.0, 0.0, 0.0, 0.0), r"50\.000", "pendant"),
        (UniversalBench, (400.0, -90.0, -90.0, -90.0, 90.0, 0.0), "joint 1 cannot go to 400", "pendant"),
        (WebBench, (400.0, 0.0, 0.0, 0.0, 0.0, 0.0), "joint 1 cannot go to 400", "pendant"),
    ],
)
async def test_a_target_that_the_controller_does_not_take_is_refused_and_the_next_one_reached(
    make_bench, beyond_deg, said_of_it, said_of_a_fault
):
    bench = make_bench()
    robot = await bench.connected()

    with pytest.raises(TargetRefusedError, match=said_of_it):
        await robot.move_joints(tuple(np.radians(beyond_deg)))
    bench.cell.add_fault(RobotRefuses(move=1))
    with pytest.raises(TargetRefusedError, match=said_of_a_fault):
        await robot.move_joints(bench.target)
    await robot.move_joints(bench.target)

    assert bench.cell.robot.target_rad == pytest.approx(bench.target, abs=bench.arrives_to_rad)
    await robot.close()


@pytest.mark.parametrize(
    ("make_bench", "said"),
    [
        (FanucBench, "end of its motion"),
        (UniversalBench, "has not reached its target"),
        (WebBench, "has not moved for 3 s"),
    ],
)
async def test_a_motion_whose_end_is_never_reported_is_given_up(make_bench, said):
    bench = make_bench()
    bench.cell.add_fault(RobotHangs(move=1))
    robot = await bench.connected()

    with pytest.raises(NoReplyError, match=said):
        await robot.move_joints(bench.target)

    assert not robot.connected
    assert not bench.cell.robot_moves


@pytest.mark.parametrize(
    ("make_bench", "said"), [(FanucBench, "no other program"), (UniversalBench, "another program")]
)
async def test_a_second_program_cannot_take_the_arm(make_bench, said):
    bench = make_bench()
    first = await bench.connected()

    with pytest.raises(ConnectFailedError, match=said):
        await bench.connected()

    await first.close()
    await asyncio.sleep(1.0)
    second = await bench.connected()
    await second.close()


@pytest.mark.parametrize(
    ("make_bench", "said"), [(FanucBench, "repeats old data"), (UniversalBench, "clock has stopped")]
)
async def test_a_frozen_controller_is_a_lost_link(make_bench, said):
    bench = make_bench()
    robot = await bench.connected()
    await robot.read_joints()
    bench.controller.clock_stands = True
    await asyncio.sleep(0.1)

    with pytest.raises(NoReplyError, match=said):
        await robot.read_joints()

    assert not robot.connected
