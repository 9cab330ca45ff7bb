"""The driver of the Remote Motion Interface on the simulated controller, the arm moving in its time."""

import asyncio
import contextlib
from dataclasses import replace

import numpy as np
import pytest

from tests.contract.benches import in_memory
from tests.helpers.instruments.memory_link import MemoryLink
from truepose_drivers.api import MotionLimits
from truepose_drivers.errors import (
    ConnectFailedError,
    ConnectionLostError,
    NoReplyError,
    NotInitialisedError,
    TargetRefusedError,
)
from truepose_drivers.fanuc_rmi.driver import RmiRobot
from truepose_drivers.fanuc_rmi.protocol import CONNECT_PORT
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.kinds import EmergencyStop, RobotHangs, RobotRefuses
from truepose_simulators.instruments.robot.fanuc_rmi.controller import Controller
from truepose_simulators.instruments.robot.fanuc_rmi.endpoints import connect_endpoint, session_endpoint
from truepose_simulators.instruments.robot.fanuc_rmi.program import RmiMove
from truepose_simulators.scenarios.file import load_scenario

pytestmark = pytest.mark.simulated_time

LIMITS = MotionLimits(tool_speed_mm_s=1e5)  # 20 deg/s
TARGET = tuple(np.radians([30.0, 20.0, -50.0, 10.0, 20.0, 30.0]).tolist())
AWAY = tuple(np.radians([60.0, 0.0, 0.0, 0.0, 0.0, 0.0]).tolist())  # three seconds


class Bench:
    """An LR Mate in a cell, served in memory; it forgets no byte that was sent before a link was cut."""

    def __init__(self, **changes) -> None:
        clock = CellClock(1, wall_s=asyncio.get_running_loop().time)
        self.cell = Cell(replace(load_scenario("lrmate-rmi"), noise=False), 1, clock)
        self.controller = Controller(self.cell, **changes)
        self.program = RmiMove(self.controller)
        self.session = session_endpoint(self.controller, self.program)
        self.first = connect_endpoint(self.session)
        self.ends: list = []

    def link(self, port: int) -> MemoryLink:
        endpoint = self.first if port == CONNECT_PORT else self.session
        return MemoryLink(in_memory(endpoint, self.ends), chunk_bytes=11)

    async def connected(self) -> RmiRobot:
        robot = RmiRobot(self.link, MonotonicClock())
        await robot.connect()
        await robot.set_limits(LIMITS)
        return robot

    def shown_deg(self) -> float:
        return float(np.degrees(self.controller.joints()[0]))


class SilentLink(MemoryLink):
    """A link whose cable can be cut: nothing arrives any more on either side, and nobody is told."""

    cut = False

    async def send(self, data):
        if not self.cut:
            await super().send(data)

    async def receive(self, timeout_s):
        data = await super().receive(timeout_s)
        return None if self.cut else data

    async def close(self):
        if not self.cut:
            await super().close()


@contextlib.asynccontextmanager
async def moving(bench, robot):
    """Have the arm a second under way; yields the motion, which is ended with the context."""
    motion = asyncio.create_task(robot.move_joints(AWAY))
    while not bench.cell.robot_moves:
        await asyncio.sleep(0.01)
    await asyncio.sleep(1.0)
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
    return bench.shown_deg() == stands_deg and 10.0 < stands_deg < 50.0


async def test_the_arm_moves_for_as_long_as_it_is_waited_for_and_rests_at_its_target():
    bench = Bench()
    robot = await bench.connected()

    await robot.move_joints(TARGET)
    reading = await robot.read_joints()
    await robot.close()

    assert reading.joints_rad == pytest.approx(TARGET, abs=1e-5)
    assert bench.cell.robot.target_rad == pytest.approx(TARGET, abs=1e-7)
    assert not bench.cell.robot_moves


async def test_the_tool_turns_no_faster_than_it_was_told():
    bench = Bench()
    robot = await bench.connected()
    begun_s = bench.cell.clock.now_s

    await robot.move_joints(AWAY)

    # 60 deg of joint 1 at 5 % of 350 deg/s
    assert bench.cell.clock.now_s - begun_s == pytest.approx(60.0 / 17.5, abs=0.05)
    await robot.close()


async def test_an_arm_whose_service_is_gone_rests_within_a_second():
    bench = Bench()
    async with moving(bench, await bench.connected()) as motion:
        motion.cancel()

        assert await rests_within(bench, 1.0)
        assert not bench.controller.status.running


async def test_an_arm_whose_service_was_killed_rests_within_a_second():
    bench = Bench()
    async with moving(bench, await bench.connected()) as motion:
        for end in bench.ends:
            end.close()

        assert await rests_within(bench, 1.0)
        assert motion.done()


@pytest.mark.parametrize("override", [100, 10])
async def test_an_arm_whose_cable_was_cut_rests_within_a_second_and_is_missed_within_two(override):
    bench = Bench()
    bench.controller.status = replace(bench.controller.status, override_percent=override)
    links = []

    def to_port(port):
        links.append(SilentLink(bench.link(port)._serve))
        return links[-1]

    robot = RmiRobot(to_port, MonotonicClock())
    await robot.connect()
    await robot.set_limits(LIMITS)
    motion = asyncio.create_task(robot.move_joints(AWAY))
    while bench.shown_deg() < 1.0:
        await asyncio.sleep(0.01)
    cut_s = asyncio.get_running_loop().time()
    for link in links:
        link.cut = True

    with pytest.raises(NoReplyError):
        await motion
    assert asyncio.get_running_loop().time() - cut_s < 2.0
    stands_deg = bench.shown_deg()
    await asyncio.sleep(5.0)

    assert bench.shown_deg() == stands_deg
    assert bench.cell.robot.motion.start_s + bench.cell.robot.motion.duration_s <= cut_s + 1.0


async def test_after_a_cut_link_the_arm_is_reached_within_five_seconds():
    bench = Bench()
    async with moving(bench, await bench.connected()):
        for end in bench.ends:
            end.close()
        cut_s = asyncio.get_running_loop().time()

        again = RmiRobot(bench.link, MonotonicClock())
        await again.connect()
        await again.read_joints()

        assert asyncio.get_running_loop().time() - cut_s < 5.0
        await asyncio.sleep(1.0)
        await again.move_joints(TARGET)
        assert bench.cell.robot.target_rad == pytest.approx(TARGET, abs=1e-7)
        await again.close()


async def test_a_program_that_a_dead_session_left_is_said_with_the_way_out():
    bench = Bench(strands=True)
    robot = await bench.connected()
    await robot.move_joints(TARGET)
    bench.ends[-1].close()
    with pytest.raises(ConnectionLostError):
        await robot.read_joints()
    again = await bench.connected()

    assert (await again.read_joints()).joints_rad == pytest.approx(TARGET, abs=1e-5)
    with pytest.raises(NotInitialisedError, match="delete it on the pendant"):
        await again.move_joints(AWAY)
    await again.close()


async def test_a_session_that_says_goodbye_leaves_nothing_behind():
    bench = Bench(strands=True)
    robot = await bench.connected()
    await robot.move_joints(TARGET)
    await robot.close()
    await asyncio.sleep(0.1)

    again = await bench.connected()
    await again.move_joints(AWAY)

    assert bench.cell.robot.target_rad == pytest.approx(AWAY, abs=1e-7)
    await again.close()


async def test_a_controller_that_counts_on_is_counted_with():
    bench = Bench(keeps_sequence=True)
    for target in (TARGET, AWAY):
        robot = await bench.connected()
        await robot.move_joints(target)
        await robot.close()
        await asyncio.sleep(0.1)

    assert bench.controller.status.next_sequence > 3


async def test_a_target_out_of_range_is_refused_by_name_and_the_next_one_reached():
    bench = Bench()
    robot = await bench.connected()

    with pytest.raises(TargetRefusedError, match="MOTN-017"):
        await robot.move_joints((np.radians(175.0), 0.0, 0.0, 0.0, 0.0, 0.0))
    bench.cell.add_fault(RobotRefuses(move=1))
    with pytest.raises(TargetRefusedError, match="MOTN-023"):
        await robot.move_joints(TARGET)

    await robot.move_joints(TARGET)
    assert bench.cell.robot.target_rad == pytest.approx(TARGET, abs=1e-7)
    await robot.close()


async def test_an_emergency_stop_on_the_way_is_told_and_nothing_moves_before_it_is_released():
    bench = Bench()
    robot = await bench.connected()
    async with moving(bench, robot) as motion:
        bench.cell.add_fault(EmergencyStop(for_s=3.0))
        with pytest.raises(NotInitialisedError, match="fault"):
            await motion
        assert not bench.cell.robot_moves
        with pytest.raises(NotInitialisedError, match="SRVO-001"):
            await robot.move_joints(TARGET)
        await asyncio.sleep(3.0)

        await robot.move_joints(TARGET)
        assert bench.cell.robot.target_rad == pytest.approx(TARGET, abs=1e-7)


async def test_a_motion_whose_end_is_never_reported_is_given_up():
    bench = Bench()
    bench.cell.add_fault(RobotHangs(move=1))
    robot = await bench.connected()

    with pytest.raises(NoReplyError, match="end of its motion"):
        await robot.move_joints(TARGET)
    assert not robot.connected


async def test_a_second_program_hears_nothing_while_the_first_one_is_there():
    bench = Bench()
    first = await bench.connected()

    with pytest.raises(ConnectFailedError, match="no other program"):
        await bench.connected()
    await first.close()
    await asyncio.sleep(1.0)

    await (await bench.connected()).close()


async def test_a_frozen_controller_is_a_lost_link():
    bench = Bench()
    robot = await bench.connected()
    await robot.read_joints()
    bench.controller.clock_stands = True

    with pytest.raises(NoReplyError, match="repeats itself"):
        await robot.read_joints()
    assert not robot.connected


async def test_a_session_that_another_ends_is_lost():
    bench = Bench()
    robot = await bench.connected()
    bench.ends[-1].close()

    with pytest.raises(ConnectionLostError):
        await robot.read_joints()
