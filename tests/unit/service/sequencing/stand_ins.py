"""A robot's controller as every fake one is: it answers, and does not move by itself."""

from truepose_drivers.api import DeviceIdentity, MotionLimits


class Controller:
    """Connected or not, with a serial number and the limits that it was given."""

    can_stop_motion = False

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
