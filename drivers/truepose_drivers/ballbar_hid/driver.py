"""A ballbar that is a USB HID device: through the system's HID driver, or over USB/IP."""

import contextlib
import math
from typing import Literal

from truepose_drivers.api import BallbarReading, Clock, DeviceIdentity, DriverPlugin, Options
from truepose_drivers.ballbar_hid import protocol
from truepose_drivers.errors import DeviceRefusedError, DriverError, NoReplyError
from truepose_drivers.transports.conversation import Turns
from truepose_drivers.transports.hid import HidapiPort, HidOverUsb, ReportPort
from truepose_drivers.transports.link import OnePortDevice, introduction
from truepose_drivers.transports.usb import LocalUsb, UsbDevice, usb_address

_RATE_HZ = 200  # a reading that waits for a fresh report takes a few of these
_REPORT_TIMEOUT_S = 0.5
# Either way the count has lost its zero. A low battery does not touch the value and is let pass.
_UNTRUSTED = protocol.Status.OVERSPEED | protocol.Status.NOT_REFERENCED


class HidBallbar(OnePortDevice):
    """A ballbar that sends reports by itself."""

    def __init__(self, port: ReportPort, clock: Clock) -> None:
        super().__init__(port)
        self._port: ReportPort = port
        self._clock = clock
        self._nominal_mm = math.inf
        self._last: int | None = None  # number of the newest report of this connection
        self._turns = Turns(port, harmless=(DeviceRefusedError,))

    async def connect(self) -> None:
        """Open the device, ask how long it is and let it send; raises ConnectFailedError."""
        await self._port.open()
        self._last = None
        async with introduction(self._port, "check that it is a ballbar"), self._turns.turn():
            bar = await self._port.feature(protocol.BAR_ID, protocol.BAR_BYTES)
            self._nominal_mm = protocol.decode_bar(bar).nominal_mm
            await self._port.set_feature(protocol.encode_rate(protocol.Rate(_RATE_HZ, running=True)))

    async def close(self) -> None:
        """Let the device rest and close it; never raises."""
        # Closing does not wait for an exchange under way, so it sends nothing of its own into one.
        if self._port.is_open and not self._turns.taken:
            with contextlib.suppress(DriverError):
                await self._port.set_feature(protocol.encode_rate(protocol.Rate(_RATE_HZ, running=False)))
        await self._port.close()

    async def identify(self) -> DeviceIdentity:
        """Ask for manufacturer, product and serial number."""
        async with self._turns.turn():
            manufacturer, product, serial = await self._port.texts()
            bar = protocol.decode_bar(await self._port.feature(protocol.BAR_ID, protocol.BAR_BYTES))
        return DeviceIdentity(
            manufacturer or "unknown", product or "HID ballbar", bar.serial or serial or "unknown", "unknown"
        )

    async def read(self) -> BallbarReading:
        """Return a reading that was made after it was asked for."""
        async with self._turns.turn():
            if self._last is None:  # the first one after connecting only tells where the count stands
                await self._next_reading()
            reading = await self._next_reading()
        signal = _signal(reading)
        return BallbarReading(
            deviation_mm=math.nan if signal == "none" else reading.deviation_mm,
            signal=signal,
            resolution_mm=1.0 / protocol.COUNTS_PER_MM,
            # Not the device's time: it begins again every 71 minutes, and no other instrument shares its
            # zero.
            time_s=await self._clock.now_s(),
            temperature_c=reading.temperature_c,
            sequence=reading.sequence,
        )

    async def _next_reading(self) -> protocol.BarReading:
        """Return a new report; raises HidBallbarError for one that is old, or longer than the bar."""
        report = await self._port.fresh_report(_REPORT_TIMEOUT_S)
        if report is None:
            raise NoReplyError(
                f"the ballbar at {self._port.address} sends nothing for {_REPORT_TIMEOUT_S:g} s:"
                " check its battery, then plug it in again"
            )
        reading, last = protocol.decode_reading(report), self._last
        if last is not None and not protocol.follows(reading.sequence, last):
            raise protocol.HidBallbarError(
                f"the ballbar at {self._port.address} sends reading {reading.sequence} after {last}:"
                " it repeats itself; unplug it and plug it in again"
            )
        self._last = reading.sequence
        if abs(reading.deviation_mm) >= self._nominal_mm:  # a NaN is not
            raise protocol.HidBallbarError(
                f"the ballbar at {self._port.address} is {self._nominal_mm:g} mm long and reports a"
                f" deviation of {reading.deviation_mm:g} mm: check its cable"
            )
        return reading


def _signal(reading: protocol.BarReading) -> Literal["good", "out_of_range", "none"]:
    if reading.status & _UNTRUSTED or math.isnan(reading.deviation_mm):
        return "none"
    return "out_of_range" if reading.out_of_range else "good"


def _open(options: Options, clock: Clock) -> HidBallbar:
    where = usb_address(options)
    port = (
        HidapiPort(where, protocol.READING_BYTES)
        if isinstance(where, LocalUsb)
        else HidOverUsb(UsbDevice(where))
    )
    return HidBallbar(port, clock)


_OPTIONS = {
    "usb": "vendor:product[:serial number] of a device here, or usbip://host[:port]/busid",
    "host": "instead of usb: address of a USB/IP server whose only device it is",
    "port": "TCP port of the USB/IP server, default 3240",
}
PLUGIN = DriverPlugin("ballbar_hid", "ballbar", "hid", _OPTIONS, _open)
