"""A simulated USB device without a bus: what a driver needs of a USB port, straight from the gadget."""

import asyncio

from truepose_drivers.errors import ConnectFailedError, ConnectionLostError, DeviceRefusedError
from truepose_drivers.usb.protocol import Setup
from truepose_simulators.instruments.gauges.usbip import StallError, UsbGadget


class UsbInMemory:
    """Plugged into nothing; `hang_up` is a pulled cable that is put back at once."""

    address = "memory"

    def __init__(self, gadget: UsbGadget) -> None:
        self._gadget = gadget
        self.is_open = False

    def hang_up(self) -> None:
        self.is_open = False

    async def open(self) -> None:
        if not self._gadget.plugged:
            raise ConnectFailedError("no USB device in memory: check its cable")
        self._gadget.attach()
        self.is_open = True

    async def close(self) -> None:
        self.is_open = False

    async def texts(self) -> tuple[str, str, str]:
        self._check()
        numbers = self._gadget.device
        return tuple(
            self._text(number)
            for number in (numbers.manufacturer_string, numbers.product_string, numbers.serial_string)
        )

    async def control_out(self, request_type, request, value=0, index=0, data=b"") -> None:
        self._control(Setup(request_type, request, value, index, len(data)), data)

    async def control_in(self, request_type, request, value, index, length) -> bytes:
        return self._control(Setup(request_type, request, value, index, length), b"")

    async def receive(self, timeout_s) -> bytes | None:
        self._check()
        try:
            async with asyncio.timeout(timeout_s):
                await self._gadget.ready()
        except TimeoutError:
            return None
        self._check()
        return self._gadget.take_packet()

    def _control(self, setup: Setup, data: bytes) -> bytes:
        self._check()
        try:
            return self._gadget.control(setup, data)
        except StallError as error:
            raise DeviceRefusedError("the device in memory refuses a request") from error

    def _text(self, number: int) -> str:
        descriptor = self._control(Setup(0x80, 6, 0x0300 | number, 0x0409, 255), b"")
        return descriptor[2 : descriptor[0]].decode("utf-16-le")

    def _check(self) -> None:
        if not self.is_open:
            raise ConnectionLostError("not connected to memory: connect first")
        if not self._gadget.plugged:
            self.is_open = False
            raise ConnectionLostError("the USB device in memory was disconnected: check its cable")
