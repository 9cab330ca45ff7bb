"""What a ballbar driver promises, against the simulated instrument."""

import math

import pytest

from tests.contract.benches import registry
from truepose_drivers.errors import ConnectFailedError, LinkError
from truepose_simulators.faults.kinds import BallbarTooFast

ballbars = pytest.mark.parametrize("name", registry().names("ballbar"))


async def ready(bench, name):
    ballbar = bench.driver(name)
    await ballbar.connect()
    return ballbar


@pytest.fixture(params=registry().names("ballbar"))
async def ballbar(bench, request):
    return await ready(bench, request.param)


@pytest.mark.parametrize("deviation_mm", [0.0, 0.4321, -0.9876, 1.0])
async def test_a_length_is_read_as_the_bar_shows_it(bench, ballbar, deviation_mm):
    bench.bar.deviation_mm = deviation_mm

    reading = await ballbar.read()

    # half a step of the protocol, and doubles
    assert reading.deviation_mm == pytest.approx(deviation_mm, abs=0.5 * reading.resolution_mm + 1e-12)
    assert reading.signal == "good"
    assert 0.0 < reading.resolution_mm <= 0.001


async def test_a_reading_is_fresh_however_long_nobody_asked(bench, ballbar):
    await ballbar.read()

    for deviation_mm in (0.5, -0.5, 0.25):
        bench.bar.deviation_mm = deviation_mm
        reading = await ballbar.read()

        assert reading.deviation_mm == pytest.approx(deviation_mm, abs=0.5 * reading.resolution_mm + 1e-12)


@ballbars
async def test_a_reading_is_stamped_by_the_cells_clock(bench, name):
    bench.clock = bench.driver("cell_clock")
    ballbar = await ready(bench, name)
    await bench.clock.sleep(100.0)

    first = await ballbar.read()
    await bench.clock.sleep(2.5)
    second = await ballbar.read()

    assert first.time_s == pytest.approx(100.0)
    assert second.time_s - first.time_s == pytest.approx(2.5)


@pytest.mark.parametrize("deviation_mm", [1.05, -1.05])
async def test_a_bar_at_its_stop_is_out_of_range(bench, ballbar, deviation_mm):
    bench.bar.deviation_mm, bench.bar.signal = deviation_mm, "out_of_range"

    reading = await ballbar.read()

    assert reading.signal == "out_of_range"
    assert reading.deviation_mm == pytest.approx(deviation_mm, abs=0.001)


async def test_without_a_signal_there_is_no_length(bench, ballbar):
    bench.bar.signal = "none"

    reading = await ballbar.read()
    bench.bar.signal = "good"
    afterwards = await ballbar.read()

    assert reading.signal == "none"
    assert math.isnan(reading.deviation_mm)
    assert afterwards.signal == "good"


@ballbars
async def test_a_bar_that_was_moved_too_fast_has_no_length(bench, name):
    if name == "ballbar_bridge":
        pytest.skip("a bridge knows three signals and no reasons")
    ballbar = await ready(bench, name)
    now_s = bench.cell.clock.now_s
    bench.cell.faults.add(BallbarTooFast(from_s=now_s, until_s=now_s + 1.0))

    too_fast = await ballbar.read()
    await bench.cell.clock.sleep(1.0)
    afterwards = await ballbar.read()

    assert (too_fast.signal, afterwards.signal) == ("none", "good")
    assert math.isnan(too_fast.deviation_mm)


async def test_sequence_numbers_grow_where_there_are_any(ballbar):
    numbers = [(await ballbar.read()).sequence for _ in range(5)]

    assert numbers == [None] * 5 or numbers == sorted(set(numbers))


@pytest.mark.parametrize("name", ["ballbar_hid", "mitutoyo_usb_itn"])
async def test_a_pulled_cable_is_a_link_error_and_reading_goes_on_after_it(bench, name):
    ballbar = await ready(bench, name)
    await ballbar.read()

    bench.bar.plugged = False
    with pytest.raises(LinkError, match="check"):
        for _ in range(100):
            await ballbar.read()
    assert not ballbar.connected
    with pytest.raises(ConnectFailedError, match="check"):
        await ballbar.connect()
    bench.bar.plugged = True
    await ballbar.connect()

    assert (await ballbar.read()).signal == "good"
