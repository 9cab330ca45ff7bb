"""A device that is exchanged while nobody looks answers as another one, as soon as it can be known."""

import pytest

from tests.contract.benches import registry
from truepose_simulators.faults.kinds import IdentityChanged

WITHOUT_LOSS = {
    "leica_emscon": "777777",
    "abb_open_abb": "120-7",
    "abb_rws": "120-8",
    "fanuc_mappdk": "F-7",
    "universal_robots": "UR-10-7",
    "kuka_variable_proxy": "482916",
    "ballbar_hid": "BAR-9",
    "ndi_polaris": "P9-77777",
}
AFTER_A_RECONNECTION = {**WITHOUT_LOSS, "mitutoyo_usb_itn": "70099999"}


async def identified(bench, name, serial):
    """Return a driver that has met its device, whose exchange has just been scripted, and what it met."""
    driver = bench.driver(name)
    await driver.connect()
    first = (await driver.identify()).serial
    bench.cell.add_fault(IdentityChanged(registry().plugin(name).kind, serial))
    return driver, first


@pytest.mark.parametrize(("name", "serial"), WITHOUT_LOSS.items())
async def test_an_exchange_behind_a_link_that_stays_up_is_told(bench, name, serial):
    driver, first = await identified(bench, name, serial)

    again = (await driver.identify()).serial

    assert first != serial
    assert again == serial
    assert driver.connected


@pytest.mark.parametrize(("name", "serial"), AFTER_A_RECONNECTION.items())
async def test_an_exchange_is_told_after_a_reconnection(bench, name, serial):
    driver, first = await identified(bench, name, serial)

    await bench.hang_up(name)
    await driver.close()
    await driver.connect()

    assert first != serial
    assert (await driver.identify()).serial == serial
