"""A USB device, opened by pyusb: on this computer through libusb, or behind a USB/IP server.

pyusb blocks; interrupt transfers wait in slices.
"""

import errno
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Protocol, TypeAlias, TypeVar
from urllib.parse import urlsplit

import usb.control
import usb.core
import usb.util

from truepose_drivers import options as option
from truepose_drivers.api import Options
from truepose_drivers.errors import ConfigurationError, ConnectFailedError, DeviceRefusedError, NoReplyError
from truepose_drivers.transports.link import BlockingPort, Source
from truepose_drivers.transports.usbip_backend import UsbipBackend
from truepose_drivers.usb import usbip

_LOCAL: Final = re.compile(r"([0-9a-fA-F]{4}):([0-9a-fA-F]{4})(?::(.+))?")
_ONLY_DEVICE: Final = "1-1"  # what a server of a single device calls it
_FORMS: Final = "vendor:product[:serial number], such as 0fe7:4001, or usbip://host[:port]/busid"


@dataclass(frozen=True, slots=True)
class LocalUsb:
    """A device of this computer; without `serial` the first of its kind."""

    vendor: int
    product: int
    serial: str | None = None

    def __str__(self) -> str:
        numbers = f"{self.vendor:04x}:{self.product:04x}"
        return numbers if self.serial is None else f"{numbers}:{self.serial}"


@dataclass(frozen=True, slots=True)
class RemoteUsb:
    """A device behind a USB/IP server."""

    host: str
    port: int
    busid: str

    def __str__(self) -> str:
        return f"usbip://{self.host}:{self.port}/{self.busid}"


UsbAddress: TypeAlias = LocalUsb | RemoteUsb


def usb_address(options: Options, default: str | None = None) -> UsbAddress:
    """Read option `usb`, or `host` and `port` of a USB/IP server that has one device.

    Raises ConfigurationError where both are given, or neither and there is no `default`.
    """
    text = option.text(options, "usb")
    if "host" in options or "port" in options:
        if text is not None:
            raise ConfigurationError("usb and host both select the device: give only one of them")
        return RemoteUsb(option.host(options), option.port(options, usbip.PORT), _ONLY_DEVICE)
    text = text or default
    if text is None:
        raise ConfigurationError(f"option usb is missing: give {_FORMS}")
    return _remote(text) if text.startswith("usbip:") else _local(text)


def _local(text: str) -> LocalUsb:
    match = _LOCAL.fullmatch(text.strip())
    if match is None:
        raise ConfigurationError(f"option usb is {text!r}: give {_FORMS}")
    vendor, product, serial = match.groups()
    return LocalUsb(int(vendor, 16), int(product, 16), serial)


def _remote(text: str) -> RemoteUsb:
    try:
        parts = urlsplit(text)
        host, port, busid = parts.hostname, parts.port or usbip.PORT, parts.path.strip("/")
    except ValueError as error:
        raise ConfigurationError(f"option usb is {text!r} ({error}): give {_FORMS}") from error
    if not host or not busid or len(busid) >= usbip.BUSID_BYTES:
        raise ConfigurationError(f"option usb is {text!r}: give {_FORMS}")
    return RemoteUsb(host, port, busid)


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
class _OpenDevice:
    """What pyusb has opened, which has no types."""

    device: Any
    endpoint: Any  # of the interrupt transfers


class UsbDevice(BlockingPort[_OpenDevice]):
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

    def _open_handle(self) -> _OpenDevice:
        return _open_device(self._where)

    def _close_handle(self, handle: _OpenDevice) -> None:
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
            raise await self._lost(
                f"USB device {self.address} was disconnected ({error}): check its cable"
            ) from error


def _open_device(where: UsbAddress) -> _OpenDevice:
    try:
        device = _find(where)
        if device is None:
            raise ConnectFailedError(f"no USB device {where}: check its cable, and its numbers with lsusb")
        return _OpenDevice(device, _prepare(device))
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
        return "give this user access to it (on Linux by a udev rule for the device), and check its cable"
    if error.errno == errno.EBUSY:
        return "check that no other program is using it"
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
