"""Which drivers there are, and what a broken or careless one does to the others."""

import tomllib
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from truepose_drivers.api import DriverPlugin
from truepose_drivers.errors import ConfigurationError, DriverFaultError
from truepose_drivers.guard import GuardedBallbar, GuardedGauge, GuardedTracker
from truepose_drivers.leica_emscon.driver import PLUGIN as TRACKER
from truepose_drivers.registry import ENTRY_POINT_GROUP, load_registry

ARTEFACT = Path(__file__).parents[2] / "helpers" / "instruments" / "artefact.rom"
PYPROJECT = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text())
SHIPPED = [
    EntryPoint(name, value, ENTRY_POINT_GROUP)
    for name, value in PYPROJECT["project"]["entry-points"][ENTRY_POINT_GROUP].items()
]
OF_A_NETWORK = {
    "host": "127.0.0.1",
    "port": 5000,
    "logger_port": 5001,
    "log_port": 5001,
    "script_port": 5002,
    "dashboard_port": 5003,
    "tool_file": str(ARTEFACT),
}


class FakeEntryPoint:
    """An entry point of a third party that loads to `candidate`, or raises it."""

    value = "third_party.module:PLUGIN"

    def __init__(self, name: str, candidate: object) -> None:
        self.name = name
        self._candidate = candidate

    def load(self) -> object:
        if isinstance(self._candidate, BaseException):
            raise self._candidate
        return self._candidate


def named(name: str, **changes) -> FakeEntryPoint:
    return FakeEntryPoint(name, replace(TRACKER, name=name, **changes))


def test_every_shipped_driver_loads():
    registry = load_registry(SHIPPED)

    assert registry.broken == {}
    assert registry.names() == tuple(sorted(entry.name for entry in SHIPPED))
    assert registry.names("clock") == ("cell_clock", "monotonic_clock")


def test_what_is_installed_can_be_listed_without_an_argument():
    registry = load_registry()

    assert registry.broken == {}


def test_a_driver_is_opened_by_its_name_and_connects_nothing():
    registry = load_registry(SHIPPED)

    tracker = registry.open("leica_emscon", {"host": "127.0.0.1", "reflector": "RRR"})

    assert isinstance(tracker, GuardedTracker)
    assert not tracker.connected


def test_every_shipped_driver_opens_with_its_own_options():
    registry = load_registry(SHIPPED)

    for name in registry.names():
        options = {
            option: value for option, value in OF_A_NETWORK.items() if option in registry.plugin(name).options
        }
        assert registry.open(name, options) is not None, name


def test_an_unknown_name_lists_the_known_ones():
    registry = load_registry(SHIPPED)

    with pytest.raises(ConfigurationError, match="'leica'; installed drivers: abb_open_abb, abb_rws, ball"):
        registry.open("leica", {})


def test_an_unknown_option_lists_the_known_ones():
    registry = load_registry(SHIPPED)

    with pytest.raises(ConfigurationError, match="no option hots; its options: host, port, reflector"):
        registry.open("leica_emscon", {"hots": "127.0.0.1"})


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({}, "host is None"),
        ({"host": ""}, "host is ''"),
        ({"host": 5}, "host is 5"),
        ({"host": "127.0.0.1", "port": 0}, "port is 0"),
        ({"host": "127.0.0.1", "port": 65_536}, "port is 65536"),
        ({"host": "127.0.0.1", "port": "700"}, "port is '700'"),
        ({"host": "127.0.0.1", "port": True}, "port is True"),
        ({"host": "127.0.0.1", "reflector": 3}, "reflector is 3"),
    ],
)
def test_a_wrong_option_is_named_with_driver_and_remedy(options, complaint):
    registry = load_registry(SHIPPED)

    with pytest.raises(ConfigurationError, match=f"driver leica_emscon: option {complaint}.*give"):
        registry.open("leica_emscon", options)


@pytest.mark.parametrize(
    ("candidate", "reason"),
    [
        (ImportError("no module named serial"), "ImportError: no module named serial"),
        (SystemExit(2), "SystemExit"),
        (42, "int, not a DriverPlugin"),
        (replace(TRACKER, name="other"), "calls itself 'other'"),
        (replace(TRACKER, name="theirs", kind="oven"), "'oven'; known kinds: tracker"),
        (replace(TRACKER, name="theirs", options=["host"]), "not a mapping"),
        (replace(TRACKER, name="theirs", options={"host": 1}), "not a mapping"),
        (replace(TRACKER, name="theirs", open="later"), "cannot be called"),
    ],
)
def test_a_broken_driver_does_not_take_the_others_down(candidate, reason):
    registry = load_registry([FakeEntryPoint("theirs", candidate), named("good")])

    assert registry.names() == ("good",)
    with pytest.raises(ConfigurationError, match=f"'theirs' is installed but cannot be used: .*{reason}"):
        registry.open("theirs", {})


def test_two_drivers_of_one_name_are_both_withdrawn():
    registry = load_registry([named("twin"), named("good"), named("twin"), named("twin")])

    assert registry.names() == ("good",)
    with pytest.raises(ConfigurationError, match="two installed packages"):
        registry.plugin("twin")


def test_a_third_party_driver_needs_nothing_but_the_api():
    class Tracker:
        pass

    plugin = DriverPlugin(
        "theirs", "tracker", "own", {"usb": "serial number"}, lambda options, clock: Tracker()
    )
    registry = load_registry([FakeEntryPoint("theirs", plugin)])

    assert isinstance(registry.open("theirs", {"usb": "A1"}), GuardedTracker)


def test_a_driver_that_fails_while_it_is_opened_is_named():
    def stumble(options, clock):
        raise KeyError("usb")

    registry = load_registry([named("theirs", open=stumble)])

    with pytest.raises(DriverFaultError, match=r"driver theirs failed in open.*KeyError"):
        registry.open("theirs", {})


def test_a_device_that_can_be_two_things_is_used_as_the_cell_file_says():
    registry = load_registry(SHIPPED)
    place = {"host": "127.0.0.1", "port": 5000}

    assert registry.kind("heidenhain_nd") == "ballbar"
    assert registry.kind("heidenhain_nd", "linear_gauge") == "linear_gauge"
    assert isinstance(registry.open("heidenhain_nd", place), GuardedBallbar)
    assert isinstance(registry.open("heidenhain_nd", place, use="linear_gauge"), GuardedGauge)
    assert isinstance(registry.open("keyence_gt2", place), GuardedGauge)
    assert {"heidenhain_nd", "keyence_gt2", "ballbar_bridge"} <= set(registry.names("linear_gauge"))


def test_a_device_is_not_used_as_what_it_cannot_be():
    registry = load_registry(SHIPPED)

    with pytest.raises(ConfigurationError, match=r"heidenhain_nd.*'tracker'.*ballbar or linear_gauge"):
        registry.open("heidenhain_nd", {"host": "127.0.0.1", "port": 5000}, use="tracker")


def test_a_driver_that_may_be_used_as_an_unknown_kind_is_broken():
    registry = load_registry([named("acme", also=("toaster",))])

    assert "toaster" in registry.broken["acme"]
