"""What a driver may offer beside its kind: it comes through the guard, or the guard answers for it."""

import inspect
import math

import pytest

from tests.unit.drivers.guarded_instruments import CALLS, LENGTH, Able, Box, Instrument
from truepose_drivers.api import MotionGuard
from truepose_drivers.errors import DriverFaultError
from truepose_drivers.guard import guarded
from truepose_drivers.plausibility import ABILITIES

pytestmark = pytest.mark.simulated_time


class HandsOn:
    """An integrator's own wrapper, which hands on whatever it is asked for."""

    def __init__(self, device):
        self._device = device

    def __getattr__(self, name):
        return getattr(self._device, name)


@pytest.mark.parametrize("around", [lambda device: device, HandsOn])
async def test_every_ability_of_a_driver_comes_through_its_guard(around):
    able = around(Able((1.0, 2.0, 3.0)))

    assert guarded("acme", "robot", able).motion_guard == Able.motion_guard
    assert guarded("acme", "tracker", able).settings == Able.settings
    assert guarded("acme", "pose_tracker", able).settings == Able.settings
    assert await guarded("acme", "tracker", able).reflector_now() == (1.0, 2.0, 3.0)
    assert (
        await guarded("acme", "linear_gauge", around(Box((LENGTH, LENGTH)))).read_channels() == (LENGTH,) * 2
    )


async def test_for_an_ability_that_a_driver_lacks_its_guard_answers():
    assert guarded("acme", "robot", Instrument()).motion_guard == MotionGuard()
    assert guarded("acme", "tracker", Instrument()).settings == ""
    assert await guarded("acme", "tracker", Instrument()).reflector_now() is None


def test_nothing_passes_a_guard_that_no_kind_of_device_has():
    class Talkative(Instrument):
        gossip = "psst"

    for kind in CALLS:
        assert not hasattr(guarded("acme", kind, Talkative()), "gossip")


def test_what_a_kind_of_device_may_offer_is_declared_on_its_guard():
    for kind, abilities in ABILITIES.items():
        for ability in abilities:
            for name in (name for name in vars(ability) if not name.startswith("_")):
                assert inspect.getattr_static(guarded("acme", kind, Instrument()), name) is not None


class Unable(Instrument):
    """Fails where it is asked for a property."""

    @property
    def motion_guard(self):
        raise ValueError("no")

    settings = motion_guard


@pytest.mark.parametrize(
    "nonsense",
    [
        None,
        1.0,
        "1 s",
        MotionGuard(longest_piece_s=-1.0),
        MotionGuard(longest_piece_s=math.nan),
        MotionGuard(stops_unheard_s="soon"),
        MotionGuard(stops_unheard_s=0.0),
        MotionGuard(stops_unheard_s=math.inf),
        MotionGuard(longest_piece_s=1.0, speed_point_mm=(0.0, math.nan, 125.0)),
        MotionGuard(longest_piece_s=1.0, speed_point_mm=(0.0, 125.0)),
        MotionGuard(longest_piece_s=1.0, speed_point_mm=None),
        *(
            MotionGuard(longest_piece_s=1.0, speed_share=share)
            for share in (0.0, -0.5, 1.5, math.nan, "half")
        ),
    ],
    ids=str,
)
def test_of_a_robot_whose_driver_talks_nonsense_of_its_motions_the_worst_is_said(nonsense):
    able = Able()
    able.motion_guard = nonsense

    assert guarded("acme", "robot", able).motion_guard == MotionGuard()
    assert guarded("acme", "robot", Unable()).motion_guard == MotionGuard()


@pytest.mark.parametrize(
    ("said", "heard"), [(2.5, 2.5), (math.nan, 0.0), (math.inf, 0.0), (-1.0, 0.0), ("2 s", 0.0), (None, 0.0)]
)
def test_how_long_a_motion_takes_is_a_time_or_nothing(said, heard):
    able = Able()
    able.motion_guard = MotionGuard(longest_piece_s=0.8, takes_s=lambda start_rad, target_rad: said)

    assert guarded("acme", "robot", able).motion_guard.takes_s((0.0,), (1.0,)) == heard


def test_a_driver_that_fails_to_say_how_long_a_motion_takes_says_nothing():
    able = Able()
    able.motion_guard = MotionGuard(longest_piece_s=0.8, takes_s=lambda: 1.0)

    assert guarded("acme", "robot", able).motion_guard.takes_s((0.0,), (1.0,)) == 0.0


@pytest.mark.parametrize(("said", "heard"), [(None, ""), (7, ""), (" a\ud800\x00b\n", "a??b?")], ids=repr)
def test_settings_are_a_sentence_that_can_be_kept(said, heard):
    able = Able()
    able.settings = said

    assert guarded("acme", "tracker", able).settings == heard
    assert guarded("acme", "tracker", Unable()).settings == ""


@pytest.mark.parametrize("place", [(math.nan,) * 3, (math.inf, 0.0, 0.0), (1e12, 0.0, 0.0)])
async def test_a_reflector_that_can_be_nowhere_is_not_seen_and_costs_no_link(place):
    device = guarded("acme", "tracker", Able(place))

    assert await device.reflector_now() is None
    assert device.connected


@pytest.mark.parametrize("place", ["here", 7, (1.0, 2.0), (1.0, 2.0, "x")], ids=repr)
async def test_a_look_that_answers_no_place_at_all_is_a_fault_of_the_driver(place):
    device = guarded("acme", "tracker", Able(place))

    with pytest.raises(DriverFaultError, match="reflector_now"):
        await device.reflector_now()

    assert not device.connected
