"""A USB device, opened by pyusb: on this computer through libusb, or behind a USB/IP server.

pyusb blocks; interrupt transfers wait in slices.
"""

import errno
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

import usb.control
import usb.core
import usb.util

from truepose_drivers.errors import ConnectFailedError, DeviceRefusedError, NoReplyError
from truepose_drivers.transports.blocking import BlockingPort
from truepose_drivers.transports.link import Source
from truepose_drivers.transports.usb_address import LocalUsb, UsbAddress
from truepose_drivers.transports.usbip_backend import UsbipBackend

_INTERFACE = 0  # measuring devices have one
_CONTROL_TIMEOUT_MS = 1000
_SLICE_S = 0.1

Value = TypeVar("Value")


class UsbPort(Source, Protocol):
    """What a driver needs of a USB device: control transfers and one interrupt endpoint."""

    async def texts(self) -> tuple[str, str, str]:
        """Return manufacturer, product and serial number; empty where the device tells none."""
        ...

    async def control_out(
        self, request_type: int, request: int, value: int = 0, index: int = 0, data: bytes = b""
    ) -> None:
        """Send a control transfer; raises DeviceRefusedError, NoReplyError, ConnectionLostError."""
        ...

    async def control_in(self, request_type: int, request: int, value: int, index: int, length: int) -> bytes:
        """Ask by a control transfer; raises DeviceRefusedError, NoReplyError, ConnectionLostError."""
        ...


@dataclass(frozen=True, slots=True)
class _Opened:
    """What pyusb has opened, which has no types."""

    device: Any
    endpoint: Any  # of the interrupt transfers


class UsbDevice(BlockingPort[_Opened]):
    """A USB device with one interface and its interrupt endpoint."""

    def __init__(self, where: UsbAddress) -> None:
        super().__init__(str(where), slice_s=_SLICE_S)
        self._where = where

    async def texts(self) -> tuple[str, str, str]:
        """Return manufacturer, product and serial number; empty where the device tells none."""
        device = self._opened().device
        return await self._guarded(lambda: _texts(device))

    async def control_out(
        self, request_type: int, request: int, value: int = 0, index: int = 0, data: bytes = b""
    ) -> None:
        """Send a control transfer; raises DeviceRefusedError, NoReplyError, ConnectionLostError."""
        device = self._opened().device
        await self._guarded(
            lambda: device.ctrl_transfer(request_type, request, value, index, data, _CONTROL_TIMEOUT_MS)
        )

    async def control_in(self, request_type: int, request: int, value: int, index: int, length: int) -> bytes:
        """Ask by a control transfer; raises DeviceRefusedError, NoReplyError, ConnectionLostError."""
        device = self._opened().device
        return await self._guarded(
            lambda: bytes(
                device.ctrl_transfer(request_type, request, value, index, length, _CONTROL_TIMEOUT_MS)
            )
        )

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return the next packet, None after `timeout_s` of silence; raises ConnectionLostError."""
        return await self._in_slices(timeout_s, self._packet)

    async def _packet(self, slice_s: float) -> bytes | None:
        endpoint = self._opened().endpoint
        return await self._guarded(lambda: _read_packet(endpoint, max(1, round(1000.0 * slice_s))))

    def _open_handle(self) -> _Opened:
        return _open_device(self._where)

    def _close_handle(self, handle: _Opened) -> None:
        usb.util.dispose_resources(handle.device)

    async def _guarded(self, call: Callable[[], Value]) -> Value:
        """Make a call in the device's thread and turn what it raises into errors of drivers."""
        try:
            return await self._in_thread(call)
        except usb.core.USBTimeoutError as error:
            raise NoReplyError(
                f"USB device {self.address} does not answer: unplug it and plug it in"
            ) from error
        except usb.core.USBError as error:
            if error.errno == errno.EPIPE:
                raise DeviceRefusedError(f"USB device {self.address} refuses a request") from error
            raise await self._lost(f"USB device {self.address} is gone ({error}): check its cable") from error


def _open_device(where: UsbAddress) -> _Opened:
    try:
        device = _find(where)
        if device is None:
            raise ConnectFailedError(
                f"there is no USB device {where}: check its cable, and the numbers with lsusb"
            )
        return _Opened(device, _prepare(device))
    except usb.core.NoBackendError as error:
        raise ConnectFailedError(
            f"USB device {where} needs the system's libusb-1.0: install it (Debian: libusb-1.0-0)"
        ) from error
    except usb.core.USBError as error:
        raise ConnectFailedError(
            f"USB device {where} cannot be opened ({error}): {_remedy(error)}"
        ) from error


def _remedy(error: usb.core.USBError) -> str:
    if error.errno == errno.EACCES:
        return "give this user the right to it (on Linux a udev rule for the device), and check its cable"
    if error.errno == errno.EBUSY:
        return "check that no other program has it"
    return "check cable and address"


def _find(where: UsbAddress) -> Any:
    if isinstance(where, LocalUsb):
        wanted = {"idVendor": where.vendor, "idProduct": where.product}
        if where.serial is None:
            return usb.core.find(**wanted)
        return usb.core.find(custom_match=lambda device: _serial(device) == where.serial, **wanted)
    return usb.core.find(backend=UsbipBackend(where.host, where.port, where.busid))


def _serial(device: Any) -> str | None:
    """Return a device's serial number; None where this user may not ask."""
    try:
        serial: str | None = device.serial_number
    except (usb.core.USBError, ValueError):  # ValueError: no language, which pyusb says of a refusal too
        return None
    return serial


def _prepare(device: Any) -> Any:
    """Take a device from the system, set it up, and return its interrupt endpoint."""
    if device.is_kernel_driver_active(_INTERFACE):
        device.detach_kernel_driver(_INTERFACE)
    device.reset()
    device.set_configuration()
    usb.util.claim_interface(device, _INTERFACE)
    interface = device.get_active_configuration()[(_INTERFACE, 0)]
    endpoint = usb.util.find_descriptor(interface, custom_match=_is_interrupt_in)
    if endpoint is None:
        raise ConnectFailedError(
            f"the USB device {device.idVendor:04x}:{device.idProduct:04x} has no interrupt endpoint:"
            " check that it is the measuring device"
        )
    return endpoint


def _is_interrupt_in(endpoint: Any) -> bool:
    kind = usb.util.endpoint_type(endpoint.bmAttributes)
    direction = usb.util.endpoint_direction(endpoint.bEndpointAddress)
    return bool(kind == usb.util.ENDPOINT_TYPE_INTR and direction == usb.util.ENDPOINT_IN)


def _texts(device: Any) -> tuple[str, str, str]:
    try:
        return device.manufacturer or "", device.product or "", device.serial_number or ""
    except (ValueError, IndexError):
        # No language, which pyusb says of a pulled cable too, or no text: the device's status tells.
        usb.control.get_status(device)
        return "", "", ""


def _read_packet(endpoint: Any, timeout_ms: int) -> bytes | None:
    try:
        return bytes(endpoint.read(endpoint.wMaxPacketSize, timeout_ms))
    except usb.core.USBTimeoutError:
        return None
