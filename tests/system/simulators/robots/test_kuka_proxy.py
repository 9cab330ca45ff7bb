"""The driver behind a variable proxy on the simulated controller, with the arm moving in its own time."""

import asyncio
import contextlib
from dataclasses import replace

import numpy as np
import pytest

from tests.contract.benches import in_memory
from tests.helpers.instruments.memory_link import MemoryLink
from truepose_drivers.api import MotionLimits
from truepose_drivers.errors import (
    ConnectionLostError,
    NotInitialisedError,
    RemoteProtocolError,
    TargetRefusedError,
)
from truepose_drivers.kuka_variable_proxy.driver import KukaRobot
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.kinds import EmergencyStop, RobotRefuses
from truepose_simulators.instruments.robot.kuka import Variables, proxy_endpoint
from truepose_simulators.scenarios.file import load_scenario

pytestmark = pytest.mark.simulated_time

LIMITS = MotionLimits(tool_speed_mm_s=1e5)  # 20 deg/s
TARGET = tuple(np.radians([30.0, -70.0, 40.0, 10.0, 20.0, 30.0]).tolist())
HOME = tuple(np.radians([0.0, -90.0, 90.0, 0.0, 0.0, 0.0]).tolist())
AWAY = (np.radians(60.0), *HOME[1:])
PACE_DEG_S = 360.0 * 0.05  # of joint 1


class Bench:
    """An arm in a cell, served in memory."""

    def __init__(self) -> None:
        clock = CellClock(1, wall_s=asyncio.get_running_loop().time)
        self.cell = Cell(replace(load_scenario("kr6-clean"), noise=False), 1, clock)
        self.variables = Variables(self.cell)
        self.endpoint = proxy_endpoint(self.cell, self.variables)
        self.ends: list = []

    async def connected(self) -> KukaRobot:
        robot = KukaRobot(MemoryLink(in_memory(self.endpoint, self.ends), chunk_bytes=11), MonotonicClock())
        await robot.connect()
        await robot.set_limits(LIMITS)
        return robot

    def shown_deg(self) -> float:
        return float(np.degrees(self.variables.joints()[0]))


@contextlib.asynccontextmanager
async def moving(bench, robot):
    """Have the arm a second under way; yields the motion, which is ended with the context."""
    motion = asyncio.create_task(robot.move_joints(AWAY))
    while not bench.cell.robot_moves:
        await asyncio.sleep(0.01)
    await asyncio.sleep(1.0)
    assert bench.cell.robot_moves
    try:
        yield motion
    finally:
        motion.cancel()
        await asyncio.wait({motion})
        await robot.close()


async def rests_within(bench, limit_s) -> bool:
    await asyncio.sleep(limit_s)
    stands_deg = bench.shown_deg()
    await asyncio.sleep(5.0)
    return bench.shown_deg() == stands_deg and 5.0 < stands_deg < 40.0


async def test_the_arm_moves_for_as_long_as_it_is_waited_for_and_rests_at_its_target():
    bench = Bench()
    robot = await bench.connected()

    await robot.move_joints(TARGET)
    reading = await robot.read_joints()
    await robot.close()

    assert reading.joints_rad == pytest.approx(TARGET, abs=1e-6)
    assert bench.cell.robot.target_rad == pytest.approx(TARGET, abs=1e-6)
    assert not bench.cell.robot_moves


async def test_joints_are_read_while_the_arm_moves():
    bench = Bench()
    robot = await bench.connected()
    async with moving(bench, robot) as motion:
        under_way = np.degrees((await robot.read_joints()).joints_rad[0])
        await motion

    assert under_way == pytest.approx(PACE_DEG_S, rel=0.1)


async def test_an_arm_whose_service_is_gone_rests_within_a_second():
    bench = Bench()
    async with moving(bench, await bench.connected()) as motion:
        motion.cancel()

        assert await rests_within(bench, 1.0)


async def test_an_arm_whose_network_is_gone_rests_within_a_second_and_nothing_goes_on():
    bench = Bench()
    async with moving(bench, await bench.connected()) as motion:
        for end in bench.ends:
            end.close()

        assert await rests_within(bench, 1.0)
        with pytest.raises(ConnectionLostError):
            await motion


async def test_beats_that_do_not_change_are_none():
    bench = Bench()
    robot = await bench.connected()
    async with moving(bench, robot) as motion:
        bench.variables._writable = {**bench.variables._writable, "TP_BEAT": lambda value: None}

        assert await rests_within(bench, 1.0)
        with pytest.raises(ConnectionLostError, match="heard nothing"):
            await motion


async def test_an_order_after_which_nobody_is_heard_moves_nothing():
    bench = Bench()
    robot = await bench.connected()
    robot._program._arrived = lambda number, since_s: asyncio.sleep(3.0, result=True)

    with pytest.raises(RemoteProtocolError, match="off its target"):
        await robot.move_joints(TARGET)

    assert bench.cell.robot.target_rad == pytest.approx(HOME)
    assert bench.variables.program.state.given_up == 1


async def test_after_a_cut_link_the_arm_is_reached_within_five_seconds():
    bench = Bench()
    async with moving(bench, await bench.connected()):
        for end in bench.ends:
            end.close()
        cut_s = asyncio.get_running_loop().time()
        again = await bench.connected()
        await again.read_joints()
        assert asyncio.get_running_loop().time() - cut_s < 5.0

        with pytest.raises(NotInitialisedError, match="still moves"):
            await again.move_joints(TARGET)
        await asyncio.sleep(1.0)
        await again.move_joints(TARGET)
        assert bench.cell.robot.target_rad == pytest.approx(TARGET, abs=1e-6)
        await again.close()


async def test_an_emergency_stop_on_the_way_is_told_and_nothing_moves_before_it_is_released():
    bench = Bench()
    robot = await bench.connected()
    async with moving(bench, robot) as motion:
        bench.cell.add_fault(EmergencyStop(for_s=3.0))
        with pytest.raises(NotInitialisedError, match="stopped on its way"):
            await motion
        with pytest.raises(NotInitialisedError, match="no program runs"):
            await robot.move_joints(TARGET)
        await asyncio.sleep(3.0)

        await robot.move_joints(TARGET)
        assert bench.cell.robot.target_rad == pytest.approx(TARGET, abs=1e-6)


async def test_a_target_that_the_controller_does_not_take_is_refused_and_the_next_one_reached():
    bench = Bench()
    robot = await bench.connected()

    with pytest.raises(TargetRefusedError, match=r"50\.000"):
        await robot.move_joints((0.0, np.radians(50.0), *HOME[2:]))
    bench.cell.add_fault(RobotRefuses(move=1))
    with pytest.raises(TargetRefusedError):
        await robot.move_joints(TARGET)

    await robot.move_joints(TARGET)
    await robot.close()


async def test_a_client_that_is_silent_for_half_a_minute_is_dropped_and_ours_is_not():
    bench = Bench()
    robot = await bench.connected()
    link = MemoryLink(in_memory(bench.endpoint, []))
    await link.open()

    await asyncio.sleep(120.0)

    with pytest.raises(ConnectionLostError):
        await link.receive(0.1)
    assert (await robot.read_joints()).joints_rad
    await robot.close()


async def test_several_clients_read_the_same_arm():
    bench = Bench()
    first, second = await bench.connected(), await bench.connected()

    await first.move_joints(TARGET)

    assert (await second.read_joints()).joints_rad == pytest.approx(TARGET, abs=1e-6)
    await first.close()
    await second.close()
