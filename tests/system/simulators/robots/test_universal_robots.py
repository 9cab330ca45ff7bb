"""The driver of Universal Robots on the simulated controller, with the arm moving in its own time."""

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
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_drivers.universal_robots.driver import Ports, UniversalRobot
from truepose_drivers.universal_robots.script import RobotMode, RuntimeState, SafetyMode
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.kinds import RobotHangs, RobotRefuses
from truepose_simulators.instruments.robot.universal_robots import Controller, Programs
from truepose_simulators.instruments.robot.universal_robots_ports import (
    Dashboard,
    dashboard_endpoint,
    rtde_endpoint,
    script_endpoint,
)
from truepose_simulators.scenarios.file import load_scenario

pytestmark = pytest.mark.simulated_time

HOME = tuple(np.radians([0.0, -90.0, -90.0, -90.0, 90.0, 0.0]))
AWAY = (np.radians(60.0), *HOME[1:])  # at 20 deg/s: three seconds
LIMITS = MotionLimits(tool_speed_mm_s=1e5)


class Bench:
    """A UR10 in a cell, served in memory."""

    def __init__(self) -> None:
        clock = CellClock(1, wall_s=asyncio.get_running_loop().time)
        self.cell = Cell(replace(load_scenario("ur10-clean"), noise=False), 1, clock)
        self.controller = Controller(self.cell)
        self.programs = Programs(self.controller)
        self.ends: list = []

    def driver(self) -> UniversalRobot:
        endpoints = (
            rtde_endpoint(self.controller),
            script_endpoint(self.programs),
            dashboard_endpoint(self.controller, self.programs),
        )
        links = (MemoryLink(in_memory(endpoint, self.ends), chunk_bytes=11) for endpoint in endpoints)
        return UniversalRobot(Ports(*links), MonotonicClock())

    async def connected(self) -> UniversalRobot:
        robot = self.driver()
        await robot.connect()
        await robot.set_limits(LIMITS)
        return robot


@contextlib.asynccontextmanager
async def moving(bench: Bench, robot: UniversalRobot):
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


async def rests_within(bench: Bench, limit_s: float) -> bool:
    await asyncio.sleep(limit_s)
    return not bench.cell.robot_moves and bench.cell.robot.target_rad[0] < AWAY[0] - 0.1


async def test_the_arm_moves_for_as_long_as_it_is_waited_for_and_rests_at_its_target():
    bench = Bench()
    robot = await bench.connected()

    await robot.move_joints(AWAY)
    reading = await robot.read_joints()
    await robot.close()

    assert reading.joints_rad == pytest.approx(AWAY, abs=1e-9)
    assert not bench.cell.robot_moves
    assert bench.controller.runtime_state is RuntimeState.STOPPED


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
        await asyncio.sleep(5.0)
        assert not bench.cell.robot_moves


async def test_a_program_that_hears_nobody_moves_nothing():
    bench = Bench()
    robot = await bench.connected()
    robot._follow = lambda progress: asyncio.sleep(3.0)  # the service dies with the program sent

    await robot.move_joints(AWAY)
    await robot.close()

    assert bench.cell.robot.target_rad == pytest.approx(HOME)


@pytest.mark.parametrize("mode", [SafetyMode.PROTECTIVE_STOP, SafetyMode.ROBOT_EMERGENCY_STOP])
async def test_a_safety_stop_on_the_way_is_told_and_nothing_moves_before_it_is_cleared(mode):
    bench = Bench()
    robot = await bench.connected()
    async with moving(bench, robot) as motion:
        bench.controller.stop(mode)
        with pytest.raises(NotInitialisedError, match="stopped on its way"):
            await motion
        with pytest.raises(NotInitialisedError, match="cannot move"):
            await robot.move_joints(HOME)

        bench.controller.safety_mode = SafetyMode.NORMAL
        await robot.move_joints(HOME)
        assert bench.cell.robot.target_rad == pytest.approx(HOME)


async def test_an_arm_that_is_switched_off_does_not_move():
    bench = Bench()
    robot = await bench.connected()
    assert Dashboard(bench.controller, bench.programs).answer("power off") == "Powering off"

    with pytest.raises(NotInitialisedError, match="switched off"):
        await robot.move_joints(AWAY)
    assert bench.controller.robot_mode is RobotMode.POWER_OFF
    await robot.close()


async def test_a_target_that_the_controller_does_not_take_is_refused_with_its_words():
    bench = Bench()
    robot = await bench.connected()

    with pytest.raises(TargetRefusedError, match="joint 1 cannot go to 400"):
        await robot.move_joints((np.radians(400.0), *HOME[1:]))
    bench.cell.add_fault(RobotRefuses(move=1))
    with pytest.raises(TargetRefusedError, match="pendant"):
        await robot.move_joints(AWAY)

    await robot.move_joints(AWAY)
    await robot.close()


async def test_a_program_that_never_ends_is_left_after_a_while_and_the_arm_rests():
    bench = Bench()
    robot = await bench.connected()
    bench.cell.add_fault(RobotHangs(move=1))

    with pytest.raises(NoReplyError, match="has not arrived"):
        await robot.move_joints(AWAY)
    assert not robot.connected
    assert not bench.cell.robot_moves


async def test_a_second_program_cannot_take_the_arm():
    bench = Bench()
    first = await bench.connected()

    with pytest.raises(ConnectFailedError, match="another program"):
        await bench.driver().connect()
    await first.close()
    await asyncio.sleep(0.1)

    second = await bench.connected()
    await second.close()


async def test_a_frozen_controller_is_a_lost_link():
    bench = Bench()
    robot = await bench.connected()
    bench.controller.clock_stands = True
    await asyncio.sleep(0.1)

    with pytest.raises(NoReplyError, match="clock stands still"):
        await robot.read_joints()
    assert not robot.connected


async def test_other_clients_send_their_own_lines():
    bench = Bench()
    script = MemoryLink(in_memory(script_endpoint(bench.programs), []))
    await script.open()

    await script.send(b"movej([0.1, -1.6, -1.5, -1.5, 1.5, 0.0], a=1.4, v=1.05)\n")
    await asyncio.sleep(3.0)
    assert bench.cell.robot.target_rad[0] == 0.1
    assert not bench.cell.robot_moves

    await script.send(b"set_tcp(p[0,0,0,0,0,0])\nmovej([nan])\n")
    await asyncio.sleep(1.0)
    assert bench.cell.robot.target_rad[0] == 0.1
    await script.close()


async def test_the_dashboard_answers_line_by_line():
    bench = Bench()
    dashboard = Dashboard(bench.controller, bench.programs)

    assert dashboard.answer("get robot model") == "UR10"
    assert dashboard.answer("robotmode") == "Robotmode: RUNNING"
    assert dashboard.answer("running") == "Program running: false"
    bench.controller.stop(SafetyMode.PROTECTIVE_STOP)
    assert dashboard.answer("safetymode") == "Safetymode: PROTECTIVE_STOP"
    dashboard.answer("unlock protective stop")
    assert dashboard.answer("safetymode") == "Safetymode: NORMAL"
    assert dashboard.answer("play") == "Failed to execute: play"
    assert dashboard.answer("make coffee").startswith("could not understand")
