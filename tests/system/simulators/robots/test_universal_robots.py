"""The driver of Universal Robots on the simulated controller, with the arm moving in its own time."""

import asyncio

import pytest

from tests.contract.benches import in_memory
from tests.helpers.instruments.memory_link import MemoryLink
from tests.system.simulators.robots.arms import UniversalBench
from truepose_drivers.errors import (
    NotInitialisedError,
)
from truepose_drivers.universal_robots.script import RobotMode, SafetyMode
from truepose_simulators.instruments.robot.universal_robots_ports import (
    Dashboard,
    script_endpoint,
)

pytestmark = pytest.mark.simulated_time


async def test_a_program_that_hears_nobody_moves_nothing():
    bench = UniversalBench()
    robot = await bench.connected()
    robot._follow = lambda progress: asyncio.sleep(3.0)  # the service dies with the program sent

    await robot.move_joints(bench.away)
    await robot.close()

    assert bench.cell.robot.target_rad == pytest.approx(bench.home)


async def test_an_arm_that_is_switched_off_does_not_move():
    bench = UniversalBench()
    robot = await bench.connected()
    assert Dashboard(bench.controller, bench.programs).answer("power off") == "Powering off"

    with pytest.raises(NotInitialisedError, match="switched off"):
        await robot.move_joints(bench.away)
    assert bench.controller.robot_mode is RobotMode.POWER_OFF
    await robot.close()


async def test_other_clients_send_their_own_lines():
    bench = UniversalBench()
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
    bench = UniversalBench()
    dashboard = Dashboard(bench.controller, bench.programs)

    assert dashboard.answer("get robot model") == "UR10"
    assert dashboard.answer("robotmode") == "Robotmode: RUNNING"
    assert dashboard.answer("running") == "Program running: false"
    bench.controller.safety_mode = SafetyMode.PROTECTIVE_STOP
    assert dashboard.answer("safetymode") == "Safetymode: PROTECTIVE_STOP"
    dashboard.answer("unlock protective stop")
    assert dashboard.answer("safetymode") == "Safetymode: NORMAL"
    assert dashboard.answer("play") == "Failed to execute: play"
    assert dashboard.answer("make coffee").startswith("could not understand")
