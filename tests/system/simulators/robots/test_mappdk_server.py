"""The driver on a simulated LR Mate: both ports, and our own program that watches whoever asks for it."""

import asyncio
import contextlib
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.instruments.memory_link import MemoryLink
from tests.helpers.instruments.sockets import connections_to
from truepose_drivers.api import MotionLimits
from truepose_drivers.errors import ConnectionLostError, NoReplyError, TargetRefusedError
from truepose_drivers.fanuc_mappdk.driver import MappdkRobot
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.kinds import ProtectiveStop, RobotRefuses
from truepose_simulators.instruments.robot.mappdk import (
    MappdkProgram,
    mappdk_endpoint,
    mappdk_logger_endpoint,
)
from truepose_simulators.scenarios.file import load_scenario

pytestmark = [pytest.mark.simulated_time, pytest.mark.usefixtures("memory_network")]

PATIENCE_S = 60.0
AT_20_DEG_S = MotionLimits(1e4, np.radians(20.0))
TURN = b"movet:00045:6:+000090.000000" + b":+000000.000000" * 5 + b"\n"
TARGET = tuple(np.radians([30.0, 20.0, -50.0, 10.0, 20.0, 30.0]).tolist())


def real_time_cell(refusal):
    scenario = load_scenario("lrmate-fanuc")
    arm = replace(scenario.arm, refusal=refusal)
    return Cell(replace(scenario, arm=arm), 1, CellClock(1, wall_s=asyncio.get_running_loop().time))


@contextlib.asynccontextmanager
async def controller(refusal="drop"):
    """Serve a robot in real time; yields the cell and ways to connect to either port."""
    cell = real_time_cell(refusal)
    motion, logger = MappdkProgram(cell), MappdkProgram(cell)
    async with (
        connections_to(mappdk_endpoint(cell, motion)) as to_motion,
        connections_to(mappdk_logger_endpoint(cell, logger)) as to_logger,
    ):
        yield cell, to_motion, to_logger


async def greeted(connect):
    connection = await connect()
    assert await heard(connection) == b"0:success"
    return connection


async def heard(connection):
    return await asyncio.wait_for(connection[0].read(300), PATIENCE_S)


async def asked(connection, request):
    connection[1].write(request)
    return await heard(connection)


def link_to(connect):
    """A driver's link over a connection."""

    async def serve(end):
        reader, writer = await connect()

        async def forward():
            while data := await end.receive():
                writer.write(data)
            writer.close()

        forwarding = asyncio.create_task(forward())
        try:
            while data := await reader.read(300):
                await end.send(data)
        finally:
            forwarding.cancel()
            writer.close()

    return MemoryLink(serve)


def stands_at_deg(cell):
    return float(np.degrees(cell.robot.motion.joints_at(cell.clock.now_s)[0]))


def ended_s(cell):
    """When the last motion ended, but for what floats lose."""
    return cell.robot.motion.start_s + cell.robot.motion.duration_s - 1e-9


async def test_the_driver_moves_and_reads_meanwhile_at_the_logger():
    async with controller() as (cell, to_motion, to_logger):
        robot = MappdkRobot(link_to(to_motion), MonotonicClock(), logger=link_to(to_logger))
        await robot.connect()
        await robot.set_limits(AT_20_DEG_S)
        moving = asyncio.create_task(robot.move_joints(TARGET))
        await asyncio.sleep(2.0)

        under_way = await robot.read_joints()
        await moving
        at_rest = await robot.read_joints()

        assert 0.05 < under_way.joints_rad[0] < 0.5
        assert at_rest.joints_rad == pytest.approx(TARGET, abs=1e-6)
        assert cell.robot.target_rad == pytest.approx(TARGET, abs=1e-6)
        assert cell.clock.now_s >= ended_s(cell)
        await robot.close()


async def test_the_tool_turns_no_faster_than_it_was_told():
    async with controller() as (cell, to_motion, _):
        robot = MappdkRobot(link_to(to_motion), MonotonicClock())
        await robot.connect()
        await robot.set_limits(AT_20_DEG_S)

        await robot.move_joints(TARGET)

        # joint 1 across the forearm, 30 deg each; joint 4, 10; joint 5 across 6, 20 and 30: 88.5 deg
        assert cell.robot.motion.duration_s == pytest.approx(4.5)
        assert cell.clock.now_s >= ended_s(cell)
        await robot.close()


async def test_a_fault_ends_the_connection_and_the_next_one_moves():
    async with controller() as (cell, to_motion, _):
        cell.add_fault(RobotRefuses(move=1))
        robot = MappdkRobot(link_to(to_motion), MonotonicClock())
        await robot.connect()
        with pytest.raises(ConnectionLostError, match="fault"):
            await robot.move_joints(TARGET)
        with pytest.raises(ConnectionLostError, match="connect first"):
            await robot.read_joints()

        await asyncio.sleep(1.0)
        await robot.connect()
        await robot.move_joints(TARGET)

        assert cell.robot.target_rad == pytest.approx(TARGET, abs=1e-6)
        await robot.close()


async def test_a_stop_that_leaves_the_controller_silent_is_told_within_seconds():
    async with controller(refusal="hang") as (cell, to_motion, to_logger):
        cell.add_fault(ProtectiveStop(move=1, after_s=1.0, for_s=60.0))
        robot = MappdkRobot(link_to(to_motion), MonotonicClock(), logger=link_to(to_logger))
        await robot.connect()
        await robot.set_limits(AT_20_DEG_S)
        begun_s = cell.clock.now_s

        with pytest.raises(NoReplyError, match=r"stopped \d+\.\d\d deg before its target"):
            await robot.move_joints(TARGET)

        assert 3.5 < cell.clock.now_s - begun_s < 5.5
        assert not robot.connected
        await robot.close()


async def test_a_target_out_of_range_moves_nothing():
    async with controller() as (cell, to_motion, _):
        robot = MappdkRobot(link_to(to_motion), MonotonicClock())
        await robot.connect()

        with pytest.raises(TargetRefusedError, match="not-reachable"):
            await robot.move_joints((3.2, 0.0, 0.0, 0.0, 0.0, 0.0))

        assert robot.connected
        assert not cell.robot.target_rad.any()
        await robot.close()


async def test_a_watched_client_that_falls_silent_has_the_arm_stop_within_a_second():
    async with controller() as (cell, to_motion, _):
        connection = await greeted(to_motion)
        await asked(connection, b"watch:0800\n")
        begun_s = cell.clock.now_s

        assert await asked(connection, TURN) == b""  # the connection ends, nothing is replied

        assert cell.clock.now_s - begun_s <= 1.0
        assert 5.0 < stands_at_deg(cell) < 20.0
        assert not cell.robot_moves


async def test_a_watched_client_that_is_gone_is_noticed_at_once():
    async with controller() as (cell, to_motion, _):
        connection = await greeted(to_motion)
        await asked(connection, b"watch:0800\n")
        connection[1].write(TURN)
        while not cell.robot_moves:
            await asyncio.sleep(0.01)

        connection[1].close()
        gone_s = cell.clock.now_s
        while cell.robot_moves:
            await asyncio.sleep(0.01)

        assert cell.clock.now_s - gone_s < 0.5


async def test_a_client_that_does_not_ask_is_not_watched():
    async with controller() as (cell, to_motion, _):
        assert await asked(await greeted(to_motion), TURN) == b"0:success"
        assert stands_at_deg(cell) == 90.0


async def test_questions_at_the_logger_are_no_sign_of_life():
    async with controller() as (cell, to_motion, to_logger):
        motion, logger = await greeted(to_motion), await greeted(to_logger)
        await asked(motion, b"watch:0800\n")
        motion[1].write(TURN)
        begun_s = cell.clock.now_s
        while cell.clock.now_s - begun_s < 1.0:
            assert (await asked(logger, b"curjpos\n")).startswith(b"0:j=")
            await asyncio.sleep(0.1)

        assert not cell.robot_moves
        assert stands_at_deg(cell) < 20.0


async def test_lines_that_come_together_are_answered_one_by_one():
    async with controller() as (_, to_motion, _logger):
        connection = await greeted(to_motion)
        connection[1].write(b"beat\nbeat\nidentity\ncur")

        assert (await heard(connection)).startswith(b"0:truepose 1,")
        assert (await asked(connection, b"jpos\r\n")).endswith(b"j=none")


async def test_a_second_client_is_not_greeted_before_the_first_has_left():
    async with controller() as (_, to_motion, _logger):
        await greeted(to_motion)
        second = await to_motion()

        with pytest.raises(TimeoutError):
            await heard(second)


async def test_whoever_says_that_it_goes_is_answered_and_waited_for():
    async with controller() as (_, to_motion, _logger):
        connection = await greeted(to_motion)

        assert await asked(connection, b"exit\n") == b"0:success"
        connection[1].write(b"curjpos\n")
        with pytest.raises(TimeoutError):
            await heard(connection)
