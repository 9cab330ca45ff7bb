"""Options of a cell file that say what an arm is like, of every driver that has them."""

import pytest

from truepose_drivers.errors import ConfigurationError
from truepose_drivers.fanuc_mappdk.driver import PLUGIN as MAPPDK
from truepose_drivers.fanuc_rmi.driver import PLUGIN as RMI
from truepose_drivers.kuka_variable_proxy.driver import PLUGIN as KUKA
from truepose_drivers.monotonic_clock import MonotonicClock

OF_ALL = [
    ("signs", "1 1 -1"),
    ("signs", "1 1 -1 -1 -1 0"),
    ("signs", "1 1 1 1 1 2"),
    ("signs", "1 1 x -1 -1 -1"),
    ("joint_speeds_deg_s", "0 1 1 1 1 1"),
    ("joint_speeds_deg_s", 350),
    ("reach_mm", -1.0),
    ("port", 0),
]


@pytest.mark.parametrize(
    ("plugin", "name", "value"),
    [
        *((plugin, name, value) for plugin in (MAPPDK, RMI, KUKA) for name, value in OF_ALL),
        (MAPPDK, "joint_3_from", "the floor"),
        (RMI, "joint_3_from", "the floor"),
        (MAPPDK, "logger_port", 0),
    ],
)
def test_an_option_that_makes_no_sense_is_refused_by_name(plugin, name, value):
    with pytest.raises(ConfigurationError, match=f"option {name} "):
        plugin.open({"host": "127.0.0.1", name: value}, MonotonicClock())


@pytest.mark.parametrize("plugin", [MAPPDK, RMI])
def test_the_options_say_how_joints_are_counted(plugin):
    options = {"host": "127.0.0.1", "joint_3_from": "upper arm", "signs": "1 1 1 1 1 1", "reach_mm": 1500}

    assert not plugin.open(options, MonotonicClock()).connected
