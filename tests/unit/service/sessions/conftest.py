"""Sessions in simulated time: their devices, clocks and records live in memory."""

import asyncio
from pathlib import Path

import pytest

from tests.unit.service.sessions.tracker.fakes import FakeCell
from truepose_drivers.contract.case import SimulatedTimeLoop

_SERVICES = Path(__file__).parent


def pytest_asyncio_loop_factories(config, item):
    """Give every run a loop that never waits; services, tested beside this file, have threads to wait for."""
    if item.path.parent == _SERVICES:
        return {"time of the wall": asyncio.new_event_loop}
    return {"simulated time": SimulatedTimeLoop}


@pytest.fixture
def cell():
    return FakeCell()
