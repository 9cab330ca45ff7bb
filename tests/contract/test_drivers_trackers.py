"""What a tracker driver promises, against the simulated tracker."""

import math

import numpy as np
import pytest

from tests.contract.benches import registry
from truepose_drivers.errors import (
    BeamBrokenError,
    ConnectionLostError,
    NotInitialisedError,
    ReflectorNotFoundError,
)
from truepose_simulators.faults.kinds import BeamBroken, TrackerBlinded, TrackerCut

trackers = pytest.mark.parametrize("name", registry().names("tracker"))
RADIUS_MM = 10.0


async def ready(bench, name):
    tracker = bench.driver(name)
    await tracker.connect()
    await tracker.initialise()
    return tracker


@pytest.fixture(params=registry().names("tracker"))
async def tracker(bench, request):
    return await ready(bench, request.param)


async def test_a_fixed_nest_is_found_and_measured_where_it_is(bench, tracker):
    nest_mm = bench.fixed_nest_mm(1)

    await tracker.find_reflector(nest_mm, search_radius_mm=RADIUS_MM)
    reading = await tracker.measure_point(duration_s=1.0)

    # 5 sigma of the worst direction: 1 of 600,000 readings would miss; the two-face error adds microns
    assert math.dist(reading.point_mm, nest_mm) < 5.0 * bench.spread_mm(nest_mm) + 0.005
    assert reading.face == 1
    assert all(0.0 < deviation < 0.1 for deviation in reading.standard_deviation_mm)
    assert reading.rms_mm == pytest.approx(math.hypot(*reading.standard_deviation_mm), rel=1e-6)


async def test_a_reading_states_the_covariance_of_the_accuracy_model(bench, tracker):
    nest_mm = bench.fixed_nest_mm(1)
    await tracker.find_reflector(nest_mm, search_radius_mm=RADIUS_MM)

    stated = np.array((await tracker.measure_point(duration_s=1.0)).covariance_mm2)

    beam = np.array(nest_mm) / math.hypot(*nest_mm)
    assert stated == pytest.approx(stated.T)
    # the scenario's model: along the beam 8 um + 0.8 um/m, across it 10 um + 3.5 um/m, here 2 to 4 m away
    assert 0.009 < math.sqrt(beam @ stated @ beam) < 0.012
    assert 0.016 < math.sqrt((np.trace(stated) - beam @ stated @ beam) / 2.0) < 0.025


@trackers
async def test_a_measurement_takes_cell_time_and_is_stamped_by_the_cells_clock(bench, name):
    bench.clock = bench.driver("cell_clock")
    tracker = await ready(bench, name)
    await tracker.find_reflector(bench.fixed_nest_mm(1), search_radius_mm=RADIUS_MM)
    before_s = await bench.clock.now_s()

    reading = await tracker.measure_point(duration_s=2.5)

    assert reading.time_s >= before_s + 2.5
    assert reading.time_s <= await bench.clock.now_s()


async def test_the_other_face_sees_the_same_reflector(bench, tracker):
    nest_mm = bench.fixed_nest_mm(2)
    await tracker.find_reflector(nest_mm, search_radius_mm=RADIUS_MM)

    await tracker.change_face()
    reading = await tracker.measure_point(duration_s=1.0)

    assert reading.face == 2
    # as above, with the collimation and index errors of 0.5 urad each, twice, at less than 5 m
    assert math.dist(reading.point_mm, nest_mm) < 5.0 * bench.spread_mm(nest_mm) + 0.02


async def test_an_empty_place_is_no_reflector(bench, tracker):
    x, y, z = bench.fixed_nest_mm(1)

    with pytest.raises(ReflectorNotFoundError):
        await tracker.find_reflector((x, y, z + 800.0), search_radius_mm=RADIUS_MM)

    await tracker.find_reflector((x, y, z), search_radius_mm=RADIUS_MM)
    assert tracker.connected


async def test_a_blinded_tracker_finds_nothing(bench, tracker):
    bench.cell.faults.add(TrackerBlinded())

    with pytest.raises(ReflectorNotFoundError):
        await tracker.find_reflector(bench.fixed_nest_mm(1), search_radius_mm=RADIUS_MM)


async def test_a_broken_beam_is_reported_and_the_next_reading_succeeds(bench, tracker):
    nest_mm = bench.fixed_nest_mm(1)
    await tracker.find_reflector(nest_mm, search_radius_mm=RADIUS_MM)
    bench.cell.faults.add(BeamBroken(reading=1))

    with pytest.raises(BeamBrokenError, match="line of sight"):
        await tracker.measure_point(duration_s=1.0)
    await tracker.find_reflector(nest_mm, search_radius_mm=RADIUS_MM)
    reading = await tracker.measure_point(duration_s=1.0)

    assert math.dist(reading.point_mm, nest_mm) < 1.0  # the right reflector, not another one


async def test_a_link_cut_in_the_middle_of_a_packet_is_lost_and_comes_back(bench, tracker):
    nest_mm = bench.fixed_nest_mm(1)
    await tracker.find_reflector(nest_mm, search_radius_mm=RADIUS_MM)
    bench.cell.faults.add(TrackerCut(reading=1))

    with pytest.raises(ConnectionLostError, match="middle of a message"):
        await tracker.measure_point(duration_s=1.0)
    assert not tracker.connected
    await tracker.connect()
    with pytest.raises(NotInitialisedError):
        await tracker.measure_point(duration_s=1.0)
    await tracker.initialise()
    await tracker.find_reflector(nest_mm, search_radius_mm=RADIUS_MM)

    assert math.dist((await tracker.measure_point(duration_s=1.0)).point_mm, nest_mm) < 1.0


async def test_the_weather_station_is_read_in_house_units(tracker):
    air = await tracker.environment()

    assert 5.0 < air.temperature_c < 40.0
    assert 800.0 < air.pressure_hpa < 1100.0
    assert 0.0 < air.humidity_percent < 100.0
