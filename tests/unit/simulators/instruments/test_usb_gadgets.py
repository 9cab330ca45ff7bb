"""The simulated USB devices on endpoint 0, and their packets."""

import asyncio

import pytest

from tests.helpers.ballbar.length_sources import FakeBar, electronics
from tests.helpers.machine import HANGS_S
from truepose_drivers.ballbar_hid.protocol import (
    Rate,
    decode_rate,
    decode_reading,
    encode_rate,
    report_descriptor,
)
from truepose_drivers.usb.protocol import Setup, decode_configuration, decode_device
from truepose_simulators.instruments.gauges.ballbar_hid import HidBallbarGadget
from truepose_simulators.instruments.gauges.usb_itn import UsbItnGadget
from truepose_simulators.instruments.gauges.usbip import StallError

GADGETS = pytest.mark.parametrize("kind", [HidBallbarGadget, UsbItnGadget])
SET_RATE = Setup(0x21, 9, 0x0303, 0, 4)


@pytest.fixture
def bar():
    return FakeBar()


def ask(gadget, request_type, request, value=0, index=0, length=255) -> bytes:
    return gadget.control(Setup(request_type, request, value, index, length), b"")


@GADGETS
def test_a_computer_finds_its_way_from_the_descriptors(bar, kind):
    gadget = kind(electronics(bar))

    device = decode_device(ask(gadget, 0x80, 6, 0x0100))
    configuration = decode_configuration(ask(gadget, 0x80, 6, 0x0200))

    assert device == gadget.device
    assert configuration.interfaces == gadget.configuration.interfaces
    (interface,) = configuration.interfaces
    report = ask(gadget, 0x81, 6, 0x2200)
    assert len(report) == interface.report_descriptor_bytes
    assert ask(gadget, 0x81, 6, 0x2100)[7:9] == len(report).to_bytes(2, "little")
    texts = [ask(gadget, 0x80, 6, 0x0300 | number) for number in range(4)]
    assert all(text[0] == len(text) and text[1] == 3 for text in texts)


@GADGETS
def test_only_as_much_as_asked_for_is_answered(bar, kind):
    gadget = kind(electronics(bar))

    assert len(ask(gadget, 0x80, 6, 0x0100, length=8)) == 8
    assert len(ask(gadget, 0x80, 6, 0x0200, length=9)) == 9


@GADGETS
def test_its_one_configuration_can_be_chosen_and_no_other(bar, kind):
    gadget = kind(electronics(bar))

    assert ask(gadget, 0x80, 8, length=1) == b"\x00"
    ask(gadget, 0x00, 9, 1)
    assert ask(gadget, 0x80, 8, length=1) == b"\x01"
    with pytest.raises(StallError):
        ask(gadget, 0x00, 9, 2)
    gadget.attach()
    assert ask(gadget, 0x80, 8, length=1) == b"\x00"


@GADGETS
@pytest.mark.parametrize(
    ("request_type", "request_number", "value"),
    [
        (0x80, 6, 0x0309),
        (0x80, 6, 0x0600),
        (0x81, 6, 0x2300),
        (0x01, 11, 1),
        (0xC0, 77, 0),
        (0x21, 9, 0x0309),
    ],
)
def test_what_it_does_not_know_stalls(bar, kind, request_type, request_number, value):
    gadget = kind(electronics(bar))
    if (kind, request_type, request_number) == (UsbItnGadget, 0x21, 9):
        return  # a keyboard takes any report: its lamps

    with pytest.raises(StallError):
        ask(gadget, request_type, request_number, value)


async def test_the_hid_bar_sends_by_itself_from_the_start(bar):
    gadget = HidBallbarGadget(electronics(bar))
    gadget.attach()

    async with asyncio.timeout(HANGS_S):
        await gadget.ready()

    reading = decode_reading(gadget.take_packet())
    assert (reading.deviation_mm, reading.temperature_c) == (0.1234, 21.37)


async def test_the_hid_bar_stops_and_starts_when_told(bar):
    gadget = HidBallbarGadget(electronics(bar))
    gadget.control(SET_RATE, encode_rate(Rate(500, running=False)))

    with pytest.raises(TimeoutError):
        async with asyncio.timeout(0.05):
            await gadget.ready()
    gadget.control(SET_RATE, encode_rate(Rate(500, running=True)))
    async with asyncio.timeout(HANGS_S):
        await gadget.ready()

    assert decode_rate(ask(gadget, 0xA1, 1, 0x0303)) == Rate(500, running=True)


async def test_the_hid_bar_keeps_its_rate(bar):
    gadget = HidBallbarGadget(electronics(bar))
    gadget.control(SET_RATE, encode_rate(Rate(100, running=True)))
    loop = asyncio.get_running_loop()
    start_s = loop.time()

    for _ in range(11):
        await gadget.ready()
        gadget.take_packet()

    # the first is due at once, the next ten after 10 ms each; a busy machine may be later, never sooner
    assert loop.time() - start_s > 0.099


@pytest.mark.parametrize(
    "report", [encode_rate(Rate(0, True)), encode_rate(Rate(1001, True)), b"", b"\x02" * 4]
)
def test_a_rate_that_is_none_stalls(bar, report):
    gadget = HidBallbarGadget(electronics(bar))

    with pytest.raises(StallError):
        gadget.control(SET_RATE, report)


def test_the_hid_bar_gives_a_reading_on_request_too(bar):
    gadget = HidBallbarGadget(electronics(bar))
    bar.signal = "none"

    reading = decode_reading(ask(gadget, 0xA1, 1, 0x0101))

    assert reading.deviation_mm != reading.deviation_mm
    assert ask(gadget, 0x81, 6, 0x2200) == report_descriptor()


def test_a_cable_that_is_a_keyboard_takes_no_command(bar):
    gadget = UsbItnGadget(electronics(bar))

    with pytest.raises(StallError):
        gadget.control(Setup(0x40, 3, 0, 0, 2), b"1\r")
    assert ask(gadget, 0xC0, 2, length=1) == b"\x00"


def talking(bar) -> UsbItnGadget:
    gadget = UsbItnGadget(electronics(bar))
    gadget.control(Setup(0x40, 1, 0xA5A5), b"")
    return gadget


async def said(gadget: UsbItnGadget, command: bytes) -> bytes:
    gadget.control(Setup(0x40, 3, 0, 0, len(command)), command)
    text = b""
    while not text.endswith(b"\r"):
        async with asyncio.timeout(HANGS_S):
            await gadget.ready()
        packet = gadget.take_packet()
        assert len(packet) <= 8
        text += packet
    return text


@pytest.mark.parametrize(
    ("signal", "deviation_mm", "text"),
    [
        ("good", -0.98765, b"01A-0000.9877\r"),
        ("out_of_range", 1.05, b"01A+0001.0500\r"),
        ("none", 0.0, b"911\r"),
    ],
)
async def test_the_cable_says_what_the_gauge_shows(bar, signal, deviation_mm, text):
    bar.signal, bar.deviation_mm = signal, deviation_mm

    assert await said(talking(bar), b"1\r") == text


async def test_the_cable_says_who_it_is_and_what_it_does_not_know(bar):
    gadget = talking(bar)

    assert await said(gadget, b"V\r") == b"1USB-ITN V1.00\r"
    assert await said(gadget, b"?\r") == b"913\r"


async def test_after_a_reset_it_is_a_keyboard_again_with_nothing_to_say(bar):
    gadget = talking(bar)
    gadget.control(Setup(0x40, 3, 0, 0, 2), b"1\r")

    gadget.attach()

    with pytest.raises(TimeoutError):
        async with asyncio.timeout(0.02):
            await gadget.ready()
    with pytest.raises(StallError):
        gadget.control(Setup(0x40, 3, 0, 0, 2), b"1\r")
