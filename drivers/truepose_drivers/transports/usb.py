"""A USB device, opened by pyusb: on this computer through libusb, or behind a USB/IP server.

pyusb blocks, so each device has a thread of its own. Interrupt transfers wait in slices, so that a device
that is closed meanwhile is let go soon.
"""

import asyncio
import contextlib
import errno
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Protocol, TypeVar

import usb.control
import usb.core
import usb.util

from truepose_drivers.errors import ConnectFailedError, ConnectionLostError, DeviceRefusedError, NoReplyError
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


class UsbDevice:
    """A USB device with one interface and its interrupt endpoint."""

    def __init__(self, where: UsbAddress) -> None:
        self._where = where
        self._device: Any = None  # of pyusb, which has no types
        self._endpoint: Any = None
        self._thread: ThreadPoolExecutor | None = None

    @property
    def address(self) -> str:
        """Where the device is, for error texts."""
        return str(self._where)

    @property
    def is_open(self) -> bool:
        """Whether the device is there as far as known."""
        return self._device is not None

    async def open(self) -> None:
        """Take the device over, dropping what was open before; raises ConnectFailedError."""
        await self.close()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix=f"usb {self.address}")
        try:
            self._device, self._endpoint = await self._in_thread(lambda: _open_device(self._where))
        except BaseException:
            await self.close()
            raise

    async def close(self) -> None:
        """Give the device back; never raises."""
        device, thread = self._device, self._thread
        self._device = self._endpoint = self._thread = None
        if device is not None and thread is not None:
            with contextlib.suppress(usb.core.USBError):
                await asyncio.get_running_loop().run_in_executor(thread, usb.util.dispose_resources, device)
        if thread is not None:
            thread.shutdown(wait=False)

    async def texts(self) -> tuple[str, str, str]:
        """Return manufacturer, product and serial number; empty where the device tells none."""
        device = self._opened()
        return await self._guarded(lambda: _texts(device))

    async def control_out(
        self, request_type: int, request: int, value: int = 0, index: int = 0, data: bytes = b""
    ) -> None:
        """Send a control transfer; raises DeviceRefusedError, NoReplyError, ConnectionLostError."""
        device = self._opened()
        await self._guarded(
            lambda: device.ctrl_transfer(request_type, request, value, index, data, _CONTROL_TIMEOUT_MS)
        )

    async def control_in(self, request_type: int, request: int, value: int, index: int, length: int) -> bytes:
        """Ask by a control transfer; raises DeviceRefusedError, NoReplyError, ConnectionLostError."""
        device = self._opened()
        return await self._guarded(
            lambda: bytes(
                device.ctrl_transfer(request_type, request, value, index, length, _CONTROL_TIMEOUT_MS)
            )
        )

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return the next packet, None after `timeout_s` of silence; raises ConnectionLostError."""
        give_up_s = time.monotonic() + timeout_s
        while True:
            left_s = give_up_s - time.monotonic()
            data = await self._packet(max(1, round(1000.0 * min(left_s, _SLICE_S))))
            if data is not None:
                return data
            if left_s <= _SLICE_S:
                return None

    async def _packet(self, timeout_ms: int) -> bytes | None:
        self._opened()
        endpoint = self._endpoint
        return await self._guarded(lambda: _read_packet(endpoint, timeout_ms))

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
            await self.close()
            raise ConnectionLostError(
                f"USB device {self.address} is gone ({error}): check its cable, then connect again"
            ) from error

    async def _in_thread(self, call: Callable[[], Value]) -> Value:
        return await asyncio.get_running_loop().run_in_executor(self._thread, call)

    def _opened(self) -> Any:
        if self._device is None:
            raise ConnectionLostError(f"there is no connection to {self.address}: connect first")
        return self._device


def _open_device(where: UsbAddress) -> tuple[Any, Any]:
    try:
        device = _find(where)
        if device is None:
            raise ConnectFailedError(
                f"there is no USB device {where}: check its cable, and the numbers with lsusb"
            )
        return device, _prepare(device)
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
