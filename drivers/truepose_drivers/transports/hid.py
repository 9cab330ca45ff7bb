"""USB HID devices by their reports: through the system's HID driver (hidapi), or through USB itself.

A report leads with its number. hidapi blocks.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

try:
    import hidraw as hidapi  # Linux: the kernel keeps its driver, and a rule for one device node is enough
except ImportError:
    import hid as hidapi

from truepose_drivers.errors import ConnectFailedError, DeviceRefusedError
from truepose_drivers.transports.link import BlockingPort, OverPort, Port
from truepose_drivers.transports.usb import LocalUsb, UsbPort
from truepose_drivers.usb import protocol

# hidapi blocks in C and cannot be interrupted: a port that is closed meanwhile is let go after this long.
_SLICE_S = 0.05
_INTERFACE = 0
# A device at rest keeps the packet that nobody fetched, and the one behind it where it has two buffers.
_STALE_PACKETS = 2

Value = TypeVar("Value")


class ReportPort(Port, Protocol):
    """What a driver needs of a HID device."""

    async def texts(self) -> tuple[str, str, str]:
        """Return manufacturer, product and serial number; empty where the device tells none."""
        ...

    async def fresh_report(self, timeout_s: float) -> bytes | None:
        """Return an input report that was made after this call; None after `timeout_s` of silence."""
        ...

    async def feature(self, number: int, length: int) -> bytes:
        """Read a feature report; raises DeviceRefusedError."""
        ...

    async def set_feature(self, report: bytes) -> None:
        """Write a feature report; raises DeviceRefusedError."""
        ...


@dataclass(frozen=True, slots=True)
class _OpenDevice:
    """What hidapi has opened, which has no types."""

    device: Any
    texts: tuple[str, str, str]  # manufacturer, product, serial number


class HidapiPort(BlockingPort[_OpenDevice]):
    """A HID device of this computer."""

    def __init__(self, where: LocalUsb, report_bytes: int, system: Any = hidapi) -> None:
        """Prepare for input reports of `report_bytes`, their number included; `system` is hidapi."""
        super().__init__(str(where), slice_s=_SLICE_S)
        self._where = where
        self._report_bytes = report_bytes
        self._system = system

    async def texts(self) -> tuple[str, str, str]:
        """Return manufacturer, product and serial number; empty where the device tells none."""
        return self._opened().texts

    async def fresh_report(self, timeout_s: float) -> bytes | None:
        """Return an input report that was made after this call; None after `timeout_s` of silence.

        The system keeps dozens of reports and drops the newest when nobody fetches them, so all are dropped.
        """
        device = self._opened().device
        # A length from before the call may be one from before the arm stood still.
        await self._guarded(lambda: _drain(device, self._report_bytes))
        return await self._in_slices(timeout_s, self._report)

    async def feature(self, number: int, length: int) -> bytes:
        """Read a feature report; raises DeviceRefusedError."""
        device = self._opened().device
        return await self._refusable(lambda: bytes(device.get_feature_report(number, length)))

    async def set_feature(self, report: bytes) -> None:
        """Write a feature report; raises DeviceRefusedError."""
        device = self._opened().device
        # hidapi says -1 of a refused report instead of raising (usb-hid-simulation.md, "hidapi use").
        if await self._refusable(lambda: device.send_feature_report(list(report))) < 0:
            raise DeviceRefusedError(f"HID device {self.address} refuses feature report {report[0]}")

    async def _report(self, slice_s: float) -> bytes:
        device, timeout_ms = self._opened().device, max(1, round(1000.0 * slice_s))
        return await self._guarded(lambda: bytes(device.read(self._report_bytes, timeout_ms)))

    def _open_handle(self) -> _OpenDevice:
        return _open_device(self._system, self._where)

    def _close_handle(self, handle: _OpenDevice) -> None:
        handle.device.close()

    async def _refusable(self, call: Callable[[], Value]) -> Value:
        """Make a call that a device may refuse, which looks as if it had gone: the next reading will tell."""
        try:
            return await self._in_thread(call)
        except (OSError, ValueError) as error:
            raise DeviceRefusedError(
                f"HID device {self.address} refuses a feature report ({error}): plug it in again"
            ) from error

    async def _guarded(self, call: Callable[[], Value]) -> Value:
        try:
            return await self._in_thread(call)
        except (OSError, ValueError) as error:
            raise await self._lost(
                f"HID device {self.address} was disconnected ({error}): check its cable"
            ) from error


class HidOverUsb(OverPort):
    """A HID device reached as a USB device, without the system's HID driver."""

    _port: UsbPort

    def __init__(self, port: UsbPort) -> None:
        super().__init__(port)

    async def open(self) -> None:
        """Open the device, dropping what was open before; raises ConnectFailedError."""
        await self._port.open()

    async def texts(self) -> tuple[str, str, str]:
        """Return manufacturer, product and serial number; empty where the device tells none."""
        return await self._port.texts()

    async def fresh_report(self, timeout_s: float) -> bytes | None:
        """Return an input report that was made after this call; None after `timeout_s` of silence."""
        # Dropped by number, not until it is quiet: a bar that streams is never quiet.
        for _ in range(_STALE_PACKETS):
            if await self._port.receive(timeout_s) is None:
                return None
        return await self._port.receive(timeout_s)

    async def feature(self, number: int, length: int) -> bytes:
        """Read a feature report; raises DeviceRefusedError."""
        value = protocol.ReportType.FEATURE << 8 | number
        return await self._port.control_in(
            protocol.CLASS_FROM_INTERFACE, protocol.HidRequest.GET_REPORT, value, _INTERFACE, length
        )

    async def set_feature(self, report: bytes) -> None:
        """Write a feature report; raises DeviceRefusedError."""
        value = protocol.ReportType.FEATURE << 8 | report[0]
        await self._port.control_out(
            protocol.CLASS_TO_INTERFACE, protocol.HidRequest.SET_REPORT, value, _INTERFACE, report
        )


def _open_device(system: Any, where: LocalUsb) -> _OpenDevice:
    """Open the first device that fits, by its path, which is the same whatever hidapi makes of numbers."""
    found = [
        entry
        # All are listed, not enumerate(vendor, product): by path one device is opened of two with the same
        # numbers.
        for entry in system.enumerate()
        if (entry["vendor_id"], entry["product_id"]) == (where.vendor, where.product)
        and where.serial in (None, entry["serial_number"])
    ]
    if not found:
        raise ConnectFailedError(f"no HID device {where}: check its cable, and its numbers with lsusb")
    device = system.device()
    try:
        device.open_path(found[0]["path"])
        device.set_nonblocking(1)
    except (OSError, ValueError) as error:
        raise ConnectFailedError(
            f"HID device {where} cannot be opened ({error}): give this user access to it (on Linux by a udev"
            " rule for hidraw), and check that no other program is using it"
        ) from error
    names = ("manufacturer_string", "product_string", "serial_number")
    manufacturer, product, serial = (found[0][name] or "" for name in names)
    return _OpenDevice(device, (manufacturer, product, serial))


def _drain(device: Any, report_bytes: int) -> None:
    while device.read(report_bytes):
        pass
