"""The driver of the Remote Motion Interface on the simulated controller, the arm moving in its time."""

import asyncio
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.instruments.memory_link import MemoryLink
from tests.system.simulators.robots.arms import LIMITS, FanucBench
from truepose_drivers.errors import (
    ConnectionLostError,
    NoReplyError,
    NotInitialisedError,
)
from truepose_drivers.fanuc_rmi.driver import RmiRobot
from truepose_drivers.monotonic_clock import MonotonicClock

pytestmark = pytest.mark.simulated_time

TARGET = FanucBench.target
AWAY = tuple(np.radians([60.0, 0.0, 0.0, 0.0, 0.0, 0.0]))  # three seconds


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


async def test_the_tool_turns_no_faster_than_it_was_told():
    bench = FanucBench()
    robot = await bench.connected()
    begun_s = bench.cell.clock.now_s

    await robot.move_joints(AWAY)

    # 60 deg of joint 1 at 5 % of 350 deg/s
    assert bench.cell.clock.now_s - begun_s == pytest.approx(60.0 / 17.5, abs=0.05)
    await robot.close()


@pytest.mark.parametrize("override", [100, 10])
async def test_an_arm_whose_cable_was_cut_rests_within_a_second_and_is_missed_within_two(override):
    bench = FanucBench()
    bench.controller.status = replace(bench.controller.status, override_percent=override)
    links = []

    def to_port(port):
        links.append(SilentLink(bench.to_port(port)._serve))
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


async def test_a_program_that_a_dead_session_left_is_said_with_the_way_out():
    bench = FanucBench(strands=True)
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
    bench = FanucBench(strands=True)
    robot = await bench.connected()
    await robot.move_joints(TARGET)
    await robot.close()
    await asyncio.sleep(0.1)

    again = await bench.connected()
    await again.move_joints(AWAY)

    assert bench.cell.robot.target_rad == pytest.approx(AWAY, abs=1e-7)
    await again.close()


async def test_a_controller_that_counts_on_is_counted_with():
    bench = FanucBench(keeps_sequence=True)
    for target in (TARGET, AWAY):
        robot = await bench.connected()
        await robot.move_joints(target)
        await robot.close()
        await asyncio.sleep(0.1)

    assert bench.controller.status.next_sequence > 3


async def test_a_session_that_another_ends_is_lost():
    bench = FanucBench()
    robot = await bench.connected()
    bench.ends[-1].close()

    with pytest.raises(ConnectionLostError):
        await robot.read_joints()
