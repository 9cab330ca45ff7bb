"""What every registered driver promises, whatever its device."""

import inspect
import socket

import pytest

from tests.contract.benches import LINKS, NEEDED, ON_SEVERAL_LINKS, USB_PORTS, WITHOUT_A_DEVICE, registry
from truepose_drivers.api import (
    Ballbar,
    LinearGauge,
    PointTracker,
    PoseTracker,
    RobotController,
    SimulatedHands,
)
from truepose_drivers.errors import ConnectFailedError, DriverError, LinkError

DEVICES = sorted(name for name in registry().names() if registry().plugin(name).kind != "clock")
PORTED = sorted(name for name in registry().names() if "port" in registry().plugin(name).options)
PROTOCOLS = {
    "tracker": PointTracker,
    "robot": RobotController,
    "ballbar": Ballbar,
    "linear_gauge": LinearGauge,
    "hands": SimulatedHands,
    "pose_tracker": PoseTracker,
}
ARGUMENTS = {
    "find_reflector": {"near_mm": (1000.0, 0.0, 0.0), "search_radius_mm": 5.0},
    "measure_point": {"duration_s": 0.1},
    "measure_pose": {"duration_s": 0.1},
    "set_limits": None,
    "move_joints": {"target_rad": (0.0,) * 6},
    "read": {},
    "do": {"action": "detach", "details": {}},
}


def test_every_registered_driver_has_a_bench():
    assert set(registry().names()) == LINKS.keys() | USB_PORTS.keys() | ON_SEVERAL_LINKS | WITHOUT_A_DEVICE
    assert registry().broken == {}


@pytest.mark.parametrize("name", sorted(registry().names()))
def test_every_option_has_a_sentence(name):
    assert all(len(sentence.split()) > 2 for sentence in registry().plugin(name).options.values())


@pytest.mark.parametrize("name", DEVICES)
def test_a_driver_offers_all_of_its_kind(name):
    plugin = registry().plugin(name)
    protocol = PROTOCOLS[plugin.kind]

    driver = plugin.open({"host": "127.0.0.1", "port": 4001, **NEEDED.get(name, {})}, None)

    missing = [
        member
        for member in dir(protocol)
        if not member.startswith("_")
        and (
            not hasattr(type(driver), member)
            or inspect.iscoroutinefunction(getattr(protocol, member))
            != inspect.iscoroutinefunction(getattr(type(driver), member))
        )
    ]
    assert missing == []


@pytest.mark.parametrize("name", DEVICES)
async def test_a_driver_connects_identifies_and_closes(bench, name):
    driver = bench.driver(name)
    assert not driver.connected

    await driver.connect()
    identity = await driver.identify()

    assert driver.connected
    assert all([identity.manufacturer, identity.model, identity.serial, identity.firmware])
    await driver.close()
    await driver.close()
    assert not driver.connected


@pytest.mark.parametrize("name", DEVICES)
async def test_connecting_again_gives_a_fresh_connection(bench, name):
    driver = bench.driver(name)

    for _ in range(3):
        await driver.connect()
        await driver.identify()

    assert driver.connected


@pytest.mark.parametrize("name", DEVICES)
async def test_nothing_is_done_without_a_connection(bench, name):
    driver = bench.driver(name)
    actions = [member for member in ARGUMENTS if hasattr(driver, member) and ARGUMENTS[member] is not None]
    assert actions

    for action in actions:
        with pytest.raises(DriverError, match=r"connect"):
            await getattr(driver, action)(**ARGUMENTS[action])
    with pytest.raises(LinkError, match="connect first"):
        await driver.identify()


@pytest.mark.parametrize("name", PORTED)
async def test_nobody_at_the_address_is_said_with_address_and_remedy(name):
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        port = silent.getsockname()[1]
        driver = registry().open(name, {"host": "127.0.0.1", "port": port, **NEEDED.get(name, {})})
        ask = driver.now_s if registry().plugin(name).kind == "clock" else driver.connect

        with pytest.raises(ConnectFailedError, match=rf"127\.0\.0\.1:{port}.*check"):
            await ask()


@pytest.mark.parametrize("name", DEVICES)
async def test_a_device_that_goes_away_is_a_link_error_and_comes_back(bench, name):
    driver = bench.driver(name)
    await driver.connect()
    await driver.identify()

    await bench.hang_up(name)
    with pytest.raises(LinkError):
        await driver.identify()
    assert not driver.connected
    await driver.connect()

    assert (await driver.identify()).manufacturer
