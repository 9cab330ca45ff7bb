"""The counter's conversation, against a scripted counter that lives in memory."""

import asyncio
import math

import pytest

from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.errors import (
    ConfigurationError,
    NoReplyError,
    RemoteProtocolError,
)
from truepose_drivers.heidenhain_nd.driver import PLUGIN, HeidenhainCounter
from truepose_drivers.heidenhain_nd.protocol import (
    Command,
    Lamps,
    Line,
    Refusal,
    RequestReader,
    encode_reply,
    error_line,
    identity_lines,
    lamps_line,
    value_line,
)
from truepose_drivers.monotonic_clock import MonotonicClock

pytestmark = pytest.mark.simulated_time

STALL = object()
PATIENCE_S = 0.1  # the fake answers at once or never
PRINTING_S = 0.001


class FakeCounter:
    """Answers each command by what the test put there; by nothing where there is None."""

    def __init__(self, **answers) -> None:
        self.answers = {
            "A0000": identity_lines("ND-287", "349797-04", "2001-05-04"),
            "A0301": [Refusal()],
            "A0200": [value_line(1234)],
            "A0800": [lamps_line(Lamps(inside=True))],
            **answers,
        }
        self.said_by_itself = b""
        self.prints_all_the_time = False

    async def serve(self, end: MemoryEnd) -> None:
        reader = RequestReader()
        while data := await end.receive():
            end.write(self.said_by_itself)
            reader.receive_data(data)
            while (request := reader.next_message()) is not None:
                assert isinstance(request, Command)
                await self._answer(end, self.answers[request.code])
            while self.prints_all_the_time:
                await end.send(b"+    9.9999  =\r\n")
                await asyncio.sleep(PRINTING_S)

    async def _answer(self, end: MemoryEnd, answers) -> None:
        for reply in (answers() if callable(answers) else answers) or ():
            if reply is STALL:
                await asyncio.sleep(PATIENCE_S / 2)
            else:
                await end.send(reply if isinstance(reply, bytes) else encode_reply(reply))

    async def connected(self, chunk_bytes: int = 65_536) -> HeidenhainCounter:
        link = MemoryLink(self.serve, chunk_bytes=chunk_bytes)
        driver = HeidenhainCounter(link, MonotonicClock(), reply_timeout_s=PATIENCE_S)
        await driver.connect()
        return driver


@pytest.fixture
def counter():
    return FakeCounter()


@pytest.fixture
async def driver(counter):
    driver = await counter.connected()
    yield driver
    await driver.close()


@pytest.mark.parametrize("chunk_bytes", [1, 5, 65_536])
async def test_a_value_is_read_whatever_the_line_does_to_it(chunk_bytes):
    driver = await FakeCounter().connected(chunk_bytes)

    reading = await driver.read()

    assert (reading.deviation_mm, reading.signal, reading.resolution_mm) == (0.1234, "good", 1e-4)
    await driver.close()


async def test_inches_are_converted():
    driver = await FakeCounter(A0800=[lamps_line(Lamps(inch=True))]).connected()

    reading = await driver.read()

    assert reading.deviation_mm == pytest.approx(0.01234 * 25.4, rel=1e-14)
    assert reading.resolution_mm == pytest.approx(1e-5 * 25.4, rel=1e-14)
    await driver.close()


@pytest.mark.parametrize("lamps", [Lamps(below=True), Lamps(above=True)])
async def test_what_the_counter_sorts_out_is_out_of_range(lamps):
    driver = await FakeCounter(A0800=[lamps_line(lamps)]).connected()

    assert (await driver.read()).signal == "out_of_range"
    await driver.close()


@pytest.mark.parametrize(
    "error",
    [[Refusal()], None, [], [error_line("")], [Line(" " * 33)]],
    ids=["refused", "ignored", "empty", "blank", "36 blank bytes"],
)
async def test_without_an_error_the_question_for_it_may_be_refused_ignored_or_blank(error):
    driver = await FakeCounter(A0301=error).connected()

    assert (await driver.read()).signal == "good"
    await driver.close()


@pytest.mark.parametrize(
    "value", [[value_line(1234)], [Refusal()], None], ids=["frozen", "refused", "silent"]
)
@pytest.mark.parametrize("width", [13, 33])
async def test_a_displayed_error_is_never_a_length(value, width):
    error = Line("SIGNAL ERROR".ljust(width))
    driver = await FakeCounter(A0301=[error], A0200=value).connected()

    reading = await driver.read()

    assert reading.signal == "none"
    assert math.isnan(reading.deviation_mm)
    await driver.close()


async def test_a_refused_value_is_no_length_either():
    driver = await FakeCounter(A0200=[Refusal()]).connected()

    assert (await driver.read()).signal == "none"
    await driver.close()


async def test_a_counter_without_status_indicators_is_said_to_be_another():
    with pytest.raises(RemoteProtocolError, match="not an ND"):
        await FakeCounter(A0800=[Refusal()]).connected()


async def test_what_the_person_prints_at_the_counter_is_ignored(counter, driver):
    counter.said_by_itself = b"+    9.9999  =\r\n"

    readings = [await driver.read() for _ in range(3)]

    assert [reading.deviation_mm for reading in readings] == [0.1234] * 3


@pytest.mark.parametrize(
    "value",
    [
        b"\x02+0000012234\r\n",  # a digit twice
        b"\x02+00001234\r\n",  # a digit lost
        b"\x02+0000\x0001234\r\n",
        b"\x02+00000123\xb4\r\n",
        b"\x020000001234\r\n",
        b"\x06",
        b"\x02+000001234\r\n\x02+000001234\r\n",
        b"\x02+000001234\r\n\x02SIGNAL ERROR \r\n",
        b"\x02SIGNAL ERROR \r\n\x02SIGNAL ERROR \r\n",
    ],
    ids=repr,
)
async def test_a_line_that_is_not_whole_is_no_value_and_closes_the_link(counter, driver, value):
    counter.answers["A0200"] = [value]

    with pytest.raises(RemoteProtocolError):
        await driver.read()
    assert not driver.connected


async def test_answers_to_an_earlier_question_before_those_to_this_one_are_no_reading(counter, driver):
    earlier = [Refusal(), value_line(9999), lamps_line(Lamps(inside=True))]
    counter.answers["A0301"] = [b"".join(map(encode_reply, [*earlier, Refusal(), value_line(1234)]))]
    counter.answers |= {"A0200": None}

    with pytest.raises(RemoteProtocolError, match="late reply"):
        await driver.read()
    assert not driver.connected


async def test_replies_that_were_late_are_passed_over_when_connecting():
    late = [value_line(9999), lamps_line(Lamps(inch=True)), Refusal(), *identity_lines("ND-1", "2", "3")[:2]]
    counter = FakeCounter(A0000=[*late, *identity_lines("ND-287", "349797-04", "2001-05-04")])
    driver = await counter.connected()

    assert (await driver.identify()).model == "ND-287"
    assert (await driver.read()).deviation_mm == 0.1234
    await driver.close()


async def test_a_unit_that_was_changed_between_value_and_indicators_is_asked_for_again(counter, driver):
    counter.answers["A0800"] = [lamps_line(Lamps(inch=True))]
    shown = [value_line(1234), value_line(486)]  # the key was pressed after the first one
    counter.answers["A0200"] = lambda: [shown.pop(0)]

    assert (await driver.read()).deviation_mm == pytest.approx(0.00486 * 25.4)


async def test_a_unit_that_goes_on_changing_is_no_reading(counter, driver):
    inches = [True, False]
    counter.answers["A0800"] = lambda: [lamps_line(Lamps(inch=inches.pop(0)))]

    with pytest.raises(RemoteProtocolError, match="keeps changing"):
        await driver.read()
    assert not driver.connected


async def test_a_counter_that_prints_and_answers_nothing_says_nothing(counter, driver):
    counter.answers |= {"A0301": None, "A0200": None, "A0800": None}
    counter.prints_all_the_time = True

    with pytest.raises(NoReplyError):
        await driver.read()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({}, "host"),
        ({"serial": "/dev/ttyUSB0", "host": "127.0.0.1", "port": 4001}, "one of them"),
        ({"serial": "/dev/ttyUSB0", "baud": 9601}, "9600"),
        ({"serial": "/dev/ttyUSB0", "baud": True}, "9600"),
        ({"serial": 3}, "serial"),
    ],
)
def test_an_option_that_does_not_fit_is_named(options, said):
    with pytest.raises(ConfigurationError, match=said):
        PLUGIN.open(options, None)


async def test_a_slow_line_is_given_the_time_that_it_needs():
    driver = PLUGIN.open({"serial": "loop://", "baud": 110}, None)

    # 90 characters of 11 bits at 110 baud take 9 s; the loop answers with what was asked, which is no reply
    assert driver._reply_timeout_s == pytest.approx(10.0)
