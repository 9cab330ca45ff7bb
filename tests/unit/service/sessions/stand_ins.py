"""A robot's controller, a disk and a cell as every fake one is: it answers, has room or none, is empty."""

import asyncio

from truepose_drivers.api import DeviceIdentity, MotionGuard, MotionLimits


async def nothing_in_the_way(*_: object) -> str:
    """Look at ways of a cell in which nothing stands."""
    return ""


class Controller:
    """Connected or not, with a serial number and the limits that it was given."""

    can_stop_motion = False
    motion_guard = MotionGuard()

    def __init__(self) -> None:
        self.serial = "120-1"
        self.connected = False
        self.limits: MotionLimits | None = None
        self.moves: list[tuple[float, ...]] = []

    async def connect(self) -> None:
        self.connected = True

    async def close(self) -> None:
        self.connected = False

    async def identify(self) -> DeviceIdentity:
        return DeviceIdentity("ABB", "IRB 120", self.serial, "6.08")

    async def set_limits(self, limits: MotionLimits) -> None:
        self.limits = limits


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
