"""Boxes of several gauges against their simulated counterparts, and what cell files may say of them."""

import asyncio
import contextlib
import math
import os

import pytest

from tests.contract.benches import in_memory
from tests.helpers.ballbar.length_sources import FakeBar, electronics
from tests.helpers.instruments.memory_link import MemoryLink
from tests.helpers.machine import PSEUDO_TERMINALS
from truepose_drivers.errors import ConfigurationError, ConnectFailedError, DriverError, RemoteProtocolError
from truepose_drivers.keyence_gt2.driver import PLUGIN as KEYENCE
from truepose_drivers.keyence_gt2.driver import KeyenceUnit
from truepose_drivers.line_gauges.conversation import GaugeSettings, LineGauges, gauge_settings
from truepose_drivers.mitutoyo_eh.driver import PLUGIN as EH
from truepose_drivers.mitutoyo_eh.driver import EhCounter
from truepose_drivers.mitutoyo_eh.protocol import ENDS, Question
from truepose_drivers.mitutoyo_serial.driver import PLUGIN as SERIAL
from truepose_drivers.mitutoyo_serial.driver import MitutoyoBox
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_simulators.faults.kinds import BallbarInches
from truepose_simulators.faults.scripted import Faults
from truepose_simulators.instruments.gauges.text_boxes import (
    Counter,
    keyence_gt2_endpoint,
    mitutoyo_eh_endpoint,
    mitutoyo_serial_endpoint,
)

BOXES = {
    "keyence_gt2": (keyence_gt2_endpoint, KeyenceUnit),
    "mitutoyo_eh": (mitutoyo_eh_endpoint, EhCounter),
    "mitutoyo_serial": (mitutoyo_serial_endpoint, MitutoyoBox),
}
boxes = pytest.mark.parametrize("name", BOXES)


@pytest.fixture
def bars():
    made = [FakeBar() for _ in range(3)]
    for bar, deviation_mm in zip(made, (0.1, -0.2, 2.3), strict=True):
        bar.deviation_mm = deviation_mm
    return made


async def connected(name, bars, **settings):
    endpoint, dialect = BOXES[name]
    served = endpoint([electronics(bar) for bar in bars])
    settings = GaugeSettings(**settings)
    gauges = LineGauges(MemoryLink(in_memory(served, [])), MonotonicClock(), dialect(), settings)
    await gauges.connect()
    return gauges


@boxes
async def test_each_channel_is_a_gauge(name, bars):
    gauges = await connected(name, bars, channels=(3, 1, 2))

    readings = await gauges.read_channels()

    assert [reading.deviation_mm for reading in readings] == pytest.approx([2.3, 0.1, -0.2], abs=1e-12)
    assert (await gauges.read()).deviation_mm == pytest.approx(2.3, abs=1e-12)


@boxes
async def test_a_gauge_that_counts_outwards_is_turned_round(name, bars):
    gauges = await connected(name, bars, channels=(1, 2), reversed=True)

    assert [one.deviation_mm for one in await gauges.read_channels()] == pytest.approx([-0.1, 0.2], abs=1e-12)


@boxes
async def test_beyond_its_range_a_gauge_is_out_of_range_and_the_others_are_not(name, bars):
    gauges = await connected(name, bars, channels=(1, 2, 3), range_mm=2.0)

    assert [one.signal for one in await gauges.read_channels()] == ["good", "good", "out_of_range"]


@boxes
async def test_one_gauge_without_a_signal_leaves_the_others_theirs(name, bars):
    gauges = await connected(name, bars, channels=(1, 2, 3))
    bars[1].signal = "none"

    readings = await gauges.read_channels()

    assert [one.signal for one in readings] == ["good", "none", "good"]
    assert math.isnan(readings[1].deviation_mm)


@boxes
async def test_a_channel_that_is_not_there_has_no_value(name, bars):
    with contextlib.suppress(DriverError):  # a unit that knows how many it has says so
        gauges = await connected(name, bars[:1], channels=(1, 2))
        assert (await gauges.read_channels())[1].signal == "none"


@pytest.mark.parametrize("end", ENDS)
async def test_the_end_of_a_line_is_as_the_counter_is_set(end, bars):
    endpoint = mitutoyo_eh_endpoint([electronics(bars[0])], end=end)
    gauges = LineGauges(
        MemoryLink(in_memory(endpoint, [])), MonotonicClock(), EhCounter(ENDS[end]), GaugeSettings()
    )
    await gauges.connect()

    assert (await gauges.read()).deviation_mm == pytest.approx(0.1, abs=1e-12)


def test_a_zero_that_was_set_in_one_unit_holds_in_the_other(bars):
    faults = Faults()
    counter = Counter([electronics(bars[0], faults)])
    counter.reply(Question("CR", 1))
    bars[0].deviation_mm += 2.54

    in_millimetres = counter.reply(Question("GA", 1)).value
    faults.add(BallbarInches())
    in_inches = counter.reply(Question("GA", 1)).value

    assert (in_millimetres.shown, in_millimetres.decimals) == (pytest.approx(2.54), 4)
    assert (in_inches.shown, in_inches.decimals) == (pytest.approx(0.1), 5)


async def answering(answers, dialect):
    """Return gauges whose box answers each question with the next of `answers`."""

    async def serve(end):
        while await end.receive():
            end.write(answers.pop(0))

    gauges = LineGauges(MemoryLink(serve), MonotonicClock(), dialect, GaugeSettings(decimals=3))
    await gauges.connect()
    return gauges


@pytest.mark.parametrize(
    ("dialect", "first", "foreign"),
    [
        (MitutoyoBox(), b"01A+0000.123\r", b"02A+0000.123\r"),
        (EhCounter(), b"GN01,+0000.123\r\n", b"GN02,+0000.123\r\n"),
        (EhCounter(), b"GN01,+0000.123\r\n", b"GX01,+0000.123\r\n"),
        (EhCounter(), b"GN01,+0000.123\r\n", b"CH01\r\n"),
        (KeyenceUnit(), b"MS,04,+00000.123\r\n", b"M0,+00000.123\r\n"),
    ],
)
async def test_the_answer_to_another_question_is_no_reading_and_closes(dialect, first, foreign):
    gauges = await answering([first, foreign, foreign], dialect)

    with pytest.raises(RemoteProtocolError):
        await gauges.read()
    assert not gauges.connected


@pytest.mark.simulated_time
async def test_an_answer_that_came_too_late_is_not_taken_after_connecting_again():
    late, asked = asyncio.Event(), []

    async def serve(end):
        while question := await end.receive():
            asked.append(question)
            if len(asked) == 2:  # the reading, whose answer only comes on the next connection
                late.set()
                continue
            end.write(b"01A+0000.222\r")

    async def serve_again(end):
        if late.is_set():
            late.clear()
            asyncio.get_running_loop().call_later(0.2, end.write, b"01A+0009.999\r")
        await serve(end)

    gauges = LineGauges(MemoryLink(serve_again), MonotonicClock(), MitutoyoBox(), GaugeSettings())
    await gauges.connect()
    with pytest.raises(DriverError, match="does not respond"):
        await gauges.read()

    await gauges.connect()

    assert (await gauges.read()).deviation_mm == 0.222


@PSEUDO_TERMINALS
async def test_a_box_on_a_serial_port_is_read():
    import tty  # not on Windows

    master, slave = os.openpty()
    tty.setraw(slave)
    driver = SERIAL.open({"serial": os.ttyname(slave), "channels": "1 2"}, MonotonicClock())
    loop = asyncio.get_running_loop()

    def answer():
        for digit in os.read(master, 100).split(b"\r")[:-1]:
            os.write(master, b"0%sA+0000.%s23\r" % (digit, digit))

    loop.add_reader(master, answer)
    try:
        await driver.connect()
        assert [one.deviation_mm for one in await driver.read_channels()] == [0.123, 0.223]
    finally:
        await driver.close()
        loop.remove_reader(master)
        os.close(master)
        os.close(slave)


async def test_nobody_on_the_line_is_told_when_connecting():
    with pytest.raises(ConnectFailedError, match="no response"):
        await LineGauges(MemoryLink(None), MonotonicClock(), MitutoyoBox(), GaugeSettings()).connect()


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"channels": "1 1"}, "different numbers"),
        ({"channels": "0"}, "different numbers"),
        ({"channels": "one"}, "different numbers"),
        ({"channels": "10"}, "different numbers from 1 to 9"),
        ({"reversed": "yes"}, "true or false"),
        ({"decimals": 7}, "from 0 to 6"),
        ({"range_mm": 0.0}, "positive"),
    ],
)
def test_options_that_cannot_be_are_told(options, sentence):
    with pytest.raises(ConfigurationError, match=sentence):
        gauge_settings(options, most_channels=9)


def test_a_box_is_reached_one_way():
    with pytest.raises(ConfigurationError, match="only one of them"):
        SERIAL.open({"serial": "/dev/ttyUSB0", "host": "127.0.0.1"}, None)
    with pytest.raises(ConfigurationError, match="baud"):
        SERIAL.open({"serial": "/dev/ttyUSB0", "baud": 9601}, None)
    with pytest.raises(ConfigurationError, match="terminator"):
        EH.open({"host": "127.0.0.1", "terminator": "ETX"}, None)


def test_a_keyence_unit_listens_where_it_is_delivered():
    assert KEYENCE.open({"host": "10.0.0.9"}, None)._link.address == "10.0.0.9:64000"
