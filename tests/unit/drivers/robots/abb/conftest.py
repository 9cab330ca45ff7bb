"""An open_abb server, and the driver that is connected to it."""

import pytest

from tests.unit.drivers.robots.abb.open_abb_server import FakeController, connected_robot


@pytest.fixture
def fake():
    return FakeController()


@pytest.fixture
async def robot(fake):
    return await connected_robot(fake)
