"""Requests for one device wait for each other, and for a session that begins meanwhile they come too late."""

import asyncio

import pytest

from truepose.domain.cell import DeviceEntry
from truepose.sessions.devices import DeviceRegistry, MountedDevice
from truepose.sessions.errors import DeviceInUseError, UnknownDeviceError
from truepose_drivers.api import DeviceIdentity


class SlowDevice:
    """Connects once it is let."""

    def __init__(self):
        self.connected = False
        self.closed = 0
        self.begun, self.go_on = asyncio.Event(), asyncio.Event()

    async def connect(self):
        self.begun.set()
        await self.go_on.wait()
        self.connected = True

    async def identify(self):
        return DeviceIdentity("ABB", "IRB 120", "120-1", "6.08")

    async def close(self):
        self.closed += 1
        self.connected = False


@pytest.fixture
async def device():
    return SlowDevice()


@pytest.fixture
def rack(device):
    return DeviceRegistry([MountedDevice(DeviceEntry("robot", "any", {}), "robot", "any", device)], None)


@pytest.mark.parametrize("asked", ["connect", "disconnect"])
async def test_a_request_whose_turn_comes_when_a_session_has_the_devices_leaves_the_link_alone(
    rack, device, asked
):
    first = asyncio.create_task(rack.connect("robot"))
    await device.begun.wait()
    second = asyncio.create_task(getattr(rack, asked)("robot"))
    await asyncio.sleep(0)  # it waits for its turn

    rack.lend(7, None)
    device.go_on.set()

    assert (await first).connected
    with pytest.raises(DeviceInUseError, match="7"):
        await second
    assert device.closed == 0


async def test_a_device_that_nobody_knows_has_no_turn(rack):
    with pytest.raises(UnknownDeviceError):
        await rack.disconnect("press")
