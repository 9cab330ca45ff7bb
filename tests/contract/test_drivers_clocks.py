"""What a clock promises."""

import asyncio

import pytest

from tests.contract.benches import WITHOUT_A_DEVICE, registry
from tests.helpers.machine import HANGS_S
from truepose_drivers.api import Clock

CLOCKS = registry().names("clock")


def clock_of(bench, name) -> Clock:
    return registry().open(name, {}) if name in WITHOUT_A_DEVICE else bench.driver(name)


@pytest.mark.parametrize("name", CLOCKS)
async def test_time_goes_on_by_what_was_slept(bench, name):
    clock = clock_of(bench, name)
    before_s = await clock.now_s()

    await clock.sleep(0.02)

    # an event loop may wake up early by its own resolution, far below 1 ms
    assert await clock.now_s() >= before_s + 0.019


@pytest.mark.parametrize("name", CLOCKS)
async def test_several_tasks_may_ask_at_once(bench, name):
    clock = clock_of(bench, name)

    times_s = await asyncio.gather(*(clock.now_s() for _ in range(20)))

    assert max(times_s) - min(times_s) < 5.0


async def test_a_simulated_hour_costs_no_wall_time(bench):
    clock = bench.driver("cell_clock")

    async with asyncio.timeout(HANGS_S):
        await clock.sleep(3600.0)

    assert await clock.now_s() >= 3600.0
