"""The HID ballbar's conversation, against a port that the test fills."""

import itertools
import math

import pytest

from truepose_drivers.ballbar_hid.driver import PLUGIN, HidBallbar
from truepose_drivers.ballbar_hid.protocol import (
    BarIdentity,
    BarReading,
    Rate,
    Status,
    decode_rate,
    encode_bar,
    encode_reading,
)
from truepose_drivers.errors import (
    ConfigurationError,
    ConnectFailedError,
    ConnectionLostError,
    DeviceRefusedError,
    NoReplyError,
    RemoteProtocolError,
)
from truepose_drivers.monotonic_clock import MonotonicClock

NUMBERS = itertools.count(7)


class FakePort:
    """Hands out what the test puts in."""

    address = "here"

    def __init__(self, *reports: bytes | None) -> None:
        self.reports = [numbered(6), *reports]  # the first one shows that it sends
        self.rates: list[Rate] = []
        self.bar = encode_bar(BarIdentity(100.0, "BAR-7"))
        self.is_open = False
        self.refuses = False

    async def open(self) -> None:
        self.is_open = True

    async def close(self) -> None:
        self.is_open = False

    async def texts(self) -> tuple[str, str, str]:
        return "", "", "USB-SERIAL"

    async def fresh_report(self, timeout_s: float) -> bytes | None:
        if not self.is_open:
            raise ConnectionLostError("connect first")
        return self.reports.pop(0)

    async def feature(self, number: int, length: int) -> bytes:
        return self.bar

    async def set_feature(self, report: bytes) -> None:
        if self.refuses:
            raise DeviceRefusedError("no such report")
        self.rates.append(decode_rate(report))


def report(deviation_mm: float = 0.1234, *, out: bool = False, status: Status = Status(0)) -> bytes:  # noqa: B008
    return encode_reading(BarReading(deviation_mm, out, status, next(NUMBERS), 0, 21.37))


async def connected(port: FakePort) -> HidBallbar:
    driver = HidBallbar(port, MonotonicClock())
    await driver.connect()
    return driver


@pytest.fixture
def port():
    return FakePort()


@pytest.fixture
async def driver(port):
    return await connected(port)


async def test_connecting_starts_the_stream_and_closing_stops_it(port, driver):
    await driver.close()

    assert [rate.running for rate in port.rates] == [True, False]
    assert not driver.connected


async def test_a_reading_carries_temperature_and_number():
    driver = await connected(FakePort(numbered(1234)))

    reading = await driver.read()

    assert (reading.deviation_mm, reading.temperature_c, reading.sequence) == (0.1234, 21.37, 1234)


def numbered(sequence: int, deviation_mm: float = 0.1234) -> bytes:
    return encode_reading(BarReading(deviation_mm, False, Status(0), sequence, 0, 21.37))


@pytest.mark.parametrize("second", [17, 16, 2**31 + 17], ids=["frozen", "back", "far back"])
async def test_a_device_that_repeats_itself_has_no_length(port, second):
    port.reports = [numbered(16), numbered(17), numbered(second)]
    driver = await connected(port)
    await driver.read()

    with pytest.raises(RemoteProtocolError, match="repeats itself"):
        await driver.read()
    assert not driver.connected


async def test_a_device_that_hangs_gives_no_length_after_connecting_again_either(port):
    port.reports = [numbered(17)] * 4
    driver = await connected(port)

    for _ in range(2):
        with pytest.raises(RemoteProtocolError, match="repeats itself"):
            await driver.read()
        if port.reports:
            await driver.connect()


async def test_numbers_begin_again_after_the_largest(port):
    port.reports = [numbered(2**32 - 1), numbered(0), numbered(1)]
    driver = await connected(port)

    assert [(await driver.read()).sequence for _ in range(2)] == [0, 1]


@pytest.mark.parametrize("deviation_mm", [100.0, -100.0, 25_400.0])
async def test_a_bar_that_is_off_by_its_own_length_is_told(deviation_mm):
    driver = await connected(FakePort(report(deviation_mm)))

    with pytest.raises(RemoteProtocolError, match="100 mm long"):
        await driver.read()
    assert not driver.connected


@pytest.mark.parametrize("place", [5, 6], ids=["out of range", "status"])
async def test_bits_that_mean_nothing_are_told(place):
    garbled = bytearray(report())
    garbled[place] |= 0x40
    driver = await connected(FakePort(bytes(garbled)))

    with pytest.raises(RemoteProtocolError, match="no ballbar uses"):
        await driver.read()


async def test_a_bar_without_a_length_is_none(port):
    port.bar = encode_bar(BarIdentity(0.0, "BAR-7"))

    with pytest.raises(RemoteProtocolError, match="nominal length"):
        await connected(port)
    assert not port.is_open


async def test_a_device_may_begin_to_send_after_connecting_and_a_silent_one_is_told(port):
    port.reports = [None]
    driver = await connected(port)

    with pytest.raises(NoReplyError, match="check its battery"):
        await driver.read()


@pytest.mark.parametrize("status", [Status.OVERSPEED, Status.NOT_REFERENCED, Status(7)])
async def test_a_value_whose_zero_is_lost_is_no_length(status):
    driver = await connected(FakePort(report(status=status)))

    reading = await driver.read()

    assert reading.signal == "none"
    assert math.isnan(reading.deviation_mm)


async def test_a_weak_battery_does_not_spoil_a_length():
    driver = await connected(FakePort(report(status=Status.LOW_BATTERY)))

    assert (await driver.read()).signal == "good"


async def test_out_of_range_keeps_what_the_stop_shows():
    driver = await connected(FakePort(report(-1.05, out=True)))

    reading = await driver.read()

    assert (reading.signal, reading.deviation_mm) == ("out_of_range", -1.05)


async def test_a_device_without_our_features_is_refused_when_connecting(port):
    port.refuses = True

    with pytest.raises(ConnectFailedError, match="check that it is a ballbar"):
        await connected(port)
    assert not port.is_open


async def test_the_bars_own_serial_number_goes_before_that_of_its_plug(port, driver):
    assert (await driver.identify()).serial == "BAR-7"
    port.bar = encode_bar(BarIdentity(100.0, ""))
    assert (await driver.identify()).serial == "USB-SERIAL"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({}, "usb is missing"),
        ({"usb": "1209"}, "vendor:product"),
        ({"usb": "12091:0001"}, "vendor:product"),
        ({"usb": "usbip://"}, "busid"),
        ({"usb": "usbip://host"}, "busid"),
        ({"usb": "usbip://host:99999/1-1"}, "Port out of range"),
        ({"usb": "1209:0001", "host": "127.0.0.1"}, "one of them"),
        ({"usb": 1209}, "usb"),
        ({"host": "127.0.0.1", "port": 0}, "port"),
    ],
)
def test_an_option_that_does_not_fit_is_named(options, said):
    with pytest.raises(ConfigurationError, match=said):
        PLUGIN.open(options, None)
