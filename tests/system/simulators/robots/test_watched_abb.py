"""open_abb moves a simulated IRC5, and the web services of the same controller watch it."""

import asyncio
import contextlib
import math
from dataclasses import replace

import pytest

from tests.contract.benches import in_memory
from tests.helpers.instruments.memory_link import MemoryLink
from truepose_drivers.abb_open_abb.driver import PLUGIN, OpenAbbRobot
from truepose_drivers.abb_rws.companion import RwsCompanion
from truepose_drivers.abb_rws.conversation import RwsSession
from truepose_drivers.abb_rws.http import Login
from truepose_drivers.abb_rws.protocol import ControllerState, OperationMode
from truepose_drivers.api import MotionGuard, MotionLimits
from truepose_drivers.arm_motion import AccompaniedRobot
from truepose_drivers.errors import ConnectFailedError, DeviceRefusedError, LinkError, NotInitialisedError
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.kinds import EmergencyStop, RobotRefuses
from truepose_simulators.instruments.robot.abb_rws.controller import AbbController
from truepose_simulators.instruments.robot.abb_rws.server import web_endpoint
from truepose_simulators.instruments.robot.open_abb import MotionProgram, robot_endpoint
from truepose_simulators.scenarios.file import load_scenario

pytestmark = pytest.mark.simulated_time

AWAY = (math.radians(60.0), 0.0, 0.0, 0.0, 0.0, 0.0)  # at 20 deg/s: three seconds
LIMITS = MotionLimits(tool_speed_mm_s=1e5)


class Bench:
    """An IRB 120 whose controller has both ports, served in memory."""

    def __init__(self, server="stock", refusal="drop") -> None:
        clock = CellClock(1, wall_s=asyncio.get_running_loop().time)
        scenario = replace(load_scenario("irb120-clean"), noise=False)
        arm = replace(scenario.arm, server=server, refusal=refusal)
        self.cell = Cell(replace(scenario, arm=arm), 1, clock)
        self.controller = AbbController(self.cell)
        self.ends: list = []
        self.motion = robot_endpoint(self.cell, MotionProgram(self.cell, self.controller))
        self.services = web_endpoint(self.cell, self.controller, "robot-rws")

    def driver(self, login=None) -> AccompaniedRobot:
        clock = MonotonicClock()
        session = RwsSession(self._link(self.services), login or Login("Default User", "robotics"))
        return AccompaniedRobot(OpenAbbRobot(self._link(self.motion), clock), RwsCompanion(session, clock))

    def _link(self, endpoint):
        return MemoryLink(in_memory(endpoint, self.ends), chunk_bytes=97)


@contextlib.asynccontextmanager
async def connected(bench: Bench):
    robot = bench.driver()
    await robot.connect()
    await robot.set_limits(LIMITS)
    try:
        yield robot
    finally:
        await robot.close()


async def test_the_joints_come_with_more_digits_than_open_abb_has():
    bench = Bench()
    async with connected(bench) as robot:
        await robot.move_joints(tuple(map(math.radians, (10.12345, 0.0, 0.0, 0.0, 0.0, 0.0))))
        reading = await robot.read_joints()

    assert math.degrees(reading.joints_rad[0]) == pytest.approx(10.12345, abs=1e-6)
    assert math.degrees(reading.resolution_rad) == pytest.approx(1e-4)


@pytest.mark.parametrize(
    ("spoil", "match"),
    [
        (lambda irc5: irc5.switch(ControllerState.MOTORS_OFF), "motors are off"),
        (lambda irc5: irc5.stop(), "program is stopped"),
        (lambda irc5: setattr(irc5, "speed_percent", 0.0), "override is 0 %"),
    ],
)
async def test_an_arm_that_cannot_move_is_not_sent_anywhere(spoil, match):
    bench = Bench()
    async with connected(bench) as robot:
        spoil(bench.controller)
        with pytest.raises(NotInitialisedError, match=match):
            await robot.move_joints(AWAY)
        assert robot.connected

    assert not bench.cell.robot.target_rad.any()


async def test_an_override_that_somebody_turns_down_is_told_before_the_next_motion():
    bench = Bench()
    bench.controller.speed_percent = 70.0
    async with connected(bench) as robot:
        told = [robot.motion_guard]
        bench.controller.speed_percent = 40.0
        await robot.read_joints()
        told.append(robot.motion_guard)
        began_s = bench.cell.clock.now_s
        await robot.move_joints(AWAY)

    assert told == [MotionGuard(longest_piece_s=1.0, speed_share=share) for share in (0.7, 0.4)]
    assert bench.cell.clock.now_s - began_s == pytest.approx(60.0 / (0.4 * 20.0), abs=0.1)  # so slow it is


async def test_a_person_with_the_enabling_device_may_move_the_arm():
    bench = Bench()
    bench.controller.mode = OperationMode.MANUAL_REDUCED
    async with connected(bench) as robot:
        await robot.move_joints(AWAY)

    assert bench.cell.robot.target_rad == pytest.approx(AWAY)


@pytest.mark.parametrize("server", ["stock", "truepose"])
async def test_a_stop_on_the_way_is_told_at_once(server):
    bench = Bench(server, refusal="hang")
    now_s = bench.cell.clock.now_s
    async with connected(bench) as robot:
        bench.cell.add_fault(EmergencyStop(from_s=now_s + 2.0, until_s=now_s + 5.0))
        with pytest.raises(NotInitialisedError, match="emergency stop is active"):
            await robot.move_joints(AWAY)

        assert bench.cell.clock.now_s - now_s < 3.0  # the stock server alone says nothing for a minute
    assert bench.cell.robot.target_rad[0] < AWAY[0] - 0.1


async def test_why_a_target_was_refused_is_in_the_event_log():
    bench = Bench()
    async with connected(bench) as robot:
        bench.controller._note(3, 50027, "Joint Out of Range", "Position for joint 1 is out of range.")
        bench.cell.add_fault(RobotRefuses(move=1))
        with pytest.raises(LinkError, match=r"its event log ends with .50027 Joint Out of Range: Position"):
            await robot.move_joints(AWAY)


async def test_a_motion_that_nobody_watches_any_more_is_given_up():
    bench = Bench("truepose")
    async with connected(bench) as robot:
        motion = asyncio.create_task(robot.move_joints(AWAY))
        await asyncio.sleep(1.0)
        bench.ends[1].close()  # the web services' connection
        with pytest.raises(LinkError):
            await motion

        assert bench.cell.robot_moves  # in memory: what our server then does has tests of its own
        assert not robot._robot.connected


async def test_without_its_watch_a_robot_is_not_connected():
    bench = Bench()
    robot = bench.driver(Login("Default User", "wrong"))

    with pytest.raises(DeviceRefusedError, match="rejected user"):
        await robot.connect()
    assert not robot.connected


async def test_the_options_say_who_watches():
    host = {"host": "127.0.0.1"}

    assert isinstance(PLUGIN.open(host, None), OpenAbbRobot)
    assert isinstance(
        PLUGIN.open(host | {"rws_port": 80, "user": "me", "password": "x"}, None), AccompaniedRobot
    )
    assert isinstance(PLUGIN.open(host | {"egm_port": 6510}, None), AccompaniedRobot)
    with pytest.raises(ConnectFailedError):
        await PLUGIN.open(host | {"port": 1, "rws_port": 80}, None).connect()
