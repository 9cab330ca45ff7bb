"""The guard between any driver and the service: what passes, what becomes a sentence, what is no reading."""

import asyncio
import math
import struct
from dataclasses import replace

import pytest

from tests.unit.drivers.guarded_instruments import CALLS, LENGTH, Able, Box, Instrument
from truepose_drivers.api import (
    DeviceIdentity,
    Environment,
    JointReading,
    PoseReading,
    TrackerReading,
)
from truepose_drivers.errors import (
    BeamBrokenError,
    ConnectionLostError,
    DriverFaultError,
    ImplausibleReadingError,
    RemoteProtocolError,
)
from truepose_drivers.guard import guarded

pytestmark = pytest.mark.simulated_time

POINT = TrackerReading((3000.0, 1.0, 2.0), (0.01, 0.01, 0.01), 0.02, 50, 1.0, 1, 10.0)
POSE = PoseReading((0.5, -0.5, 0.5, 0.5), (1.0, 2.0, -2000.0), (0.02,) * 3, 1e-4, 0.1, 60, 1.0, 10.0)
JOINTS = JointReading((0.1, -0.2, 0.3, 0.0, 1.0, -1.0), 1e-4, 10.0)
AIR = Environment(20.0, 1013.0, 50.0)
FOREIGN = [
    ValueError("The device has no langid"),
    OSError(5, "Input/output error"),
    struct.error("unpack requires a buffer"),
    KeyError("serial"),
    UnicodeDecodeError("ascii", b"\xff", 0, 1, "ordinal not in range"),
    RecursionError("maximum recursion depth exceeded"),
    TimeoutError(),
    AssertionError(),
]


EVERY_CALL = [(kind, *call) for kind, calls in CALLS.items() for call in calls]


@pytest.mark.parametrize("error", FOREIGN, ids=lambda error: type(error).__name__)
@pytest.mark.parametrize(("kind", "name", "given", "named"), EVERY_CALL)
async def test_an_error_that_is_none_of_a_driver_becomes_a_sentence_and_closes_the_link(
    kind, name, given, named, error
):
    instrument = Able(error)
    device = guarded("acme", kind, instrument)

    sentence = rf"driver acme failed in {name} .*{type(error).__name__}.*check"
    with pytest.raises(DriverFaultError, match=sentence):
        await getattr(device, name)(*given, **named)

    assert kind == "clock" or not device.connected


async def test_what_a_driver_says_itself_passes_and_leaves_the_link():
    device = guarded("acme", "tracker", Instrument(BeamBrokenError("beam broken")))

    with pytest.raises(BeamBrokenError):
        await device.measure_point(duration_s=1.0)

    assert device.connected


async def test_nonsense_closes_the_link_also_where_the_driver_forgets_to():
    device = guarded("acme", "tracker", Instrument(RemoteProtocolError("the tracker answered 42")))

    with pytest.raises(RemoteProtocolError, match="answered 42"):
        await device.measure_point(duration_s=1.0)

    assert not device.connected


@pytest.mark.parametrize("error", [asyncio.CancelledError(), KeyboardInterrupt()])
async def test_what_ends_a_task_passes(error):
    instrument = Instrument(error)

    with pytest.raises(type(error)):
        await guarded("acme", "ballbar", instrument).read()


async def test_closing_never_raises_and_a_state_that_cannot_be_told_is_not_connected():
    class Stubborn(Instrument):
        @property
        def connected(self):
            raise ValueError("no")

        @connected.setter
        def connected(self, value):
            pass

        async def close(self):
            raise OSError("no")

    device = guarded("acme", "robot", Stubborn(None))

    await device.close()

    assert not device.connected


POINTS_THAT_ARE_NONE = [
    {"point_mm": (math.nan, 0.0, 0.0)},
    {"point_mm": (math.inf, 0.0, 0.0)},
    {"point_mm": (1e12, 0.0, 0.0)},
    {"point_mm": (150_000.0, 150_000.0, 0.0)},
    {"standard_deviation_mm": (-0.01, 0.01, 0.01)},
    {"standard_deviation_mm": (math.inf, 0.01, 0.01)},
    {"rms_mm": -1.0},
    {"rms_mm": math.inf},
    {"samples": -1},
    {"samples": 0},
    {"duration_s": -1.0},
    {"face": 3},
    {"time_s": math.nan},
    {"covariance_mm2": ((math.nan, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))},
    {"covariance_mm2": ((-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))},
    {"covariance_mm2": ((1.0, 2.0, 0.0), (2.0, 1.0, 0.0), (0.0, 0.0, 1.0))},
    {"covariance_mm2": ((1.0, 0.5, 0.0), (0.1, 1.0, 0.0), (0.0, 0.0, 1.0))},
    {"covariance_mm2": ((1.0, 1e200, 0.0), (1e200, 1.0, 0.0), (0.0, 0.0, 1.0))},
    {"covariance_mm2": ((math.inf, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))},
]


POSES_THAT_ARE_NONE = [
    {"quaternion": (0.5, 0.5, 0.5, 0.501)},
    {"quaternion": (math.nan, 0.0, 0.0, 1.0)},
    {"position_mm": (math.nan, 0.0, 0.0)},
    {"position_mm": (1e12, 0.0, 0.0)},
    {"position_deviation_mm": (-0.01, 0.01, 0.01)},
    {"rotation_deviation_rad": math.inf},
    {"rms_mm": -1.0},
    {"frames": 0},
    {"duration_s": 0.0},
    {"time_s": -1.0},
]
JOINTS_THAT_ARE_NONE = [
    {"joints_rad": ()},
    {"joints_rad": (math.nan,) * 6},
    {"joints_rad": (100.0, 0.0, 0.0, 0.0, 0.0, 0.0)},
    {"joints_rad": (0.0,) * 5},
    {"joints_rad": (0.0,) * 7},
    {"resolution_rad": -1.0},
    {"time_s": 9.0},
]
LENGTHS_THAT_ARE_NONE = [
    {"deviation_mm": math.nan},
    {"deviation_mm": -math.inf},
    {"deviation_mm": 1000.1},
    {"signal": "perhaps"},
    {"resolution_mm": 0.0},
    {"temperature_c": 1e6},
    {"time_s": 9.0},
]
NO_READINGS = {
    ("tracker", "measure_point", POINT): POINTS_THAT_ARE_NONE,
    ("pose_tracker", "measure_pose", POSE): POSES_THAT_ARE_NONE,
    ("robot", "read_joints", JOINTS): JOINTS_THAT_ARE_NONE,
    ("ballbar", "read", LENGTH): LENGTHS_THAT_ARE_NONE,
}


@pytest.mark.parametrize(
    ("kind", "name", "good", "changes"),
    [(*asked, changes) for asked, nonsense in NO_READINGS.items() for changes in nonsense],
    ids=str,
)
async def test_what_no_instrument_of_its_kind_means_is_no_reading(kind, name, good, changes):
    device = guarded("acme", kind, Instrument(good, replace(good, **changes)))
    given = {"duration_s": 1.0} if name.startswith("measure") else {}
    await getattr(device, name)(**given)

    with pytest.raises(ImplausibleReadingError, match=r"driver acme.*check"):
        await getattr(device, name)(**given)

    assert not device.connected


async def test_a_pose_that_a_camera_means_passes():
    single = replace(POSE, position_deviation_mm=(math.nan,) * 3, rotation_deviation_rad=math.nan, frames=1)
    device = guarded("acme", "pose_tracker", Instrument(POSE, single))

    assert await device.measure_pose(duration_s=1.0) is POSE
    assert await device.measure_pose(duration_s=1.0) is single


async def test_a_point_that_a_tracker_means_passes():
    known = replace(POINT, covariance_mm2=((1e-4, 1e-5, 0.0), (1e-5, 4e-4, 0.0), (0.0, 0.0, 4e-4)))
    silent = replace(POINT, standard_deviation_mm=(math.nan,) * 3, rms_mm=math.nan)
    device = guarded("acme", "tracker", Instrument(known, silent))

    assert await device.measure_point(duration_s=1.0) is known
    assert await device.measure_point(duration_s=1.0) is silent


@pytest.mark.parametrize(
    "readings", [(), (LENGTH, replace(LENGTH, deviation_mm=2000.0)), (LENGTH, replace(LENGTH, time_s=9.0))]
)
async def test_a_box_of_gauges_that_says_what_none_shows_is_no_reading(readings):
    device = guarded("acme", "linear_gauge", Box(readings))

    with pytest.raises(ImplausibleReadingError):
        await device.read_channels()


async def test_a_gauge_alone_is_a_box_of_one():
    alone = guarded("acme", "linear_gauge", Instrument(LENGTH))
    several = guarded("acme", "linear_gauge", Box((LENGTH, replace(LENGTH, deviation_mm=0.5))))

    assert await alone.read_channels() == (LENGTH,)
    assert [one.deviation_mm for one in await several.read_channels()] == [0.1234, 0.5]


async def test_a_count_that_stands_still_for_a_second_is_no_reading():
    later = [replace(LENGTH, time_s=LENGTH.time_s + passed_s) for passed_s in (0.0, 0.9, 1.1)]
    device = guarded("acme", "ballbar", Instrument(*later))
    await device.read()
    await device.read()  # asked faster than it measures

    with pytest.raises(RemoteProtocolError, match="repeated its reading 7"):
        await device.read()

    assert not device.connected


@pytest.mark.parametrize("counts", [(7, 8, 9), (None, None, None)])
async def test_a_count_that_goes_on_or_is_none_may_take_its_time(counts):
    readings = [replace(LENGTH, sequence=count, time_s=10.0 * at) for at, count in enumerate(counts)]
    device = guarded("acme", "ballbar", Instrument(*readings))

    assert [(await device.read()).sequence for _ in counts] == list(counts)


async def test_a_new_connection_may_begin_with_the_count_of_before():
    device = guarded("acme", "ballbar", Instrument(LENGTH, None, replace(LENGTH, time_s=100.0)))
    await device.read()

    await device.connect()

    assert (await device.read()).sequence == LENGTH.sequence


async def test_without_a_signal_a_value_is_not_asked_for():
    nothing = replace(LENGTH, deviation_mm=math.nan, signal="none", temperature_c=None)

    assert await guarded("acme", "ballbar", Instrument(nothing)).read() is nothing


async def test_a_new_connection_may_begin_at_another_time():
    device = guarded("acme", "ballbar", Instrument(LENGTH, None, replace(LENGTH, time_s=0.0)))
    await device.read()

    await device.connect()

    assert (await device.read()).time_s == 0.0


@pytest.mark.parametrize("temperature_c", [-273.15, math.inf, 1e9])
async def test_air_that_nobody_could_stand_in_is_no_reading(temperature_c):
    device = guarded("acme", "tracker", Instrument(replace(AIR, temperature_c=temperature_c)))

    with pytest.raises(ImplausibleReadingError, match="temperature"):
        await device.environment()


async def test_a_thing_that_is_no_reading_at_all_is_a_fault_of_the_driver():
    with pytest.raises(DriverFaultError, match="AttributeError"):
        await guarded("acme", "ballbar", Instrument(0.1234)).read()


async def test_an_identity_is_made_of_characters_that_can_be_seen_and_kept():
    said = DeviceIdentity("Acme\x00", "bar\ud800", " ", "1" * 5000)

    identity = await guarded("acme", "ballbar", Instrument(said)).identify()

    assert (identity.manufacturer, identity.model, identity.serial) == ("Acme?", "bar?", "unknown")
    assert len(identity.firmware) == 200


async def test_a_clock_that_goes_back_is_told_once():
    clock = guarded("acme", "clock", Instrument(5.0, 4.0, 4.5))
    assert await clock.now_s() == 5.0

    with pytest.raises(ImplausibleReadingError, match=r"4\.0 s after 5\.0 s"):
        await clock.now_s()

    assert await clock.now_s() == 4.5


async def test_answers_of_a_clock_that_overtake_each_other_are_no_fault():
    class Slow(Instrument):
        async def now_s(self) -> float:
            self.says[0] += 1.0
            mine = self.says[0]
            await asyncio.sleep(0.01 if mine == 1.0 else 0.0)  # the first answer comes last
            return mine

    clock = guarded("acme", "clock", Slow(0.0))

    assert await asyncio.gather(clock.now_s(), clock.now_s()) == [1.0, 2.0]


@pytest.mark.parametrize("now_s", [math.nan, math.inf])
async def test_a_time_that_is_none_is_refused(now_s):
    with pytest.raises(ImplausibleReadingError):
        await guarded("acme", "clock", Instrument(now_s)).now_s()


def test_a_reading_that_is_none_is_nonsense_of_the_device():
    assert issubclass(ImplausibleReadingError, RemoteProtocolError)


async def test_a_lost_link_stays_a_lost_link():
    with pytest.raises(ConnectionLostError):
        await guarded("acme", "robot", Instrument(ConnectionLostError("gone"))).read_joints()
