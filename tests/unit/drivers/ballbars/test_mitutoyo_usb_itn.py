"""The USB-ITN cable: its text, and its conversation against a scripted port."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose_drivers.errors import (
    ConfigurationError,
    ConnectFailedError,
    ConnectionLostError,
    DeviceRefusedError,
    RemoteProtocolError,
)
from truepose_drivers.line_gauges.protocol import Value
from truepose_drivers.mitutoyo_usb_itn.driver import PLUGIN, UsbItnGauge
from truepose_drivers.mitutoyo_usb_itn.protocol import DeviceInfo, Error, ReplyReader, decode, encode
from truepose_drivers.monotonic_clock import MonotonicClock


@pytest.mark.parametrize(
    ("text", "reply"),
    [
        (b"01A+00123.456", Value(123.456, 3)),
        (b"01A-0000.1234", Value(-0.1234, 4)),
        (b"01A+0000.123", Value(0.123, 3)),
        (b"01A+00.12345", Value(0.12345, 5)),
        (b"01A+00001234", Value(1234.0, 0)),
        (b"01A-00000.00", Value(-0.0, 2)),
        (b"911", Error(911)),
        (b"1USB-ITN V1.00", DeviceInfo("USB-ITN V1.00")),
    ],
)
def test_lines_of_the_manual_are_read(text, reply):
    assert decode(text) == reply


def test_a_value_has_a_field_of_nine_characters():
    assert encode(Value(-0.1234, 4)) == b"01A-0000.1234\r"
    assert encode(Value(12.5, 3)) == b"01A+00012.500\r"


@given(counts=st.integers(-99_999_999, 99_999_999))
def test_values_make_the_round_trip(counts):
    assert decode(encode(Value(counts / 10_000, 4)).rstrip(b"\r")) == Value(counts / 10_000, 4)


@pytest.mark.parametrize(
    "text",
    [
        *(b"", b"0", b"01A", b"01A0.1", b"01A+.", b"01B+0.1", b"9", b"91", b"\xff", b"01A+1e5"),
        b"02A+0000.1234",  # a cable has one channel
        b"01A+0000.12234",  # a digit twice
        b"01A+000.123",  # one lost
        b"01A+00.0.1234",
        b"01A+0000\0.123",
    ],
)
def test_what_is_no_reply_is_told(text):
    with pytest.raises(RemoteProtocolError, match="not a reply from a USB-ITN"):
        decode(text)


def test_packets_are_put_together_and_padding_is_dropped():
    reader = ReplyReader()

    for packet in (b"01A-0000", b".1234\r\0\0", b"911\r"):
        reader.receive_data(packet)

    assert [reader.next_message() for _ in range(3)] == [Value(-0.1234, 4), Error(911), None]


def test_a_stream_without_end_is_told():
    reader = ReplyReader()
    reader.receive_data(b"x" * 65)

    with pytest.raises(RemoteProtocolError, match="does not end"):
        reader.next_message()


class FakeCable:
    """Answers commands by what the test put there; None is silence."""

    address = "here"

    def __init__(self, **answers: list[bytes] | None) -> None:
        self.answers = {b"1\r": [b"01A+0000", b".1234\r"], b"V\r": [b"1V2\r"]}
        self.answers |= {f"{command}\r".encode(): packets for command, packets in answers.items()}
        self.packets: list[bytes] = []
        self.said: list[tuple] = []
        self.is_open = False
        self.refuses = False

    async def open(self) -> None:
        self.is_open = True
        self.packets.clear()

    async def close(self) -> None:
        self.is_open = False

    async def texts(self) -> tuple[str, str, str]:
        return "", "", ""

    async def control_out(self, request_type, request, value=0, index=0, data=b"") -> None:
        if not self.is_open:
            raise ConnectionLostError("connect first")
        if self.refuses:
            raise DeviceRefusedError("stalled")
        self.said.append((request_type, request, value, data))
        answer = self.answers.get(data)
        self.packets += (answer() if callable(answer) else answer) or []

    async def control_in(self, request_type, request, value, index, length) -> bytes:
        self.said.append((request_type, request, value, length))
        return b"\x01"

    async def receive(self, timeout_s: float) -> bytes | None:
        return self.packets.pop(0) if self.packets else None


async def connected(cable: FakeCable, **options) -> UsbItnGauge:
    driver = UsbItnGauge(cable, MonotonicClock(), **options)
    await driver.connect()
    return driver


@pytest.fixture
def cable():
    return FakeCable()


@pytest.fixture
async def driver(cable):
    return await connected(cable)


async def test_the_cable_is_taken_out_of_keyboard_mode_as_public_clients_do(cable, driver):
    await driver.read()

    assert cable.said[:2] == [(0x40, 1, 0xA5A5, b""), (0xC0, 2, 0, 1)]
    assert {text for *request, text in cable.said[2:] if request == [0x40, 3, 0]} == {b"V\r", b"1\r"}


@pytest.mark.parametrize(
    ("packets", "deviation_mm", "resolution_mm", "signal"),
    [
        ([b"01A+0000", b".1234\r"], 0.1234, 1e-4, "good"),
        ([b"01A-0000", b"0.987\r"], -0.987, 1e-3, "good"),
        ([b"01A+0001", b".0000\r"], 1.0, 1e-4, "good"),
        ([b"01A+0001", b".0001\r"], 1.0001, 1e-4, "out_of_range"),
        ([b"01A-0001", b".0500\r"], -1.05, 1e-4, "out_of_range"),
    ],
)
async def test_a_reading_is_what_the_gauge_shows(packets, deviation_mm, resolution_mm, signal):
    driver = await connected(FakeCable(**{"1": packets}))

    reading = await driver.read()

    assert (reading.deviation_mm, reading.signal) == (deviation_mm, signal)
    assert reading.resolution_mm == pytest.approx(resolution_mm, rel=1e-12)


@pytest.mark.parametrize("number", [911, 912, 913])
async def test_an_error_of_the_cable_is_no_length_and_the_link_stays(number):
    driver = await connected(FakeCable(**{"1": [f"{number}\r".encode()]}))

    reading = await driver.read()

    assert reading.signal == "none"
    assert math.isnan(reading.deviation_mm)
    assert driver.connected


async def test_a_wider_gauge_has_a_wider_range():
    driver = await connected(FakeCable(**{"1": [b"01A+0001", b".5000\r"]}), range_mm=5.0)

    assert (await driver.read()).signal == "good"


async def test_an_answer_to_something_else_is_told_and_closes():
    driver = await connected(FakeCable(**{"1": [b"1V2\r"]}))

    with pytest.raises(RemoteProtocolError, match="told about itself"):
        await driver.read()
    assert not driver.connected


async def test_a_cable_that_does_not_say_who_it_is_is_told_when_connecting():
    with pytest.raises(ConnectFailedError, match="check that it is a USB-ITN"):
        await connected(FakeCable(V=[b"911\r"]))


async def test_half_a_line_that_nobody_asked_for_is_passed_over_with_its_other_half(cable, driver):
    await driver.read()
    answers = [[b"01A+0000", b".1234\r01A+", b"0000", b".9999\r"], [b"01A+0000.4321\r"]]  # the button's line
    cable.answers[b"1\r"] = lambda: answers.pop(0)

    assert (await driver.read()).deviation_mm == 0.4321


async def test_a_cable_that_always_sends_more_than_it_is_asked_for_is_told(cable, driver):
    cable.answers[b"1\r"] = [b"01A+0000.1234\r", b"01A+0000.1234\r"]

    with pytest.raises(RemoteProtocolError, match="do not press keys on the gauge"):
        await driver.read()
    assert not driver.connected


@pytest.mark.parametrize(
    "line",
    [
        b"01A+00.00486\r",  # the same length in inches
        b"01A+00000.123\r",  # a digit behind the point twice among the others
        b"01A+000.1234\r",  # one lost
    ],
)
async def test_a_value_of_another_form_is_no_length_however_often_it_comes(cable, driver, line):
    await driver.read()
    cable.answers[b"1\r"] = [line]

    for _ in range(3):
        with pytest.raises(RemoteProtocolError, match=r"inches, or characters were lost; set it"):
            await driver.read()
        assert not driver.connected
        await driver.connect()


async def test_the_form_of_values_is_learnt_from_two_that_agree(cable, driver):
    lines = [b"01A+00000.123\r", b"01A+0000.1234\r", b"01A+0000.1235\r"]
    cable.answers[b"1\r"] = lambda: [lines.pop(0)]

    reading = await driver.read()

    assert (reading.deviation_mm, reading.resolution_mm) == (0.1235, pytest.approx(1e-4))


@pytest.mark.parametrize(("decimals", "line"), [(None, b"01A+00.00486\r"), (3, b"01A+0000.0486\r")])
async def test_a_gauge_that_shows_inches_from_the_beginning_is_told(decimals, line):
    driver = await connected(FakeCable(**{"1": [line]}), decimals=decimals)

    with pytest.raises(RemoteProtocolError, match="inches"):
        await driver.read()


async def test_a_gauge_without_a_signal_teaches_nothing():
    cable = FakeCable(**{"1": [b"911\r"]})
    driver = await connected(cable)
    assert (await driver.read()).signal == "none"

    cable.answers[b"1\r"] = [b"01A+00000.123\r"]

    assert (await driver.read()).resolution_mm == pytest.approx(1e-3)


@pytest.mark.parametrize("decimals", [-1, 7, 1.0, True, "3"])
def test_a_number_of_digits_that_is_none_is_refused(decimals):
    with pytest.raises(ConfigurationError, match="decimals"):
        PLUGIN.open({"decimals": decimals}, None)


async def test_a_keyboard_that_is_no_cable_is_told_when_connecting(cable):
    cable.refuses = True

    with pytest.raises(ConnectFailedError, match="check that it is a USB-ITN"):
        await connected(cable)
    assert not cable.is_open


async def test_the_cable_tells_its_firmware():
    identity = await (await connected(FakeCable())).identify()

    assert (identity.manufacturer, identity.model, identity.firmware) == ("Mitutoyo", "USB-ITN", "V2")


@pytest.mark.parametrize("value", [0, -1.0, "1", True, math.nan, math.inf])
def test_a_range_that_is_none_is_refused(value):
    with pytest.raises(ConfigurationError, match="range_mm"):
        PLUGIN.open({"range_mm": value}, None)


def test_without_an_address_it_is_any_such_cable_here():
    assert PLUGIN.open({}, None)._port.address == "0fe7:4001"
