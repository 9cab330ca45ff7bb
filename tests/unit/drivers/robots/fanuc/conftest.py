"""A controller with the Remote Motion Interface, and the driver that is connected to it."""

import pytest

from tests.unit.drivers.robots.fanuc.rmi_controller import FakeController, connected


@pytest.fixture
def fake():
    return FakeController()


@pytest.fixture
async def robot(fake):
    return await connected(fake)
