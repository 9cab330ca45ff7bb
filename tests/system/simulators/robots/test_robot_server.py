"""The robot's servers on sockets: one client each, a pause between two, silence after a refusal."""

import asyncio
import contextlib
from dataclasses import replace

import pytest

from tests.helpers.instruments.sockets import connections_to
from truepose_drivers.abb_open_abb.protocol import LogReader
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.robot.open_abb import MotionProgram, logger_endpoint, robot_endpoint
from truepose_simulators.scenarios.file import load_scenario
from truepose_simulators.scenarios.scenario import ArmSetup

PATIENCE_S = 60.0  # with an answer, on a busy machine
# Replies cross the loopback in well under a millisecond: what has not come by then does not come.
SILENCE_S = 0.1


@contextlib.asynccontextmanager
async def robot(*, pace=0, refusal="hang", logger=False):
    """Serve a robot and hand out a way to connect."""
    scenario = replace(load_scenario("irb120-tilted"), arm=ArmSetup(refusal=refusal))
    cell = Cell(scenario, 1, CellClock(pace, wall_s=asyncio.get_running_loop().time))
    endpoint = (logger_endpoint if logger else robot_endpoint)(cell, MotionProgram(cell))
    async with connections_to(endpoint) as connect:
        yield connect


async def ask(connection, request):
    reader, writer = connection
    writer.write(request)
    return await asyncio.wait_for(reader.read(200), PATIENCE_S)


async def stays_silent(connection):
    with pytest.raises(TimeoutError):
        await asyncio.wait_for(connection[0].read(200), SILENCE_S)


async def leave(connection):
    connection[1].close()
    await connection[1].wait_closed()
    await asyncio.sleep(0.05)  # until the server has read the end of the stream


async def test_one_reply_comes_for_one_request():
    async with robot() as connect:
        connection = await connect()

        assert await ask(connection, b"4 #") == b"4 1 0 0 0 0 0 0"
        assert await ask(connection, b"2 1 0 0 0 0 0 #") == b"2 1 "


async def test_a_command_glued_behind_another_is_lost():
    async with robot() as connect:
        connection = await connect()

        assert await ask(connection, b"0 #4 #") == b"0 1 "
        await stays_silent(connection)


async def test_a_refused_target_is_silence_until_the_client_leaves_and_somebody_restarts():
    async with robot(refusal="hang") as connect:
        connection = await connect()
        connection[1].write(b"2 170 0 0 0 0 0 #")
        await stays_silent(connection)
        connection[1].write(b"4 #")
        await stays_silent(connection)

        await leave(connection)

        assert await ask(await connect(), b"4 #") == b"4 1 0 0 0 0 0 0"


async def test_a_refused_target_may_drop_the_connection_instead():
    async with robot(refusal="drop") as connect:
        assert await ask(await connect(), b"2 170 0 0 0 0 0 #") == b""
        await asyncio.sleep(0.05)

        assert await ask(await connect(), b"4 #") == b"4 1 0 0 0 0 0 0"


async def test_a_second_client_hears_nothing_and_is_dropped_when_the_first_leaves():
    async with robot() as connect:
        first, second = await connect(), await connect()
        assert await ask(first, b"0 #") == b"0 1 "
        second[1].write(b"0 #")
        await stays_silent(second)

        await leave(first)

        # Its request lies unread when the server socket goes: an end or a reset, both close the link.
        with contextlib.suppress(ConnectionResetError):
            assert await asyncio.wait_for(second[0].read(200), PATIENCE_S) == b""


async def test_closing_is_not_answered_and_the_server_listens_again():
    async with robot() as connect:
        assert await ask(await connect(), b"99 #") == b""
        await asyncio.sleep(0.05)

        assert await ask(await connect(), b"0 #") == b"0 1 "


@pytest.mark.simulated_time
@pytest.mark.usefixtures("memory_network")
async def test_in_real_time_the_controller_pauses_half_a_second_before_it_accepts_again():
    async with robot(pace=1) as connect:
        first = await connect()
        await ask(first, b"0 #")
        await leave(first)

        with pytest.raises(ConnectionRefusedError):
            await connect()
        await asyncio.sleep(0.6)

        assert await ask(await connect(), b"0 #") == b"0 1 "


async def test_the_logger_sends_poses_and_joints_in_turn():
    async with robot(logger=True) as connect:
        reader, _ = await connect()
        lines, log = [], LogReader()
        while len(lines) < 3:
            log.receive_data(await asyncio.wait_for(reader.read(200), PATIENCE_S))
            while (line := log.next_line()) is not None:
                lines.append(line)

    assert [line.kind for line in lines] == [0, 1, 0]
    assert lines[0].values == pytest.approx((374.0, 0.0, 630.0, 0.707, 0.0, 0.707, 0.0))
    assert lines[1].values == (0.0,) * 6
