"""A robot's controller, a disk and a cell as every fake one is: it answers, has room or none, is empty."""

import asyncio

from truepose_drivers.api import DeviceIdentity, MotionGuard, MotionLimits
from truepose_drivers.errors import ConnectionLostError


async def nothing_in_the_way(*_: object) -> str:
    """Look at ways of a cell in which nothing stands."""
    return ""


class Device:
    """Connected or not, and says who it is."""

    def __init__(self, manufacturer: str, model: str, serial: str, firmware: str) -> None:
        self._is = manufacturer, model
        self._firmware = firmware
        self.serial = serial
        self.connected = False

    async def connect(self) -> None:
        self.connected = True

    async def close(self) -> None:
        self.connected = False

    async def identify(self) -> DeviceIdentity:
        return DeviceIdentity(*self._is, self.serial, self._firmware)


class Controller(Device):
    """A robot's, with the limits that it was given."""

    can_stop_motion = False
    motion_guard = MotionGuard()

    def __init__(self) -> None:
        super().__init__("ABB", "IRB 120", "120-1", "6.08")
        self.limits: MotionLimits | None = None
        self.moves: list[tuple[float, ...]] = []

    async def set_limits(self, limits: MotionLimits) -> None:
        self.limits = limits


def refuse(device, name, error, when, *, once=False):
    """Have a device raise an error where it is asked by `name` and `when` holds; a lost link is down then."""
    asked, refused = getattr(device, name), []

    async def answer(*given, **how):
        if when(*given) and not (once and refused):
            refused.append(error)
            device.connected = not isinstance(error, ConnectionLostError)
            raise error
        return await asked(*given, **how)

    setattr(device, name, answer)


class FiniteDisk:
    """Full once a test says so, until it makes room."""

    def __init__(self) -> None:
        self.full = False
        self.has_room = asyncio.Event()

    def fill(self) -> None:
        self.full = True
        self.has_room.clear()

    def make_room(self) -> None:
        self.full = False
        self.has_room.set()

    async def writable(self) -> None:
        await self.has_room.wait()
