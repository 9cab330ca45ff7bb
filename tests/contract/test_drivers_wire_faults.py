"""Faults of wires, keys and other programs, planted in the simulated device: none becomes a reading."""

import math

import pytest

from truepose_drivers.errors import DriverError, NotInitialisedError, RemoteProtocolError
from truepose_simulators.faults import kinds

LINE_GAUGES = ["keyence_gt2", "mitutoyo_eh", "mitutoyo_serial"]
GAUGES = ["heidenhain_nd", "mitutoyo_usb_itn", *LINE_GAUGES]


async def reading_gauge(bench, name):
    gauge = bench.driver(name)
    await gauge.connect()
    bench.bar.deviation_mm = 0.5
    assert (await gauge.read()).deviation_mm == 0.5
    return gauge


async def test_a_bar_that_hangs_gives_no_length(bench):
    bar = await reading_gauge(bench, "ballbar_hid")
    bench.cell.add_fault(kinds.BallbarFrozen())
    bench.bar.deviation_mm = -0.25

    for _ in range(2):
        with pytest.raises(RemoteProtocolError, match="repeats itself"):
            await bar.read()
        await bar.connect()


async def test_a_counter_switched_to_inches_goes_on_in_millimetres(bench):
    counter = await reading_gauge(bench, "heidenhain_nd")
    bench.cell.add_fault(kinds.BallbarInches())

    for deviation_mm in (0.5, -0.25):
        bench.bar.deviation_mm = deviation_mm
        reading = await counter.read()
        assert reading.deviation_mm == pytest.approx(deviation_mm, abs=reading.resolution_mm)


@pytest.mark.parametrize("name", ["mitutoyo_usb_itn", *LINE_GAUGES])
async def test_a_gauge_switched_to_inches_is_no_reading_until_it_shows_millimetres(bench, name):
    gauge = await reading_gauge(bench, name)
    now_s = bench.cell.clock.now_s
    bench.cell.add_fault(kinds.BallbarInches(from_s=now_s, until_s=now_s + 10.0))

    for _ in range(2):
        with pytest.raises(RemoteProtocolError, match="inches"):
            await gauge.read()
        await gauge.connect()
    await bench.cell.clock.sleep(10.0)

    assert (await gauge.read()).deviation_mm == 0.5


@pytest.mark.parametrize("name", GAUGES)
async def test_a_key_that_is_pressed_shifts_no_reading(bench, name):
    gauge = await reading_gauge(bench, name)
    bench.cell.add_fault(kinds.BallbarKeyPressed())

    for deviation_mm in (0.1, 0.2, 0.3, -0.4, 0.5):
        bench.bar.deviation_mm = deviation_mm
        assert (await gauge.read()).deviation_mm == deviation_mm


@pytest.mark.parametrize("name", GAUGES)
async def test_digits_that_come_twice_are_no_reading(bench, name):
    gauge = await reading_gauge(bench, name)
    bench.cell.add_fault(kinds.LineDoublesDigits())

    with pytest.raises(DriverError):
        await gauge.read()
    assert not gauge.connected


@pytest.mark.parametrize("name", ["heidenhain_nd", *LINE_GAUGES])
async def test_a_line_that_stalls_inside_a_number_is_waited_for(bench, name):
    counter = await reading_gauge(bench, name)
    bench.cell.add_fault(kinds.LineStalls())
    bench.bar.deviation_mm = -0.1234

    assert (await counter.read()).deviation_mm == -0.1234


@pytest.mark.parametrize(
    "name", ["abb_open_abb", "abb_rws", "fanuc_mappdk", "fanuc_rmi", "kuka_variable_proxy"]
)
async def test_joints_on_a_line_that_stalls_are_whole(bench, name):
    robot = bench.driver(name)
    await robot.connect()
    await robot.move_joints(tuple(map(math.radians, (10.0, -20.55, 30.0, 5.25, 45.0, -12.34))))
    before = await robot.read_joints()
    bench.cell.add_fault(kinds.LineStalls())

    assert (await robot.read_joints()).joints_rad == before.joints_rad


async def ready_tracker(bench):
    tracker = bench.driver("leica_emscon")
    await tracker.connect()
    await tracker.initialise()
    await tracker.find_reflector(bench.fixed_nest_mm(1), search_radius_mm=20.0)
    await tracker.measure_point(duration_s=0.5)
    await tracker.find_reflector(bench.fixed_nest_mm(2), search_radius_mm=20.0)
    return tracker


async def test_units_that_another_program_changes_during_a_measurement_spoil_no_point(bench):
    tracker = await ready_tracker(bench)
    bench.cell.add_fault(kinds.TrackerUnitsChanged())

    with pytest.raises(NotInitialisedError, match="units"):
        await tracker.measure_point(duration_s=0.5)
    with pytest.raises(NotInitialisedError):
        await tracker.find_reflector(bench.fixed_nest_mm(2), search_radius_mm=20.0)
    await tracker.initialise()
    await tracker.find_reflector(bench.fixed_nest_mm(2), search_radius_mm=20.0)

    point = (await tracker.measure_point(duration_s=0.5)).point_mm
    assert math.dist(point, bench.fixed_nest_mm(2)) < 1.0


async def test_the_result_of_an_earlier_measurement_is_no_point_of_this_one(bench):
    tracker = await ready_tracker(bench)
    bench.cell.add_fault(kinds.TrackerRepeatsResult())

    with pytest.raises(RemoteProtocolError, match="earlier measurement"):
        await tracker.measure_point(duration_s=0.5)
    assert not tracker.connected


async def test_a_result_that_was_under_way_is_passed_over(bench):
    tracker = await ready_tracker(bench)
    bench.cell.add_fault(kinds.TrackerStaleResult())

    point = (await tracker.measure_point(duration_s=0.5)).point_mm

    assert math.dist(point, bench.fixed_nest_mm(2)) < 1.0
