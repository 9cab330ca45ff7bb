"""Sessions in simulated time: their devices, clocks and records live in memory."""

from truepose_drivers.contract.simulated_time import SimulatedTimeLoop


def pytest_asyncio_loop_factories(config, item):
    """Give every test a loop that never waits."""
    return {"simulated time": SimulatedTimeLoop}
