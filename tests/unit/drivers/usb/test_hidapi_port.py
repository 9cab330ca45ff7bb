"""HID devices through the system: hidapi's own C code on a device made up by umockdev, and its failures."""

import itertools
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.helpers.checkout import CHECKOUT, SOURCES
from tests.helpers.machine import UMOCKDEV
from tests.unit.drivers.usb.umockdev_ballbar import write_device
from truepose_drivers.errors import ConnectFailedError, ConnectionLostError, DeviceRefusedError
from truepose_drivers.transports.hid import HidapiPort
from truepose_drivers.transports.usb import LocalUsb

BAR = LocalUsb(0x1209, 0x0001)
REPORT = bytes([1, *range(16)])

real_hidapi = pytest.mark.skipif(shutil.which("umockdev-run") is None, reason=UMOCKDEV.reason)


def read_through_hidapi(folder: Path, usb: str, readings: int, deviations_mm: list[float]) -> dict:
    command = write_device(folder, "BAR-7", deviations_mm, every_ms=5)
    done = subprocess.run(
        [*command, sys.executable, str(Path(__file__).parent / "umockdev_reader.py"), usb, str(readings)],
        capture_output=True,
        text=True,
        timeout=60.0,
        check=True,
        env={"PYTHONPATH": os.pathsep.join((*SOURCES, str(CHECKOUT))), "PATH": "/usr/bin:/bin"},
    )
    return json.loads(done.stdout)


@real_hidapi
def test_hidapi_reads_the_newest_report_of_a_stream_that_nobody_fetched(tmp_path):
    steps_mm = [0.001 * number for number in range(1200)]

    seen = read_through_hidapi(tmp_path, "1209:0001:BAR-7", 3, steps_mm)

    assert seen["identity"]["manufacturer"] == "Workshop"
    assert seen["identity"]["serial"] == "BAR-7"
    numbers = [reading["sequence"] for reading in seen["readings"]]
    # 200 ms lie between two readings and 5 ms between two reports, more on a busy machine: of some 40 that
    # queued up meanwhile all were dropped
    assert all(later - earlier >= 5 for earlier, later in itertools.pairwise(numbers))
    shown = [reading["deviation_mm"] for reading in seen["readings"]]
    assert shown == pytest.approx([steps_mm[number - 1] for number in numbers], abs=0.5e-4)


@real_hidapi
def test_a_stream_that_ends_is_told(tmp_path):
    seen = read_through_hidapi(tmp_path, "1209:0001", 20, [0.1] * 100)  # half a second of it

    assert seen["error"][0] == "NoReplyError"


@real_hidapi
@pytest.mark.parametrize("usb", ["1209:0002", "1209:0001:OTHER"])
def test_another_number_or_serial_is_not_this_device(tmp_path, usb):
    seen = read_through_hidapi(tmp_path, usb, 1, [0.1])

    kind, sentence = seen["error"]
    assert kind == "ConnectFailedError"
    assert usb in sentence


class FakeHidapi:
    """What hidapi offers, with one device; `broken` makes it behave as after a pulled cable."""

    def __init__(self, *queue: bytes) -> None:
        self.queue = list(queue)
        self.live = REPORT
        self.broken = False
        self.openable = True
        self.closed = 0

    def enumerate(self) -> list[dict]:
        numbers = {"vendor_id": 0x1209, "product_id": 0x0001, "serial_number": "BAR-7", "path": b"/dev/x"}
        return [{**numbers, "manufacturer_string": None, "product_string": "Bar"}]

    def device(self) -> "FakeHidapi":
        return self

    def open_path(self, path: bytes) -> None:
        if not self.openable:
            raise OSError("open failed")

    def set_nonblocking(self, on: int) -> None: ...

    def read(self, length: int, timeout_ms: int = 0) -> list[int]:
        if self.broken:
            raise OSError("read error")
        if timeout_ms:
            return list(self.live)
        return list(self.queue.pop(0)) if self.queue else []

    def get_feature_report(self, number: int, length: int) -> list[int]:
        if self.broken:
            raise OSError("read error")
        return [number, *bytes(length - 1)]

    def send_feature_report(self, report: list[int]) -> int:
        return -1 if self.broken else len(report)

    def close(self) -> None:
        self.closed += 1


async def opened(system: FakeHidapi) -> HidapiPort:
    port = HidapiPort(BAR, len(REPORT), system)
    await port.open()
    return port


async def test_what_queued_up_is_dropped():
    port = await opened(FakeHidapi(b"old", b"older"))

    assert await port.fresh_report(0.1) == REPORT
    await port.close()


async def test_a_pulled_cable_is_a_lost_connection_and_the_device_is_closed():
    system = FakeHidapi()
    port = await opened(system)
    system.broken = True

    with pytest.raises(ConnectionLostError, match="check its cable"):
        await port.fresh_report(0.1)
    assert not port.is_open
    assert system.closed == 1
    with pytest.raises(ConnectionLostError, match="connect first"):
        await port.fresh_report(0.1)


async def test_a_device_that_may_not_be_opened_is_told_with_the_remedy():
    system = FakeHidapi()
    system.openable = False

    with pytest.raises(ConnectFailedError, match="udev rule"):
        await opened(system)


async def test_silence_is_none():
    system = FakeHidapi()
    port = await opened(system)
    system.live = b""

    assert await port.fresh_report(0.06) is None
    await port.close()


async def test_a_refused_feature_is_a_refusal_whichever_way_hidapi_tells_it():
    system = FakeHidapi()
    port = await opened(system)
    system.broken = True

    with pytest.raises(DeviceRefusedError):
        await port.feature(2, 17)
    with pytest.raises(DeviceRefusedError):
        await port.set_feature(b"\x03\x00")
    await port.close()


async def test_missing_texts_are_empty():
    port = await opened(FakeHidapi())

    assert await port.texts() == ("", "Bar", "BAR-7")
    await port.close()
    await port.close()
