"""The driver of Robot Web Services on a simulated IRC5, with the arm moving in its own time."""

import asyncio
import contextlib
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.contract.benches import in_memory
from tests.helpers.instruments.memory_link import MemoryLink
from truepose_drivers.abb_rws import protocol
from truepose_drivers.abb_rws.driver import RwsRobot
from truepose_drivers.abb_rws.http import Login
from truepose_drivers.abb_rws.motion import Patience
from truepose_drivers.abb_rws.protocol import ControllerState, OperationMode, number_text
from truepose_drivers.api import MotionGuard, MotionLimits
from truepose_drivers.errors import (
    BusyError,
    ConnectionLostError,
    DeviceRefusedError,
    DriverError,
    NoReplyError,
    NotInitialisedError,
    TargetRefusedError,
)
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.kinds import EmergencyStop, LineStalls, RobotHangs, RobotRefuses
from truepose_simulators.instruments.robot.abb_rws.controller import AbbController, OurProgram, PublicProgram
from truepose_simulators.instruments.robot.abb_rws.server import web_endpoint
from truepose_simulators.scenarios.file import load_scenario

pytestmark = pytest.mark.simulated_time

HOME = (0.0,) * 6
AWAY = (math.radians(60.0), 0.0, 0.0, 0.0, 0.0, 0.0)  # at 20 deg/s: three seconds
LIMITS = MotionLimits(tool_speed_mm_s=1e5)


class Bench:
    """An IRB 120 in a cell, its controller served in memory."""

    def __init__(self, task=OurProgram) -> None:
        clock = CellClock(1, wall_s=asyncio.get_running_loop().time)
        self.cell = Cell(replace(load_scenario("irb120-clean"), noise=False), 1, clock)
        self.controller = AbbController(self.cell)
        self.controller.task = task(self.controller)
        self.endpoint = web_endpoint(self.cell, self.controller)
        self.ends: list = []

    def driver(self, login=None, *, chunk_bytes=97) -> RwsRobot:
        link = MemoryLink(in_memory(self.endpoint, self.ends), chunk_bytes=chunk_bytes)
        return RwsRobot(link, MonotonicClock(), login, patience=Patience(stands_s=3.0))

    async def connected(self, chunk_bytes=97) -> RwsRobot:
        robot = self.driver(chunk_bytes=chunk_bytes)
        await robot.connect()
        await robot.set_limits(LIMITS)
        return robot

    def write(self, name, value):
        self.controller.write(name, value)

    def reported(self):
        return protocol.decode_report(self.controller.task.variables[protocol.REPORT]).progress


@contextlib.asynccontextmanager
async def moving(bench: Bench, robot: RwsRobot):
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


async def test_the_arm_rests_at_its_target_and_says_where_with_all_digits():
    bench = Bench()
    robot = await bench.connected()
    target = tuple(map(math.radians, (10.12345, -20.5, 15.0, 30.0, 40.0, -50.98765)))

    await robot.move_joints(target)
    reading = await robot.read_joints()

    assert robot.can_stop_motion
    assert robot.motion_guard == MotionGuard(stops_unheard_s=1.0, speed_read_back=True)
    assert reading.joints_rad == pytest.approx(target, abs=reading.resolution_rad)
    assert reading.resolution_rad == pytest.approx(math.radians(1e-4))
    assert not bench.cell.robot_moves
    await robot.close()


async def test_the_joints_are_read_while_the_arm_moves():
    bench = Bench()
    robot = await bench.connected()
    async with moving(bench, robot):
        first, second = [(await robot.read_joints()).joints_rad[0] for _ in range(2)]

    assert 0.2 < first <= second < AWAY[0]


async def test_an_arm_whose_service_is_gone_rests_within_a_second():
    bench = Bench()
    async with moving(bench, await bench.connected()) as motion:
        motion.cancel()

        assert await rests_within(bench, 1.0)
        assert bench.reported() is protocol.Progress.GIVEN_UP


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


async def test_an_order_that_nobody_waits_for_moves_nothing():
    bench = Bench()

    bench.write(protocol.ORDER, protocol.Order(7, (60.0, *HOME[1:]), 250.0, 20.0).encode())
    assert bench.reported() is protocol.Progress.TAKEN
    await asyncio.sleep(protocol.FIRST_BEAT_S + 0.1)
    assert bench.reported() is protocol.Progress.GIVEN_UP
    bench.write(protocol.BEAT, "9")
    await asyncio.sleep(1.0)

    assert not bench.cell.robot.target_rad.any()


async def test_an_order_from_before_the_start_moves_nothing():
    bench = Bench()
    bench.controller.stop()
    bench.write(protocol.ORDER, protocol.Order(7, (60.0, *HOME[1:]), 250.0, 20.0).encode())

    bench.controller.start("once")
    bench.write(protocol.BEAT, "1")
    await asyncio.sleep(5.0)

    assert bench.reported() is protocol.Progress.IDLE
    assert not bench.cell.robot.target_rad.any()


async def test_a_stop_between_order_and_first_beat_moves_nothing():
    bench = Bench()
    robot = await bench.connected()
    take = bench.controller.task._take

    def take_and_stop():
        take()
        bench.controller.switch(ControllerState.EMERGENCY_STOP)

    bench.controller.task._take = take_and_stop
    with pytest.raises(NotInitialisedError, match=r"stopped before it set off \(emergencystop\)"):
        await robot.move_joints(AWAY)

    assert not bench.cell.robot.target_rad.any()
    await robot.close()


async def test_a_program_that_understood_another_order_gets_no_beat():
    bench = Bench()
    robot = await bench.connected()
    task = bench.controller.task
    tell = task._tell
    task._tell = lambda progress, order: tell(progress, replace(order, tool_speed_mm_s=7_000.0))

    with pytest.raises(DeviceRefusedError, match="understood"):
        await robot.move_joints(AWAY)
    await asyncio.sleep(2.0)

    assert not robot.connected
    assert not bench.cell.robot.target_rad.any()


@pytest.mark.parametrize(
    ("spoil", "match"),
    [
        (lambda irc5: irc5.switch(ControllerState.MOTORS_OFF), "motors are off"),
        (lambda irc5: irc5.switch(ControllerState.EMERGENCY_STOP), "emergency stop"),
        (lambda irc5: irc5.switch(ControllerState.GUARD_STOP), "guard"),
        (lambda irc5: setattr(irc5, "mode", OperationMode.MANUAL_REDUCED), "key switch is at MANR"),
        (lambda irc5: setattr(irc5, "speed_percent", 0.0), "override is 0 %"),
        (lambda irc5: setattr(irc5, "task", PublicProgram(irc5)), "load TruePoseRws.mod"),
    ],
)
async def test_an_arm_that_may_not_move_is_not_moved_and_the_cause_is_said(spoil, match):
    bench = Bench()
    robot = await bench.connected()
    spoil(bench.controller)

    with pytest.raises(NotInitialisedError, match=match):
        await robot.move_joints(AWAY)

    assert robot.connected
    assert not bench.cell.robot.target_rad.any()
    await robot.close()


async def test_an_emergency_stop_on_the_way_is_told_and_nothing_moves_before_it_is_cleared():
    bench = Bench()
    robot = await bench.connected()
    async with moving(bench, robot) as motion:
        bench.controller.switch(ControllerState.EMERGENCY_STOP)
        with pytest.raises(NotInitialisedError, match=r"stopped on its way.*emergency stop"):
            await motion
        with pytest.raises(NotInitialisedError, match="cannot move"):
            await robot.move_joints(HOME)

        bench.controller.switch(ControllerState.MOTORS_ON)
        await robot.move_joints(HOME)
        assert bench.cell.robot.target_rad == pytest.approx(HOME)


async def test_a_stop_of_the_cell_is_told_and_its_release_starts_nothing():
    bench = Bench()
    robot = await bench.connected()
    now_s = bench.cell.clock.now_s
    bench.cell.add_fault(EmergencyStop(from_s=now_s + 1.0, until_s=now_s + 5.0))

    with pytest.raises(NotInitialisedError, match=r"stopped on its way.*emergency stop"):
        await robot.move_joints(AWAY)
    stopped_at = bench.cell.robot.target_rad[0]
    await asyncio.sleep(10.0)
    assert bench.cell.robot.target_rad[0] == stopped_at
    assert (await robot.read_panel()).execution == "stopped"

    await robot.move_joints(HOME)
    assert bench.cell.robot.target_rad == pytest.approx(HOME)
    await robot.close()


async def test_a_program_that_stops_on_the_way_is_told_with_the_event():
    bench = Bench()
    robot = await bench.connected()
    async with moving(bench, robot) as motion:
        bench.controller.fail(50204, "Motion supervision", "Joint 2 met something.")
        with pytest.raises(NotInitialisedError, match=r"on its way.*50204 Motion supervision: Joint 2"):
            await motion


async def test_a_target_that_the_controller_does_not_take_is_refused_with_its_event():
    bench = Bench()
    robot = await bench.connected()

    with pytest.raises(TargetRefusedError, match="joint 1 cannot go to 400"):
        await robot.move_joints((math.radians(400.0), *HOME[1:]))
    bench.cell.add_fault(RobotRefuses(move=1))
    with pytest.raises(TargetRefusedError, match="pendant"):
        await robot.move_joints(AWAY)

    await robot.move_joints(AWAY)
    assert bench.cell.robot.target_rad == pytest.approx(AWAY)
    await robot.close()


async def test_an_arm_that_stands_and_never_arrives_is_left_after_a_while():
    bench = Bench()
    robot = await bench.connected()
    bench.cell.add_fault(RobotHangs(move=1))

    with pytest.raises(NoReplyError, match="has not moved for 3 s"):
        await robot.move_joints(AWAY)
    assert not robot.connected


async def test_half_the_override_takes_twice_as_long():
    bench = Bench()
    robot = await bench.connected()
    durations_s = []
    for percent, target in ((100.0, AWAY), (50.0, HOME)):
        bench.controller.speed_percent = percent
        begun_s = bench.cell.clock.now_s
        await robot.move_joints(target)
        durations_s.append(bench.cell.clock.now_s - begun_s)

    assert durations_s[1] == pytest.approx(2.0 * durations_s[0], rel=0.05)
    await robot.close()


async def test_two_programs_do_not_share_a_motion():
    bench = Bench()
    first, second = await bench.connected(), await bench.connected()
    async with moving(bench, first) as motion:
        with pytest.raises(BusyError, match="under way"):
            await second.move_joints(HOME)

        number = protocol.decode_order(bench.controller.task.variables[protocol.ORDER]).number
        bench.controller.task._tell(protocol.Progress.TAKEN, protocol.Order(number + 1))
        with pytest.raises(DeviceRefusedError, match="somebody else"):
            await motion
    await second.close()


@pytest.mark.parametrize("login", [Login("Default User", "wrong"), Login("nobody", "robotics")])
async def test_who_is_not_let_in_is_told_so(login):
    robot = Bench().driver(login)

    with pytest.raises(DeviceRefusedError, match=r"does not let user .* in: check the options"):
        await robot.connect()
    assert not robot.connected


async def test_a_password_that_cannot_be_sent_is_none():
    with pytest.raises(DriverError, match="cannot be sent"):
        await Bench().driver(Login("me\r\nHost: other", "x")).connect()


async def test_joints_on_a_line_that_stalls_are_whole():
    bench = Bench()
    robot = await bench.connected()
    await robot.move_joints(AWAY)
    bench.cell.add_fault(LineStalls())

    assert (await robot.read_joints()).joints_rad == pytest.approx(AWAY, abs=1e-6)
    await robot.close()


async def test_a_connection_that_the_controller_ends_after_400_requests_never_breaks_off():
    bench = Bench()
    robot = await bench.connected(chunk_bytes=4096)

    for _ in range(410):
        await robot.read_joints()

    assert len(bench.ends) == 2
    await robot.close()


async def test_sessions_are_left_so_that_the_controller_does_not_run_out_of_them():
    bench = Bench()

    for _ in range(75):
        robot = await bench.connected(chunk_bytes=4096)
        await robot.close()
    robots = [bench.driver(chunk_bytes=4096) for _ in range(71)]
    for robot in robots[:70]:
        await robot.connect()
    with pytest.raises(DeviceRefusedError, match="too many clients"):
        await robots[70].connect()
    for robot in robots:
        await robot.close()


async def test_other_clients_write_a_target_and_say_go():
    bench = Bench(PublicProgram)
    zero = "[0,0,0,0,0,0]"

    bench.write("tgt", f"[[10,0,0,0,0,0],{zero}]")
    await asyncio.sleep(1.0)
    assert not bench.cell.robot_moves
    bench.write("go", number_text(1.0))
    await asyncio.sleep(2.0)

    assert np.degrees(bench.cell.robot.target_rad[0]) == pytest.approx(10.0)
    assert bench.controller.task.variables["go"] == "0"
