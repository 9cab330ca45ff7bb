"""The devices of the cell: opened by the drivers, connected on request, lent to one session at a time."""

import asyncio
import contextlib
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass
from typing import cast

from truepose.domain.cell import DeviceEntry
from truepose.domain.session import IdentityOf
from truepose.messages.message import Text, message
from truepose.sessions.engine.identity_check import reported_serial_number, same_number
from truepose.sessions.engine.interlocks import motion_notice
from truepose.sessions.engine.ledger import Expected
from truepose.sessions.errors import DeviceInUseError, MissingDeviceError, UnknownDeviceError
from truepose_drivers.api import (
    AnyGuarded,
    Ballbar,
    Device,
    DeviceIdentity,
    DeviceKind,
    FullClock,
    FullGauge,
    FullPoseTracker,
    FullRobot,
    FullTracker,
    GuardsMotion,
    SimulatedHands,
)
from truepose_drivers.errors import DriverError


@dataclass(frozen=True, slots=True)
class MountedDevice:
    """A device that a driver has opened, not necessarily connected."""

    entry: DeviceEntry
    kind: DeviceKind
    protocol: str
    device: AnyGuarded
    expected_serial: str = ""  # as the cell file says; empty: whoever answers


@dataclass(frozen=True, slots=True)
class DeviceStatus:
    """What is known of a device without asking it."""

    mounted: MountedDevice
    connected: bool
    identity: DeviceIdentity | None  # as it last said itself
    fault: str | None  # of the last attempt to connect
    session_id: int | None  # which session holds it

    @property
    def is_foreign(self) -> bool:
        """Whether another device answered than the cell file names."""
        answered, expected = self.answered_serial, self.mounted.expected_serial
        return bool(answered and expected) and not same_number(answered, expected)

    @property
    def answered_serial(self) -> str:
        """Return the serial number that it told, empty where it told none."""
        return "" if self.identity is None else reported_serial_number(self.identity.serial)


class DeviceRegistry:
    """All devices of the cell but its clock."""

    def __init__(self, mounted: Sequence[MountedDevice], clock: FullClock) -> None:
        self.clock = clock
        self._mounted = {device.entry.name: device for device in mounted}
        self._identities: dict[str, DeviceIdentity] = {}
        self._faults: dict[str, str] = {}
        # Two requests for one device wait for each other: a link that is being opened cannot be closed.
        self._turns = {name: asyncio.Lock() for name in self._mounted}
        self._session_id: int | None = None
        self._moved: GuardsMotion | None = None  # the robot as the session under way moves it

    def statuses(self) -> list[DeviceStatus]:
        """Return every device in the order of the cell file."""
        return [self.status(name) for name in self._mounted]

    def status(self, name: str) -> DeviceStatus:
        """Return a device by name; raises UnknownDeviceError."""
        mounted = self._find(name)
        return DeviceStatus(
            mounted=mounted,
            connected=_link(mounted).connected,
            identity=self._identities.get(name),
            fault=self._faults.get(name),
            session_id=self._session_id,
        )

    async def connect(self, name: str) -> DeviceStatus:
        """Open the link and ask the device who it is.

        Raises UnknownDeviceError, DeviceInUseError, or what the driver raises.
        """
        async with self._turn(name) as device:
            try:
                if not device.connected:
                    await device.connect()
                self._identities[name] = await device.identify()
                self._faults.pop(name, None)
            except DriverError as error:
                self._faults[name] = str(error)
                raise
        return self.status(name)

    async def disconnect(self, name: str) -> DeviceStatus:
        """Close the link; raises UnknownDeviceError, DeviceInUseError."""
        async with self._turn(name) as device:
            await device.close()
        return self.status(name)

    def expected(self, instrument: DeviceKind = "tracker") -> Expected:
        """Return which devices must answer, for a session that asks them itself.

        `instrument` is what stands in the tracker's place.
        """
        kinds: dict[IdentityOf, DeviceKind] = {"tracker": instrument, "robot": "robot", "ballbar": "ballbar"}
        # Reversed, so that of two devices of a kind the first one stays: that is the one which sessions use.
        by_kind = {mounted.kind: mounted.expected_serial for mounted in reversed(self._mounted.values())}

        def hear(device: IdentityOf, identity: DeviceIdentity) -> None:
            self._identities[self.name_of(kinds[device])] = identity

        return Expected({device: by_kind.get(kind, "") for device, kind in kinds.items()}, hear)

    @property
    def used(self) -> dict[IdentityOf, str]:
        """Return the names of the devices that sessions measure with."""
        tracker = self.name_of("tracker") or self.name_of("pose_tracker")
        return {"tracker": tracker, "robot": self.name_of("robot"), "ballbar": self.name_of("ballbar")}

    def name_of(self, kind: DeviceKind) -> str:
        """Return the name of the device of this kind that sessions use; empty where there is none."""
        return next((name for name, mounted in self._mounted.items() if mounted.kind == kind), "")

    def lend(self, session_id: int, moved: GuardsMotion) -> None:
        """Give all devices to a session, which moves the robot `moved`; raises DeviceInUseError."""
        if self._session_id not in {None, session_id}:
            raise DeviceInUseError(message("session.refused.devices_held", session=self._session_id))
        self._session_id, self._moved = session_id, moved

    def take_back(self) -> None:
        """End the loan."""
        self._session_id = self._moved = None

    @property
    def tracker(self) -> FullTracker:
        """The instrument that measures points; raises MissingDeviceError."""
        return cast(FullTracker, self._of_kind("tracker"))

    @property
    def camera(self) -> FullPoseTracker:
        """The instrument that measures poses; raises MissingDeviceError."""
        return cast(FullPoseTracker, self._of_kind("pose_tracker"))

    @property
    def robot(self) -> FullRobot:
        """The robot's controller; raises MissingDeviceError."""
        return cast(FullRobot, self._of_kind("robot"))

    @property
    def motion_notice(self) -> Text | None:
        """What whoever lets the arm move has to know of its controller; None in a cell without one.

        It is said by the object that a session moves, so nothing around it can make it untrue.
        """
        moved = self._moved or cast(FullRobot | None, self._first("robot"))
        return None if moved is None else motion_notice(moved.motion_guard)

    @property
    def ballbar(self) -> Ballbar:
        """The instrument that measures lengths; raises MissingDeviceError."""
        return cast(Ballbar, self._of_kind("ballbar"))

    @property
    def gauges(self) -> tuple[tuple[MountedDevice, FullGauge], ...]:
        """The linear gauges, in the order of the cell file; none where it lists none."""
        return tuple(
            (mounted, cast(FullGauge, mounted.device))
            for mounted in self._mounted.values()
            if mounted.kind == "linear_gauge"
        )

    @property
    def hands(self) -> SimulatedHands | None:
        """The person of a simulated cell; None where a real one stands there."""
        return cast(SimulatedHands | None, self._first("hands"))

    async def close(self) -> None:
        """Close every link."""
        for mounted in self._mounted.values():
            await _link(mounted).close()

    def _of_kind(self, kind: DeviceKind) -> AnyGuarded:
        found = self._first(kind)
        if found is None:
            raise MissingDeviceError(message("session.refused.no_device", kind=kind))
        return found

    def _first(self, kind: DeviceKind) -> AnyGuarded | None:
        return next((mounted.device for mounted in self._mounted.values() if mounted.kind == kind), None)

    def _find(self, name: str) -> MountedDevice:
        try:
            return self._mounted[name]
        except KeyError:
            known = ", ".join(self._mounted) or "none"
            raise UnknownDeviceError(
                message("session.refused.unknown_device", device=name, known=known)
            ) from None

    @contextlib.asynccontextmanager
    async def _turn(self, name: str) -> AsyncIterator[Device]:
        """Have the link of a device that no session holds; raises UnknownDeviceError, DeviceInUseError."""
        mounted = self._find(name)
        async with self._turns[name]:
            # Asked once the turn has come: a session may have begun while the request before was done.
            if self._session_id is not None:
                raise DeviceInUseError(
                    message("session.refused.device_held", session=self._session_id, device=name)
                )
            yield _link(mounted)


def _link(mounted: MountedDevice) -> Device:
    # The clock, the one device without a link of its own, is never mounted here.
    return cast(Device, mounted.device)
