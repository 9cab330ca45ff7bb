"""The ballbar bridge: its lines, and listening to them."""

import asyncio
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.ballbar_bridge.driver import BridgedBallbar
from truepose_drivers.ballbar_bridge.protocol import BridgeReading, Hello, decode, encode
from truepose_drivers.errors import NoReplyError
from truepose_drivers.framing import JsonLineError
from truepose_drivers.monotonic_clock import MonotonicClock

pytestmark = pytest.mark.simulated_time

finite = st.floats(-1000.0, 1000.0)


def test_lines_have_the_published_form():
    reading = BridgeReading(0.1234, "good", 20.1, 17)

    assert encode(reading) == (
        b'{"deviation_mm": 0.1234, "signal": "good", "temperature_c": 20.1, "sequence": 17}\n'
    )
    assert encode(BridgeReading(math.nan, "none")).startswith(b'{"deviation_mm": null, "signal": "none"')


@given(
    message=st.one_of(
        st.builds(
            BridgeReading,
            finite,
            st.sampled_from(["good", "out_of_range"]),
            st.none() | finite,
            st.none() | st.integers(-(2**63) + 1, 2**63 - 1),
        ),
        st.builds(Hello, st.text(), st.text(), st.floats(1e-9, 1.0)),
    )
)
def test_messages_make_the_round_trip(message):
    assert decode(encode(message)) == message


def test_a_bare_number_is_enough():
    assert decode(b'{"deviation_mm": -0.5, "battery": 77}') == BridgeReading(-0.5, "good")


@pytest.mark.parametrize("line", [b'{"deviation_mm": null}', b'{"deviation_mm": 0.3, "signal": "none"}'])
def test_without_a_signal_there_is_no_value(line):
    reading = decode(line)

    assert reading.signal == "none"
    assert math.isnan(reading.deviation_mm)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (b"0.1234", "JSON object"),
        (b'{"deviation": 0.1}', "deviation_mm"),
        (b'{"deviation_mm": "0.1"}', "number"),
        (b'{"deviation_mm": NaN}', "number"),
        (b'{"deviation_mm": true}', "number"),
        (b'{"deviation_mm": 1%s}' % (b"0" * 400), "number"),
        (b'{"deviation_mm": 123456}', "millimetres"),
        (b'{"deviation_mm": 0.1, "signal": "ok"}', "out_of_range"),
        (b'{"deviation_mm": null, "signal": "good"}', "has a value"),
        (b'{"deviation_mm": null, "signal": "out_of_range"}', "signal is out_of_range and.*has a value"),
        (b'{"deviation_mm": 0.1, "sequence": 1.5}', "sequence"),
        (b'{"deviation_mm": 0.1, "temperature_c": "20"}', "temperature_c"),
        (b'{"model": 5}', "model"),
        (b'{"resolution_mm": 0}', "positive"),
        (b'{"resolution_mm": 1e300}', "positive"),
        (b'{"range_mm": -1}', "positive"),
        (b'{"unit": "inch"}', "millimetres"),
        (b'{"deviation_mm": 0.1, "unit": "in"}', "millimetres"),
        (b'{"deviation_mm": 0.1, "deviation_mm": 0.2}', "twice"),
        (b'{"deviation_mm": -Infinity}', "number"),
        (b'{"deviation_mm": 0.1, "sequence": 9223372036854775808}', "count of values"),
    ],
)
def test_a_line_that_is_none_is_refused_with_what_belongs_there(line, said):
    with pytest.raises(JsonLineError, match=said):
        decode(line)


class FakeBridge:
    """Sends what the test puts into its queue, as it comes; None hangs up."""

    def __init__(self) -> None:
        self.lines: asyncio.Queue[bytes | None] = asyncio.Queue()

    def send(self, *deviations_mm: float) -> None:
        for deviation_mm in deviations_mm:
            self.lines.put_nowait(encode(BridgeReading(deviation_mm, "good")))

    async def serve(self, end: MemoryEnd) -> None:
        while (line := await self.lines.get()) is not None:
            await end.send(line)

    async def connected(self, chunk_bytes: int = 65_536, value_timeout_s: float = 0.1) -> BridgedBallbar:
        link = MemoryLink(self.serve, chunk_bytes=chunk_bytes)
        driver = BridgedBallbar(link, MonotonicClock(), value_timeout_s=value_timeout_s)
        await driver.connect()
        return driver


@pytest.mark.parametrize("chunk_bytes", [1, 65_536])
async def test_only_a_value_that_comes_after_the_question_answers_it(chunk_bytes):
    bridge = FakeBridge()
    bridge.send(0.1)
    driver = await bridge.connected(chunk_bytes)
    bridge.send(0.2, 0.3, 0.4)
    await asyncio.sleep(0.01)  # they have arrived

    asyncio.get_running_loop().call_later(0.02, bridge.send, 0.5)

    assert (await driver.read()).deviation_mm == 0.5
    await driver.close()


async def test_an_old_value_is_never_given_again():
    bridge = FakeBridge()
    bridge.send(0.1)
    driver = await bridge.connected()
    bridge.send(0.2)
    await asyncio.sleep(0.01)

    with pytest.raises(NoReplyError, match="check that the manufacturer's software"):
        await driver.read()
    assert not driver.connected


async def test_the_bridge_may_say_whose_values_they_are():
    bridge = FakeBridge()
    bridge.lines.put_nowait(encode(Hello("QC20-W", "12A345", 0.0005)))
    bridge.send(0.1, 0.2)
    driver = await bridge.connected()

    identity = await driver.identify()
    asyncio.get_running_loop().call_later(0.01, bridge.send, 0.3)

    assert (identity.model, identity.serial) == ("QC20-W", "12A345")
    assert (await driver.read()).resolution_mm == 0.0005
    await driver.close()


async def test_of_values_that_come_at_once_the_newest_counts():
    bridge = FakeBridge()
    bridge.send(0.1)
    driver = await bridge.connected(value_timeout_s=20.0)
    stalled = b"".join(encode(BridgeReading(deviation_mm, "good")) for deviation_mm in (0.2, 0.3, 0.4))

    asyncio.get_running_loop().call_later(0.01, bridge.lines.put_nowait, stalled)

    assert (await driver.read()).deviation_mm == 0.4
    await driver.close()


async def test_a_value_beyond_the_range_that_the_bridge_states_is_told():
    bridge = FakeBridge()
    bridge.lines.put_nowait(encode(Hello("QC20-W", "12A345", 1e-4, 1.1)))
    bridge.send(0.1)
    driver = await bridge.connected()

    asyncio.get_running_loop().call_later(0.01, bridge.send, 123.4)  # micrometres

    with pytest.raises(JsonLineError, match="are these millimetres"):
        await driver.read()
    assert not driver.connected
