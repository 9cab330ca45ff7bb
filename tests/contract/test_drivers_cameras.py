"""What a driver of a tracker of poses promises, against the simulated instruments."""

import math

import pytest

from tests.contract.benches import registry
from truepose_drivers.errors import ArtefactNotSeenError, LinkError, NotInitialisedError
from truepose_simulators.faults import kinds

cameras = pytest.mark.parametrize("name", registry().names("pose_tracker"))
COUNTS_FRAMES = {"ndi_polaris"}  # the others average inside


async def ready(bench, name):
    bench.clock = bench.driver("cell_clock")
    camera = bench.driver(name, "pose_tracker")
    await camera.connect()
    await camera.initialise()
    return camera


@cameras
async def test_a_pose_is_the_mean_of_its_time_and_stamped_at_its_end(bench, name):
    camera = await ready(bench, name)
    await bench.clock.sleep(100.0)
    began_s = await bench.clock.now_s()

    reading = await camera.measure_pose(duration_s=0.5)

    assert math.hypot(*reading.quaternion) == pytest.approx(1.0, abs=1e-12)
    assert math.hypot(*reading.position_mm) == pytest.approx(2000.0, abs=500.0)
    assert (reading.frames > 1) == (name in COUNTS_FRAMES)
    assert all(0.0 < deviation < 0.1 for deviation in reading.position_deviation_mm)
    assert 0.0 < reading.rotation_deviation_rad < 1e-3
    assert reading.time_s == pytest.approx(began_s + 0.5, abs=0.1)


@cameras
async def test_a_camera_that_sees_nothing_says_so_and_goes_on(bench, name):
    camera = await ready(bench, name)
    now_s = bench.cell.clock.now_s
    bench.cell.add_fault(kinds.TrackerBlinded(until_s=now_s + 1.0))

    with pytest.raises(ArtefactNotSeenError, match="clear"):
        await camera.measure_pose(duration_s=0.5)
    await bench.clock.sleep(1.0)

    assert (await camera.measure_pose(duration_s=0.5)).frames >= 1


@pytest.mark.parametrize("name", sorted(COUNTS_FRAMES))
async def test_a_camera_that_hangs_is_lost_and_comes_back(bench, name):
    camera = await ready(bench, name)
    now_s = bench.cell.clock.now_s
    await camera.measure_pose(duration_s=0.1)
    bench.cell.add_fault(kinds.CameraFrozen(until_s=now_s + 100.0))

    with pytest.raises(LinkError):
        await camera.measure_pose(duration_s=0.5)
    assert not camera.connected
    await bench.clock.sleep(100.0)
    await camera.connect()
    await camera.initialise()

    assert (await camera.measure_pose(duration_s=0.5)).frames > 1


@cameras
async def test_nothing_is_measured_before_initialising(bench, name):
    camera = bench.driver(name, "pose_tracker")
    await camera.connect()

    with pytest.raises(NotInitialisedError, match="initialised"):
        await camera.measure_pose(duration_s=0.5)
