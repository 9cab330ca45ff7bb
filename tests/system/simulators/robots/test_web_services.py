"""The driver of Robot Web Services on a simulated IRC5, with the arm moving in its own time."""

import asyncio
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.system.simulators.robots.arms import WebBench
from truepose_drivers.abb_rws import protocol
from truepose_drivers.abb_rws.http import Login
from truepose_drivers.abb_rws.protocol import ControllerState, OperationMode, number_text
from truepose_drivers.api import MotionGuard
from truepose_drivers.errors import (
    BusyError,
    DeviceRefusedError,
    DriverError,
    NotInitialisedError,
)
from truepose_simulators.faults.kinds import EmergencyStop, LineStalls
from truepose_simulators.instruments.robot.abb_rws.controller import PublicProgram

pytestmark = pytest.mark.simulated_time

HOME = WebBench.home
AWAY = (math.radians(60.0), *HOME[1:])  # at 20 deg/s: three seconds


async def test_the_controller_reads_with_all_digits_and_watches_its_client():
    bench = WebBench()
    robot = await bench.connected()

    reading = await robot.read_joints()

    assert robot.can_stop_motion
    assert robot.motion_guard == MotionGuard(stops_unheard_s=1.0, speed_read_back=True)
    assert reading.resolution_rad == pytest.approx(WebBench.reads_to_rad)
    await robot.close()


async def test_an_order_that_nobody_waits_for_moves_nothing():
    bench = WebBench()

    bench.controller.write(protocol.ORDER, protocol.Order(7, (60.0, *HOME[1:]), 250.0, 20.0).encode())
    assert bench.reported() is protocol.Progress.TAKEN
    await asyncio.sleep(protocol.FIRST_BEAT_S + 0.1)
    assert bench.reported() is protocol.Progress.GIVEN_UP
    bench.controller.write(protocol.BEAT, "9")
    await asyncio.sleep(1.0)

    assert not bench.cell.robot.target_rad.any()


async def test_an_order_from_before_the_start_moves_nothing():
    bench = WebBench()
    bench.controller.stop()
    bench.controller.write(protocol.ORDER, protocol.Order(7, (60.0, *HOME[1:]), 250.0, 20.0).encode())

    bench.controller.start("once")
    bench.controller.write(protocol.BEAT, "1")
    await asyncio.sleep(5.0)

    assert bench.reported() is protocol.Progress.IDLE
    assert not bench.cell.robot.target_rad.any()


async def test_a_stop_between_order_and_first_beat_moves_nothing():
    bench = WebBench()
    robot = await bench.connected()
    take = bench.controller.task._take

    def take_and_stop():
        take()
        bench.controller.switch(ControllerState.EMERGENCY_STOP)

    bench.controller.task._take = take_and_stop
    with pytest.raises(NotInitialisedError, match=r"stopped before it started to move \(emergencystop\)"):
        await robot.move_joints(AWAY)

    assert not bench.cell.robot.target_rad.any()
    await robot.close()


async def test_a_program_that_understood_another_order_gets_no_beat():
    bench = WebBench()
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
    bench = WebBench()
    robot = await bench.connected()
    spoil(bench.controller)

    with pytest.raises(NotInitialisedError, match=match):
        await robot.move_joints(AWAY)

    assert robot.connected
    assert not bench.cell.robot.target_rad.any()
    await robot.close()


async def test_the_release_of_a_stop_starts_no_program():
    bench = WebBench()
    robot = await bench.connected()
    async with bench.moving(robot) as motion:
        bench.cell.add_fault(EmergencyStop(for_s=3.0))
        with pytest.raises(NotInitialisedError):
            await motion
        await asyncio.sleep(5.0)

        assert (await robot.read_panel()).execution == "stopped"


async def test_a_program_that_stops_on_the_way_is_told_with_the_event():
    bench = WebBench()
    robot = await bench.connected()
    async with bench.moving(robot) as motion:
        bench.controller.fail(50204, "Motion supervision", "Joint 2 met something.")
        with pytest.raises(
            NotInitialisedError, match=r"during the motion.*50204 Motion supervision: Joint 2"
        ):
            await motion


async def test_half_the_override_takes_twice_as_long():
    bench = WebBench()
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
    bench = WebBench()
    first, second = await bench.connected(), await bench.connected()
    async with bench.moving(first) as motion:
        with pytest.raises(BusyError, match="still moving"):
            await second.move_joints(HOME)

        number = protocol.decode_order(bench.controller.task.variables[protocol.ORDER]).number
        bench.controller.task._tell(protocol.Progress.TAKEN, protocol.Order(number + 1))
        with pytest.raises(DeviceRefusedError, match="another client"):
            await motion
    await second.close()


@pytest.mark.parametrize("login", [Login("Default User", "wrong"), Login("nobody", "robotics")])
async def test_who_is_not_let_in_is_told_so(login):
    robot = WebBench().driver(login)

    with pytest.raises(DeviceRefusedError, match=r"rejected user .*: check the options"):
        await robot.connect()
    assert not robot.connected


async def test_a_password_that_cannot_be_sent_is_none():
    with pytest.raises(DriverError, match="cannot be sent"):
        await WebBench().driver(Login("me\r\nHost: other", "x")).connect()


async def test_joints_on_a_line_that_stalls_are_whole():
    bench = WebBench()
    robot = await bench.connected()
    await robot.move_joints(AWAY)
    bench.cell.add_fault(LineStalls())

    assert (await robot.read_joints()).joints_rad == pytest.approx(AWAY, abs=1e-6)
    await robot.close()


async def test_a_connection_that_the_controller_ends_after_400_requests_never_breaks_off():
    bench = WebBench()
    robot = await bench.connected(chunk_bytes=4096)

    for _ in range(410):
        await robot.read_joints()

    assert len(bench.ends) == 2
    await robot.close()


async def test_sessions_are_left_so_that_the_controller_does_not_run_out_of_them():
    bench = WebBench()

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
    bench = WebBench(PublicProgram)
    zero = "[0,0,0,0,0,0]"

    bench.controller.write("tgt", f"[[10,0,0,0,0,0],{zero}]")
    await asyncio.sleep(1.0)
    assert not bench.cell.robot_moves
    bench.controller.write("go", number_text(1.0))
    await asyncio.sleep(2.0)

    assert np.degrees(bench.cell.robot.target_rad[0]) == pytest.approx(10.0)
    assert bench.controller.task.variables["go"] == "0"
