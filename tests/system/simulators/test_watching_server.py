"""Our own program on a simulated controller watches whoever asks for it, and serves all others as before."""

import asyncio
import contextlib
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.instruments.sockets import connections_to
from truepose_drivers.abb_open_abb.driver import OpenAbbRobot, TimeOuts
from truepose_drivers.api import MotionLimits
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_drivers.transports.tcp import TcpLink
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.robot.open_abb import MotionProgram, robot_endpoint
from truepose_simulators.scenarios.file import load_scenario
from truepose_simulators.scenarios.scenario import ArmSetup

TURN = b"2 90 0 0 0 0 0 #"  # at 50 deg/s: nearly two seconds
PATIENCE_S = 60.0  # with an answer, on a busy machine


def in_simulated_time(test):
    """Serve in memory: no machine is too busy then for what must happen within a second."""
    return pytest.mark.simulated_time(pytest.mark.usefixtures("memory_network")(test))


@contextlib.asynccontextmanager
async def controller(server="truepose"):
    """Serve a robot in real time; yields the cell and a way to connect."""
    scenario = replace(load_scenario("irb120-clean"), arm=ArmSetup(server=server))
    cell = Cell(scenario, 1, CellClock(1, wall_s=asyncio.get_running_loop().time))
    endpoint = robot_endpoint(cell, MotionProgram(cell))
    async with connections_to(endpoint) as connect:
        yield cell, connect


async def asked(connection, *requests):
    reader, writer = connection
    for request in requests:
        writer.write(request)
        reply = await asyncio.wait_for(reader.read(200), PATIENCE_S)
    return reply


def stands_at_deg(cell):
    return float(np.degrees(cell.robot.motion.joints_at(cell.clock.now_s)[0]))


@in_simulated_time
async def test_a_watched_client_that_falls_silent_has_the_arm_stop_within_a_second():
    async with controller() as (cell, connect):
        connection = await connect()
        await asked(connection, b"8 10000 20 #", b"95 0.8 #")

        begun_s = cell.clock.now_s
        assert await asked(connection, TURN) == b""  # the connection ends, nothing is replied

        assert cell.clock.now_s - begun_s <= 1.0
        assert 5.0 < stands_at_deg(cell) < 20.0
        assert not cell.robot_moves


@in_simulated_time
async def test_a_watched_client_that_is_gone_is_noticed_at_once():
    async with controller() as (cell, connect):
        connection = await connect()
        await asked(connection, b"8 10000 20 #", b"95 0.8 #")
        connection[1].write(TURN)
        while not cell.robot_moves:
            await asyncio.sleep(0.01)

        connection[1].close()
        gone_s = cell.clock.now_s
        while cell.robot_moves:
            await asyncio.sleep(0.01)

        assert cell.clock.now_s - gone_s < 0.5


@in_simulated_time
async def test_a_client_that_does_not_ask_is_not_watched():
    async with controller() as (cell, connect):
        connection = await connect()
        await asked(connection, b"8 10000 80 #")

        assert await asked(connection, TURN) == b"2 1 "
        assert stands_at_deg(cell) == 90.0


@in_simulated_time
async def test_the_watch_ends_with_its_client():
    async with controller() as (_, connect):
        first = await connect()
        await asked(first, b"95 0.1 #")
        first[1].write(b"99 #")
        assert await asyncio.wait_for(first[0].read(10), PATIENCE_S) == b""
        await asyncio.sleep(0.6)  # the program looks for a client every half second

        assert await asked(await connect(), b"8 10000 80 #", TURN) == b"2 1 "


@in_simulated_time
async def test_beats_before_a_request_are_dropped():
    async with controller() as (_, connect):
        assert await asked(await connect(), b"96 #96 #0 #") == b"0 1 "


@in_simulated_time
async def test_the_stock_program_knows_nothing_of_all_this():
    async with controller("stock") as (_, connect):
        connection = await connect()

        assert await asked(connection, b"95 0.8 #") == b"95 0 "
        assert await asked(connection, b"94 #") == b"94 0 "
        assert (await asked(connection, b"98 #")).count(b"*") == 2


async def test_the_driver_keeps_the_arm_moving_and_reads_the_speed_back():
    async with controller() as (cell, connect):
        (_, probe) = await connect()
        port = probe.get_extra_info("peername")[1]
        probe.close()
        robot = OpenAbbRobot(TcpLink("127.0.0.1", port), MonotonicClock(), time_outs=TimeOuts(connect_s=10.0))
        await robot.connect()
        await robot.identify()
        await robot.set_limits(MotionLimits(1e4, np.radians(20.0)))

        await robot.move_joints((np.radians(30.0), 0.0, 0.0, 0.0, 0.0, 0.0))
        reading = await robot.read_joints()
        await robot.close()

        assert np.degrees(reading.joints_rad[0]) == pytest.approx(30.0)
        assert stands_at_deg(cell) == pytest.approx(30.0)
        assert robot.motion_guard.speed_read_back
