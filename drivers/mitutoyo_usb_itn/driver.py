"""A Digimatic gauge on a Mitutoyo USB-ITN cable: on this computer, or over USB/IP."""

import asyncio
import contextlib
import math
import time
from collections.abc import AsyncIterator

from drivers import options as option
from drivers.api import BallbarReading, Clock, DeviceIdentity, DriverPlugin, Options
from drivers.errors import ConnectFailedError, DeviceRefusedError, NoReplyError, RemoteProtocolError
from drivers.mitutoyo_usb_itn.protocol import (
    GET_MODE,
    PRODUCT,
    READ_DEVICE,
    READ_VALUE,
    SEND_COMMAND,
    SERIAL_MODE,
    SET_MODE,
    VENDOR,
    DeviceInfo,
    Error,
    Reply,
    ReplyReader,
    Value,
)
from drivers.monotonic_clock import MonotonicClock
from drivers.transports.usb import UsbDevice, UsbPort
from drivers.transports.usb_address import usb_address
from drivers.usb.protocol.control import VENDOR_FROM_DEVICE, VENDOR_TO_DEVICE

_REPLY_TIMEOUT_S = 1.0  # a Digimatic gauge takes up to a quarter of a second to send its value
_ANY_CABLE = f"{VENDOR:04x}:{PRODUCT:04x}"
_RANGE_MM = 1.0
_FINEST_DECIMALS = 4  # resolution to state while no value has come yet: 0.1 um
_PLUG = "unplug the cable and plug it in again"


class UsbItnGauge:
    """A gauge on a USB-ITN cable. It answers when asked."""

    def __init__(
        self,
        port: UsbPort,
        clock: Clock,
        *,
        range_mm: float = _RANGE_MM,
        reply_timeout_s: float = _REPLY_TIMEOUT_S,
    ) -> None:
        self._port = port
        self._clock = clock
        self._range_mm = range_mm
        self._reply_timeout_s = reply_timeout_s
        self._decimals = _FINEST_DECIMALS
        self._lock = asyncio.Lock()

    @property
    def connected(self) -> bool:
        """Whether the cable is there as far as known."""
        return self._port.is_open

    async def connect(self) -> None:
        """Take the cable from the keyboard driver and make it talk; raises ConnectFailedError."""
        await self._port.open()
        async with self._turn():
            try:
                await self._port.control_out(VENDOR_TO_DEVICE, SET_MODE, SERIAL_MODE)
                await self._port.control_in(VENDOR_FROM_DEVICE, GET_MODE, 0, 0, 1)
            except (DeviceRefusedError, NoReplyError) as error:
                raise ConnectFailedError(
                    f"the device at {self._port.address} does not leave its keyboard mode ({error}):"
                    " check that it is a USB-ITN cable"
                ) from error

    async def close(self) -> None:
        """Give the cable back; never raises."""
        await self._port.close()

    async def identify(self) -> DeviceIdentity:
        """Ask the cable who it is; the gauge on it does not tell."""
        async with self._turn():
            manufacturer, product, serial = await self._port.texts()
            reply = await self._ask(READ_DEVICE)
        if not isinstance(reply, DeviceInfo):
            raise RemoteProtocolError(f"the cable answered {reply!r} when asked who it is")
        return DeviceIdentity(
            manufacturer or "Mitutoyo", product or "USB-ITN", serial or "unknown", reply.text or "unknown"
        )

    async def read(self) -> BallbarReading:
        """Ask the gauge for what it displays; a gauge that says nothing is a reading without a signal."""
        async with self._turn():
            reply = await self._ask(READ_VALUE)
        time_s = await self._clock.now_s()
        match reply:
            case Value(shown, decimals):
                self._decimals = decimals
                # Half a step more: the end of the range is within it, whatever a double makes of it.
                inside = abs(shown) <= self._range_mm + 0.5 * self._resolution_mm
                return BallbarReading(
                    shown, "good" if inside else "out_of_range", self._resolution_mm, time_s
                )
            case Error():
                return BallbarReading(math.nan, "none", self._resolution_mm, time_s)
            case DeviceInfo(text):
                raise RemoteProtocolError(f"the cable told about itself ({text!r}) when asked for a value")

    @property
    def _resolution_mm(self) -> float:
        return 10.0**-self._decimals

    async def _ask(self, command: bytes) -> Reply:
        await self._port.control_out(VENDOR_TO_DEVICE, SEND_COMMAND, data=command)
        reader, give_up_s = ReplyReader(), time.monotonic() + self._reply_timeout_s
        while (reply := reader.next_reply()) is None:
            packet = await self._port.interrupt_in(max(0.0, give_up_s - time.monotonic()))
            if packet is None:
                raise NoReplyError(
                    f"the cable at {self._port.address} says nothing: {_PLUG}, and check the gauge's battery"
                )
            reader.receive_packet(packet)
        return reply

    @contextlib.asynccontextmanager
    async def _turn(self) -> AsyncIterator[None]:
        """Take the floor; what breaks off closes the device, as a late reply would be misread."""
        async with self._lock:
            try:
                yield
            except BaseException:
                await self._port.close()
                raise


def _open(options: Options, clock: Clock | None) -> UsbItnGauge:
    where = usb_address(options, default=_ANY_CABLE)
    range_mm = option.positive(options, "range_mm", _RANGE_MM)
    return UsbItnGauge(UsbDevice(where), clock or MonotonicClock(), range_mm=range_mm)


PLUGIN = DriverPlugin(
    name="mitutoyo_usb_itn",
    kind="ballbar",
    protocol="usb_itn",
    options={
        "usb": f"vendor:product[:serial number], {_ANY_CABLE} unless given, or usbip://host[:port]/busid",
        "host": "instead of usb: address of a USB/IP server whose only device it is",
        "port": "TCP port of the USB/IP server, 3240 unless changed",
        "range_mm": "either way of zero; what lies beyond is out of range; 1.0 unless given",
    },
    open=_open,
)
