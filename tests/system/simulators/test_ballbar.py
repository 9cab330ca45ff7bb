"""The ballbar of a started cell: put somewhere by the simulated hands, read through every protocol."""

import math

import pytest

from tests.system.simulators.cell_process import started_cell
from truepose_drivers.errors import ConnectFailedError, DeviceRefusedError, LinkError

pytestmark = pytest.mark.usefixtures("forked_processes")

# 5 sigma of the bar's noise (0.51 um), twice since two instruments are compared, and a step of 0.1 um
SAME_MM = 5.0 * math.sqrt(2.0) * 0.00051 + 0.0001
PROTOCOLS = {"nd28x": "heidenhain_nd", "hid": "ballbar_hid", "usb_itn": "mitutoyo_usb_itn"}


@pytest.fixture(params=["0", "1"], ids=["pace 0", "pace 1"])
async def cell(request):
    async with started_cell("lrmate-clean", "--seed", "4", "--pace", request.param) as started:
        yield started


async def connected(cell):
    """Return the hands, and an instrument for each protocol of the ballbar."""
    instruments = [await cell.connected(driver, protocol) for protocol, driver in PROTOCOLS.items()]
    return await cell.connected("cell_hands", "hands"), instruments


async def test_all_protocols_show_the_same_bar(cell):
    hands, instruments = await connected(cell)

    before = [await instrument.read() for instrument in instruments]
    await hands.do("calibrator", {"bars": "tool"})
    on_calibrator = [await instrument.read() for instrument in instruments]
    await hands.do("side", {"artefact": "tool", "a": 1, "b": 2})
    between = [await instrument.read() for instrument in instruments]
    await hands.do("detach", {})
    after = [await instrument.read() for instrument in instruments]

    assert {reading.signal for reading in before} == {"none"}
    assert {reading.signal for reading in after} == {"out_of_range"}
    for readings in (on_calibrator, between):
        assert {reading.signal for reading in readings} == {"good"}
        shown = [reading.deviation_mm for reading in readings]
        assert max(shown) - min(shown) < SAME_MM


async def test_a_pulled_cable_is_a_link_error_in_every_protocol_and_ends_with_the_cable(cell):
    hands, instruments = await connected(cell)
    await hands.do("calibrator", {"bars": "base"})

    await hands.do("pull_cable", {})
    for instrument in instruments:
        with pytest.raises(LinkError):
            for _ in range(50):
                await instrument.read()
        with pytest.raises(ConnectFailedError):
            await instrument.connect()
    await hands.do("plug_cable", {})
    for instrument in instruments:
        await instrument.connect()

    assert {(await instrument.read()).signal for instrument in instruments} == {"good"}


async def test_the_hands_refuse_with_a_sentence_what_cannot_be_done(cell):
    hands = await cell.connected("cell_hands", "hands")

    with pytest.raises(DeviceRefusedError, match="no action"):
        await hands.do("juggle", {})
    with pytest.raises(DeviceRefusedError, match="bars"):
        await hands.do("connect", {"base": 1, "tool": 1})
    with pytest.raises(DeviceRefusedError, match="tool"):
        await hands.do("connect", {"base": 1})

    await hands.do("calibrator", {"bars": "base"})
