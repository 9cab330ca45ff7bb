"""What simulators on sockets share."""

import asyncio

import pytest

from tests.helpers.instruments.memory_network import MemoryNetwork


@pytest.fixture
def memory_network(monkeypatch):
    """Serve instruments in memory, for tests in simulated time."""
    network = MemoryNetwork()
    monkeypatch.setattr(asyncio, "start_server", network.start_server)
    monkeypatch.setattr(asyncio, "open_connection", network.open_connection)
