"""Planted changes as the instruments of a whole cell see them."""

import numpy as np
import pytest

from truepose_simulators.errors import ScenarioError
from truepose_simulators.instruments.accuracy import TrackerSetup, noise_mm
from truepose_simulators.instruments.tracker import in_tracker_frame
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.physics.rigid import move
from truepose_simulators.physics.true_robot import NoEquilibriumError

HOUR_S = 3600.0


async def read_fixed(cell, number):
    """One reading of a fixed nest, tracker frame."""
    cell.tracker.initialise()
    target = next(item for item in cell._targets() if item.name == f"fixed {number}")
    cell.tracker.point(target.position_mm)
    cell.tracker.search(1e-3)
    return cell.tracker.measure(1.0).position_mm


def read_tool(cell, nest):
    """One reading of a tool nest, whether or not its reflector faces the tracker."""
    position = in_tracker_frame(cell.tracker.frame, cell._tool_nests_now()[nest - 1])
    return cell._spoil(f"tool {nest}", position)


async def fixed_nests_seen(cell):
    return np.array([await read_fixed(cell, number) for number in (1, 2, 3)])


async def test_fixed_nests_see_the_instrument_drift_and_the_arm_does_not(make_cell):
    cell = make_cell(noise=False)
    drift = {"direction": [0.0, 1.0, 0.0], "rotation_rad_per_h": 0.0}
    before, frame = await fixed_nests_seen(cell), cell.tracker.frame
    arm_before = cell._tool_nests_now()
    cell.plant_change(PlantedChange("instrument_drift", "tracker", 0.06, details=drift))

    await cell.clock.sleep(HOUR_S)
    after = await fixed_nests_seen(cell)

    # What stays where it is seems to go the other way; in the world as registered before the drift.
    moved = move(frame, after) - move(frame, before)
    assert moved == pytest.approx(np.tile([0.0, -0.06, 0.0], (3, 1)), abs=1e-9)
    assert cell._tool_nests_now() == pytest.approx(arm_before, abs=1e-9)


async def test_fixed_nests_see_a_wrong_scale(make_cell):
    cell = make_cell(noise=False)
    before = await fixed_nests_seen(cell)
    cell.plant_change(PlantedChange("instrument_scale", "tracker", 20e-6))

    after = await fixed_nests_seen(cell)

    assert after == pytest.approx(before * (1 + 20e-6), rel=1e-12)


async def test_fixed_nests_do_not_see_a_drifting_base_and_the_arm_does(make_cell):
    cell = make_cell(noise=False)
    before, arm_before = await fixed_nests_seen(cell), cell._tool_nests_now()
    cell.plant_change(
        PlantedChange("base_drift", "base", 0.06, from_s=cell.clock.now_s, details={"direction": [1, 0, 0]})
    )

    await cell.clock.sleep(HOUR_S)

    assert await fixed_nests_seen(cell) == pytest.approx(before, abs=1e-9)
    # Initialising before the second look took 15 s more, 0.00025 mm of drift.
    moved = cell._tool_nests_now() - arm_before
    assert moved == pytest.approx(np.tile([0.06, 0.0, 0.0], (3, 1)), abs=3e-4)


def test_under_a_swapped_label_the_other_nest_is_read(make_cell):
    cell = make_cell(noise=False)
    honest = [read_tool(cell, nest) for nest in (1, 2, 3)]
    cell.plant_change(PlantedChange("label_swap", "nest 1, nest 2", 1.0))

    swapped = [read_tool(cell, nest) for nest in (1, 2, 3)]

    assert np.array(swapped) == pytest.approx(np.array(honest)[[1, 0, 2]], abs=1e-9)


def test_a_share_of_the_readings_of_a_cell_is_bad(make_cell):
    cell = make_cell(noise=False)
    honest = read_tool(cell, 2)
    cell.plant_change(PlantedChange("outliers", "readings", 0.1, details={"size_mm": 0.5}))

    off = np.array([np.linalg.norm(read_tool(cell, 2) - honest) for _ in range(500)])

    # Binomial: sqrt(0.1 * 0.9 / 500) = 0.0134, four of these.
    assert np.mean(off > 0.0) == pytest.approx(0.1, abs=0.054)
    assert off[off > 0.0] == pytest.approx(0.5, abs=1e-9)


def test_bad_readings_take_no_number_from_the_noise_of_the_good_ones(make_cell):
    clean, planted = make_cell(seed=4), make_cell(seed=4)
    planted.plant_change(PlantedChange("outliers", "readings", 1.0))

    read_tool(planted, 1)

    assert planted.rng.normal() == clean.rng.normal()


def test_a_misplaced_nest_is_where_the_truth_and_the_tracker_find_it(make_cell):
    cell = make_cell(noise=False)
    before = cell._tool_nests_now()
    cell.plant_change(PlantedChange("nest_offset", "nest 3", 0.06))

    moved = np.linalg.norm(cell._tool_nests_now() - before, axis=1)

    assert moved == pytest.approx([0.0, 0.0, 0.06], abs=1e-9)
    stop = cell.conditions_now()
    assert cell.true_positions(stop)[0] == pytest.approx(cell._tool_nests_now(), abs=1e-9)


def test_a_new_mounting_of_the_tool_has_a_new_seat(make_cell):
    cell = make_cell(noise=False)
    cell.plant_change(PlantedChange("tool_reseating", "tool", 0.03))
    first = cell._tool_nests_now()
    cell.attachment += 1

    second = cell._tool_nests_now()
    cell.attachment -= 1

    assert 0.001 < np.linalg.norm(second - first, axis=1).max() < 0.3
    assert np.array_equal(cell._tool_nests_now(), first)


async def test_the_weather_station_shows_the_warm_up_that_lengthens_the_links(make_cell):
    cell = make_cell(noise=False)
    still = make_cell(noise=False)
    cell.plant_change(PlantedChange("thermal_growth", "links", 18e-6))
    await cell.clock.sleep(10 * HOUR_S)
    await still.clock.sleep(10 * HOUR_S)

    warmer_k = cell.air.sensed_c(cell.clock.now_s, None) - still.air.sensed_c(still.clock.now_s, None)
    grown_mm = cell._tool_nests_now() - still._tool_nests_now()

    assert warmer_k == pytest.approx(6.0, abs=1e-5)  # fifteen time constants
    # The nests are about 630 high and 500 in front; growth times height, the wave of 0.3 K beside the 6 K.
    assert grown_mm[0, 2] == pytest.approx(18e-6 * 6.0 * 630, rel=0.06)


async def test_a_change_in_the_middle_of_a_session_is_not_there_before(make_cell):
    cell = make_cell(noise=False)
    before = cell._tool_nests_now()
    cell.plant_change(PlantedChange("base_shift", "base", 0.08, from_s=100.0))
    until = cell._tool_nests_now()

    await cell.clock.sleep(100.0)

    assert until == pytest.approx(before, abs=1e-9)
    moved = np.linalg.norm(cell._tool_nests_now() - before, axis=1)
    assert moved == pytest.approx([0.08] * 3, abs=1e-9)


def test_a_change_that_would_fold_the_arm_is_refused_and_leaves_the_cell_as_it_was(make_cell):
    cell = make_cell(noise=False)
    before = cell._tool_nests_now()
    for joint in range(1, 6):
        cell.plant_change(PlantedChange("compliance", f"joint {joint}", 4e-6))
    bent = cell._tool_nests_now()

    with pytest.raises(NoEquilibriumError, match="gearboxes are too compliant"):
        cell.plant_change(PlantedChange("payload", "tool", 20.0))

    assert np.array_equal(cell._tool_nests_now(), bent)
    assert not np.allclose(bent, before)


def test_a_refused_change_is_not_planted(make_cell):
    cell = make_cell()

    with pytest.raises(ScenarioError, match="joint 9"):
        cell.plant_change(PlantedChange("joint_gain", "joint 9", 1e-3))

    assert cell.planted.changes == ()


@pytest.mark.parametrize("freedom", [4.0, 30.0])
def test_heavy_tailed_noise_keeps_the_stated_deviation(freedom):
    setup = TrackerSetup(noise_degrees_of_freedom=freedom)
    points = np.tile([2000.0, 0.0, 0.0], (200_000, 1))

    noise = noise_mm(setup, points, np.random.default_rng(1))

    # Of 4 degrees of freedom the fourth moment is infinite, so that the deviation settles slowly.
    assert noise[:, 0].std() == pytest.approx(0.0096, rel=0.02)
    assert noise[:, 1].std() == pytest.approx(0.017, rel=0.02)
    # Of normal noise 0.27 % lie beyond three deviations, of Student's t of 4 degrees of freedom 1.33 %.
    beyond = np.mean(np.abs(noise[:, 1]) > 3 * 0.017)
    assert beyond == pytest.approx({4.0: 0.0133, 30.0: 0.0041}[freedom], rel=0.1)


def test_noise_without_finite_variance_is_refused():
    with pytest.raises(ScenarioError, match=r'key "noise_degrees_of_freedom" must be above 2, not 2\.0'):
        TrackerSetup(noise_degrees_of_freedom=2.0)
