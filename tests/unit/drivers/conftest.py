"""The event loop of drivers' tests: with simulated time where the device lives in memory."""

import asyncio

from tests.helpers.simulated_time import SimulatedTimeLoop


def pytest_asyncio_loop_factories(config, item):
    """Give a test that is marked `simulated_time` a loop that never waits."""
    if item.get_closest_marker("simulated_time"):
        return {"simulated time": SimulatedTimeLoop}
    return {"time of the wall": asyncio.new_event_loop}
