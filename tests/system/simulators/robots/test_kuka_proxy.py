"""The driver behind a variable proxy on the simulated controller, with the arm moving in its own time."""

import asyncio

import pytest

from tests.contract.benches import in_memory
from tests.helpers.instruments.memory_link import MemoryLink
from tests.system.simulators.robots.arms import KukaBench
from truepose_drivers.errors import (
    ConnectionLostError,
    RemoteProtocolError,
)

pytestmark = pytest.mark.simulated_time


async def test_beats_that_do_not_change_are_none():
    bench = KukaBench()
    robot = await bench.connected()
    async with bench.moving(robot) as motion:
        bench.variables._writable = {**bench.variables._writable, "TP_BEAT": lambda value: None}

        assert await bench.rests_within(1.0)
        with pytest.raises(ConnectionLostError, match="received nothing"):
            await motion


async def test_an_order_after_which_nobody_is_heard_moves_nothing():
    bench = KukaBench()
    robot = await bench.connected()
    robot._program._arrived = lambda number, since_s: asyncio.sleep(3.0, result=True)

    with pytest.raises(RemoteProtocolError, match="off its target"):
        await robot.move_joints(KukaBench.target)

    assert bench.cell.robot.target_rad == pytest.approx(KukaBench.home)
    assert bench.variables.program.state.given_up == 1


async def test_a_client_that_is_silent_for_half_a_minute_is_dropped_and_ours_is_not():
    bench = KukaBench()
    robot = await bench.connected()
    link = MemoryLink(in_memory(bench.endpoint, []))
    await link.open()

    await asyncio.sleep(120.0)

    with pytest.raises(ConnectionLostError):
        await link.receive(0.1)
    assert (await robot.read_joints()).joints_rad
    await robot.close()


async def test_several_clients_read_the_same_arm():
    bench = KukaBench()
    first, second = await bench.connected(), await bench.connected()

    await first.move_joints(KukaBench.target)

    assert (await second.read_joints()).joints_rad == pytest.approx(KukaBench.target, abs=1e-6)
    await first.close()
    await second.close()
