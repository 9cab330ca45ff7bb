"""The ballbar as a USB HID device with our open report, streaming by itself."""

import asyncio
import time

from truepose_drivers.ballbar_hid.protocol import (
    BAR_ID,
    INPUT_ID,
    RATE_ID,
    BarIdentity,
    BarReading,
    HidBallbarError,
    Rate,
    Status,
    decode_rate,
    encode_bar,
    encode_rate,
    encode_reading,
    report_descriptor,
)
from truepose_drivers.usb import protocol
from truepose_drivers.usb import protocol as usb
from truepose_simulators.instruments.gauges.length_source import Electronics
from truepose_simulators.instruments.gauges.usbip import StallError, StandardRequests

# Numbers that pid.codes sets aside for tests; a maker of a real bar has numbers of his own.
VENDOR, PRODUCT = 0x1209, 0x0001
SERIAL = "SIM-0001"
_NOMINAL_MM = 100.0  # without extension bars
_POWER_ON = Rate(100, running=True)
_FASTEST_HZ = 1000  # a full-speed device has one interrupt packet a millisecond


class HidBallbarGadget:
    """State of the device: its rate, and when its next report is due (wall time)."""

    def __init__(self, bar: Electronics) -> None:
        self._bar = bar
        self._rate = _POWER_ON
        self._running = asyncio.Event()
        self._due_s = 0.0
        report = report_descriptor()
        self.device = protocol.Device(VENDOR, PRODUCT, release=0x0100)
        endpoint = protocol.Endpoint(0x81, protocol.INTERRUPT, packet_bytes=32, interval=1)
        interface = protocol.Interface(
            0, protocol.HID_CLASS, 0, 0, (endpoint,), report_descriptor_bytes=len(report)
        )
        self.configuration = protocol.Configuration(1, (interface,))
        self._standard = StandardRequests(self.device, self.configuration, self._strings, report)
        self.attach()

    @property
    def plugged(self) -> bool:
        """Whether its cable is in."""
        return self._bar.plugged

    def attach(self) -> None:
        """Begin anew: it sends by itself, as after it was plugged in."""
        self._standard.reset(self._strings)
        self._set_rate(_POWER_ON)

    def control(self, setup: usb.Setup, data: bytes) -> bytes:
        """Answer a control transfer; raises StallError."""
        match setup.request_type, setup.request:
            case (int(kind), usb.HidRequest.GET_REPORT) if kind == usb.CLASS_FROM_INTERFACE:
                return self._report(setup.value)[: setup.length]
            case (int(kind), usb.HidRequest.SET_REPORT) if kind == usb.CLASS_TO_INTERFACE:
                self._write_report(setup.value, data)
                return b""
            case (int(kind), usb.HidRequest.SET_IDLE) if kind == usb.CLASS_TO_INTERFACE:
                return b""  # it sends at its rate, whether anything changed or not
            case (int(kind), usb.HidRequest.GET_IDLE) if kind == usb.CLASS_FROM_INTERFACE:
                return bytes(1)
        return self._standard.answer(setup)

    async def ready(self) -> None:
        """Return when the next report is due."""
        await self._running.wait()
        await asyncio.sleep(max(0.0, self._due_s - time.monotonic()))

    def take_packet(self) -> bytes:
        """Make the report that is due."""
        # Late by one report at most: what nobody fetched for a while does not follow in a burst.
        self._due_s = max(self._due_s, time.monotonic() - self._period_s) + self._period_s
        return self._reading()

    @property
    def _strings(self) -> tuple[str, str, str]:
        return "truepose", "Simulated ballbar", self._bar.serial(SERIAL)

    @property
    def _period_s(self) -> float:
        return 1.0 / self._rate.rate_hz

    def _set_rate(self, rate: Rate) -> None:
        self._rate = rate
        self._due_s = time.monotonic()
        if rate.running:
            self._running.set()
        else:
            self._running.clear()

    def _report(self, value: int) -> bytes:
        match divmod(value, 256):
            case (usb.ReportType.INPUT, number) if number == INPUT_ID:
                return self._reading()
            case (usb.ReportType.FEATURE, number) if number == BAR_ID:
                return encode_bar(BarIdentity(_NOMINAL_MM, self._bar.serial(SERIAL)))
            case (usb.ReportType.FEATURE, number) if number == RATE_ID:
                return encode_rate(self._rate)
        raise StallError

    def _write_report(self, value: int, data: bytes) -> None:
        if value != usb.ReportType.FEATURE << 8 | RATE_ID:
            raise StallError
        try:
            rate = decode_rate(data)
        except HidBallbarError as error:
            raise StallError from error
        if not 1 <= rate.rate_hz <= _FASTEST_HZ:
            raise StallError
        self._set_rate(rate)

    def _reading(self) -> bytes:
        sample = self._bar.show()
        return encode_reading(
            BarReading(
                deviation_mm=sample.deviation_mm,
                out_of_range=sample.signal == "out_of_range",
                status=Status.OVERSPEED if sample.too_fast else Status(0),
                sequence=sample.sequence,
                time_us=round(self._bar.now_s * 1e6),
                temperature_c=sample.temperature_c,
            )
        )
