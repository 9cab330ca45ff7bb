"""Our USB/IP and HID against an independent implementation of both sides, the package usbip."""

import asyncio
import contextlib

import pytest

from tests.helpers.ballbar.length_sources import FakeBar, electronics
from tests.helpers.ports import free_port
from truepose_drivers.ballbar_hid.driver import PLUGIN as BALLBAR_HID
from truepose_drivers.ballbar_hid.protocol import (
    BarIdentity,
    BarReading,
    Rate,
    Status,
    decode_rate,
    decode_reading,
    encode_bar,
    encode_reading,
    report_descriptor,
)
from truepose_drivers.errors import ConnectFailedError
from truepose_drivers.mitutoyo_usb_itn.driver import PLUGIN as USB_ITN
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_simulators.instruments.gauges.ballbar_hid import HidBallbarGadget
from truepose_simulators.instruments.gauges.usb_itn import UsbItnGadget
from truepose_simulators.instruments.gauges.usbip import usbip_endpoint

usbip = pytest.importorskip("usbip", reason="usbip is not installed: no independent host and device")
device = pytest.importorskip("usbip.device")
hid_device = pytest.importorskip("usbip.classes.device.hid")
hid_host = pytest.importorskip("usbip.classes.host.hid")

FEATURE = 3


@contextlib.contextmanager
def plugged(made):
    """Serve a device of the independent implementation; yields its port."""
    port = free_port()
    with made.plug(via=usbip.USBIP("127.0.0.1", port)):
        yield port


class OtherBallbar:
    """A maker's ballbar, written with the other implementation after our description."""

    def __init__(self) -> None:
        self.sequence = 0
        self.rates: list[Rate] = []
        self.hid = hid_device.HID(
            report_descriptor(), in_mps=32, get_report=self._feature, set_report=self._set_feature
        )
        self.usb = device.USBDevice(0x1209, 0x0003, manufacturer="Other", product="Bar", serial="OB-1")
        self.usb.add(self.hid)

    def _feature(self, kind: int, number: int, length: int) -> bytes:
        assert (kind, number) == (FEATURE, 2)
        return encode_bar(BarIdentity(100.0, "OB-1"))

    def _set_feature(self, kind: int, number: int, data: bytes) -> None:
        assert (kind, number) == (FEATURE, 3)
        self.rates.append(decode_rate(data))

    async def stream(self) -> None:
        while True:
            self.sequence += 1
            self.hid.send_report(
                encode_reading(BarReading(0.0001 * self.sequence, False, Status(0), self.sequence, 0, 20.0))
            )
            await asyncio.sleep(0.005)


async def test_our_driver_reads_another_makers_ballbar():
    bar = OtherBallbar()
    with plugged(bar.usb) as port:
        driver = BALLBAR_HID.open({"usb": f"usbip://127.0.0.1:{port}/1-1"}, MonotonicClock())
        await driver.connect()
        streaming = asyncio.create_task(bar.stream())

        readings = [await driver.read() for _ in range(5)]
        identity = await driver.identify()
        streaming.cancel()
        await driver.close()

    assert (identity.manufacturer, identity.model, identity.serial) == ("Other", "Bar", "OB-1")
    assert all(reading.deviation_mm == pytest.approx(0.0001 * reading.sequence) for reading in readings)
    assert [rate.running for rate in bar.rates] == [True, False]


@contextlib.asynccontextmanager
async def simulated(protocol: str, gadget):
    endpoint = usbip_endpoint(protocol, gadget)
    yield (await endpoint.open("127.0.0.1", 0)).port
    await endpoint.close()


async def test_another_host_reads_our_simulated_hid_ballbar():
    bar = FakeBar()
    async with simulated("hid", HidBallbarGadget(electronics(bar))) as port:

        def read() -> tuple[bytes, bytes, bytes]:
            with usbip.attach("127.0.0.1", "1-1", port=port, vid=0x1209, pid=0x0001) as handle:
                driver = hid_host.HIDDriver(handle)
                driver.set_idle()
                return (
                    driver.report_descriptor(),
                    driver.read_report(),
                    driver.get_report(FEATURE, 2, 17),
                )

        described, report, feature = await asyncio.to_thread(read)

    assert described == report_descriptor()
    assert decode_reading(report).deviation_mm == 0.1234
    assert feature == encode_bar(BarIdentity(100.0, "SIM-0001"))


async def test_another_host_finds_a_keyboard_and_makes_it_talk():
    async with simulated("usb_itn", UsbItnGadget(electronics(FakeBar()))) as port:

        def read() -> tuple[dict, bytes]:
            with usbip.attach("127.0.0.1", "1-1", port=port, vid=0x0FE7, pid=0x4001) as handle:
                reports, _ = hid_host.parse_report_descriptor(hid_host.HIDDriver(handle).report_descriptor())
                handle.control(0x40, 1, 0xA5A5, 0, b"")
                handle.control(0x40, 3, 0, 0, b"1\r")
                return reports, handle.interrupt_in(0x81, 8) + handle.interrupt_in(0x81, 8)

        reports, text = await asyncio.to_thread(read)

    keyboard = {(1, 0): 8, (2, 0): 1}  # HID 1.11, appendix B.1: eight bytes of keys, one of lamps
    assert {number: report.size for number, report in reports.items()} == keyboard
    assert text == b"01A+0000.1234\r"


async def test_a_device_of_the_other_implementation_that_is_no_cable_is_told():
    keyboard = device.USBDevice(0x0FE7, 0x4001, product="Keyboard")
    keyboard.add(hid_device.HID(hid_device.keyboard_report_descriptor()))
    with plugged(keyboard) as port:
        driver = USB_ITN.open({"host": "127.0.0.1", "port": port}, None)

        with pytest.raises(ConnectFailedError, match="check that it is a USB-ITN cable"):
            await driver.connect()
