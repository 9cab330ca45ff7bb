"""The computer's own clock, in the time of the wall."""

from truepose_drivers.api import Clock
from truepose_drivers.monotonic_clock import MonotonicClock


async def test_the_computers_clock_advances_by_what_was_slept():
    clock: Clock = MonotonicClock()
    before_s = await clock.now_s()

    await clock.sleep(0.01)

    # the event loop may wake up to its own resolution, far below 1 ms, too early
    assert await clock.now_s() - before_s >= 0.009
