import math

import numpy as np
import pytest

from tests.unit.simulators.hands.deeds import (
    LEG,
    OTHER_POSE,
    POSE,
    SETUPS,
    clamp_all,
    move,
    shown,
    wide,
)
from truepose_simulators.errors import HandsError
from truepose_simulators.instruments.accuracy import BallbarSetup
from truepose_simulators.instruments.truth_endpoint import plant_document
from truepose_simulators.physics.effects import PlantedChange

CALIBRATOR_MM = 300.0 + BallbarSetup().calibrator_excess_mm
CORNERS = [(1, 2), (1, 3), (2, 3)]


def mean_mm(cell, n=400):
    """Mean of n readings: their noise of 0.00051 comes down to 0.00003."""
    return float(np.mean([shown(cell).deviation_mm for _ in range(n)]))


def true_mm(cell, base, tool):
    """Distance in the cell from what only a simulator knows."""
    cup = {cup.base_point: cup.place_mm for cup in cell.fixture.cups}[base]
    nest = cell.true_positions(cell.conditions_now())[0, tool - 1] + cell.robot.scatter_mm
    return float(np.linalg.norm(nest - cup))


async def test_without_noise_the_ballbar_shows_the_true_distance(posed):
    cell = await posed(noise=False, ballbar=wide())

    for base, tool in ((3, 2), (1, 2), (2, 2), (3, 1), (1, 1), (1, 3)):
        cell.hands.do("connect", {"base": base, "tool": tool})

        assert shown(cell).deviation_mm == pytest.approx(true_mm(cell, base, tool) - 300.0, abs=1e-9)
        assert shown(cell).signal == "good"


async def test_without_noise_sides_are_the_true_distances_of_nests_and_of_cups(posed):
    cell = await posed(noise=False, ballbar=wide())
    cups = {cup.base_point: cup.place_mm for cup in cell.fixture.cups}
    nests = dict(enumerate(cell.tool_nests_mm, start=1))

    for artefact, points, nominal in (("base", cups, 300.0), ("tool", nests, 150.0)):
        cell.hands.do("calibrator", {"bars": artefact})
        for a, b in CORNERS:
            cell.hands.do("side", {"artefact": artefact, "a": a, "b": b})

            expected = np.linalg.norm(points[a] - points[b]) - nominal
            assert shown(cell).deviation_mm == pytest.approx(expected, abs=1e-9)


async def test_cups_are_clamped_where_the_true_robot_holds_the_ball(lrmate):
    cell = lrmate(noise=False)

    await clamp_all(cell)

    joints = np.radians(SETUPS)
    held = cell.true_positions(cell.conditions(joints, np.ones((3, 6)), np.zeros(3), np.ones(3)))[:, 0]
    assert np.array([cup.place_mm for cup in cell.fixture.cups]) == pytest.approx(held, abs=1e-9)


async def test_lengths_count_from_the_calibrator_as_far_as_the_snaps_let_them(posed):
    cell = await posed(ballbar=wide())
    zero = mean_mm(cell)

    cell.hands.do("connect", LEG)
    length = CALIBRATOR_MM + mean_mm(cell) - zero

    # Two snaps of 0.0006 and the means of readings; bounded by 0.003 whatever happens.
    assert length == pytest.approx(true_mm(cell, **LEG), abs=0.003 + 0.0002)
    assert zero != 0.0  # bars are off by 0.02 on their own


async def test_the_zero_never_walks_farther_than_its_bound(posed):
    cell = await posed(ballbar=wide(noise_mm=0.0, resolution_mm=1e-9))
    zero = shown(cell).deviation_mm

    errors = []
    for _ in range(300):
        cell.hands.do("connect", LEG)
        errors.append(CALIBRATOR_MM + shown(cell).deviation_mm - zero - true_mm(cell, **LEG))

    # 600 snaps of 0.0006 without bound would come to 0.015.
    assert np.max(np.abs(errors)) == pytest.approx(0.003, abs=1e-6)


async def test_a_new_initialisation_begins_a_new_walk(posed):
    cell = await posed(ballbar=wide(noise_mm=0.0, resolution_mm=1e-9))

    errors = []
    for _ in range(200):
        cell.hands.do("calibrator", {"bars": "base"})
        zero = shown(cell).deviation_mm
        cell.hands.do("connect", LEG)
        errors.append(CALIBRATOR_MM + shown(cell).deviation_mm - zero - true_mm(cell, **LEG))

    # Two snaps each; standard deviation of 200 draws: 5 %, four of these.
    assert np.std(errors) == pytest.approx(0.0006 * math.sqrt(2.0), rel=0.2)


async def test_readings_scatter_as_the_ballbar_does_and_have_its_resolution(posed):
    cell = await posed()

    readings = np.array([shown(cell).deviation_mm for _ in range(1000)])

    # Standard deviation of 1000 draws: 2.2 %, four of these.
    assert readings.std() == pytest.approx(0.00051, rel=0.09)
    assert readings * 1e4 == pytest.approx(np.round(readings * 1e4), abs=1e-6)


async def test_a_ballbar_that_is_laid_aside_shows_its_stop_and_falls_asleep(posed):
    cell = await posed()
    cell.hands.do("connect", LEG)
    cell.hands.do("detach", {})

    at_its_stop = shown(cell)
    await cell.clock.sleep(2.0)
    asleep = shown(cell)

    assert (at_its_stop.signal, at_its_stop.deviation_mm) == ("out_of_range", pytest.approx(1.05))
    assert asleep.signal == "none"
    assert math.isnan(asleep.deviation_mm)


async def test_a_pulled_cable_silences_the_ballbar_until_it_is_in_again(posed):
    cell = await posed(ballbar=wide())
    cell.hands.do("connect", LEG)

    cell.hands.do("pull_cable", {})
    silent, plugged = shown(cell), cell.ballbar.plugged
    cell.hands.do("plug_cable", {})

    assert (silent.signal, plugged) == ("none", False)
    assert (shown(cell).signal, cell.ballbar.plugged) == ("good", True)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
async def test_out_of_range_shows_which_way(posed, sign):
    # The bars of this shop are two millimetres off, so that a pair 300 mm apart is out of range.
    cell = await posed(ballbar=BallbarSetup(nominal_mm=300.0 + 2.0 * sign, travel_mm=5.0))

    cell.hands.do("connect", LEG)

    assert shown(cell).signal == "out_of_range"
    assert shown(cell).deviation_mm == pytest.approx(-1.05 * sign)


async def test_samples_are_counted(posed):
    cell = await posed()

    first, second = shown(cell), shown(cell)

    assert second.sequence == first.sequence + 1
    assert first.temperature_c == pytest.approx(23.0, abs=0.6)  # wave of 0.3, sensor of 0.05


async def test_how_often_somebody_asks_changes_nothing_but_the_noise(posed):
    cells = [await posed(ballbar=wide(noise_mm=0.0, resolution_mm=1e-9)) for _ in range(2)]
    for _ in range(50):
        shown(cells[0])

    for cell in cells:
        cell.hands.do("connect", LEG)

    assert shown(cells[0]).deviation_mm == shown(cells[1]).deviation_mm


async def test_a_moving_robot_changes_the_length_it_is_attached_to(posed):
    cell = await posed(noise=False, ballbar=wide())
    cell.hands.do("connect", LEG)
    before = shown(cell).deviation_mm

    await move(cell, [*POSE[:5], POSE[5] + 0.2])

    assert shown(cell).deviation_mm == pytest.approx(true_mm(cell, **LEG) - 300.0, abs=1e-9)
    assert abs(shown(cell).deviation_mm - before) > 0.01
    assert (cell.hands.accidents, cell.hands.motions_attached) == (0, 1)


async def test_a_motion_beyond_its_travel_tears_the_ballbar_off(posed):
    cell = await posed(ballbar=wide())
    cell.hands.do("connect", LEG)

    await move(cell, OTHER_POSE)

    assert cell.ballbar.seat(cell.clock.now_s) is None
    truth = plant_document(cell)
    assert truth["ballbar"] == {"accidents": 1, "motions_attached": 1}
    assert [cup["position_mm"] for cup in truth["cups"]] == [c.place_mm.tolist() for c in cell.fixture.cups]
    with pytest.raises(HandsError, match="not attached"):
        cell.hands.do("detach", {})


async def test_motions_with_the_ballbar_aside_or_on_its_calibrator_are_no_accident(posed):
    cell = await posed()

    await move(cell, OTHER_POSE)
    cell.hands.do("detach", {})
    await move(cell, POSE)

    assert (cell.hands.accidents, cell.hands.motions_attached) == (0, 0)


async def test_the_fixture_stands_about_where_it_was_put_and_cups_slide_to_the_ball(lrmate):
    cell = lrmate()
    await move(cell, SETUPS[0])
    ball = cell.nests_at_mm(cell.clock.now_s)[0]
    mark = {"placement": 1, **{f"r{axis}_deg": 0.0 for axis in "xyz"}}
    cell.hands.do("fit_ball", {})

    cell.hands.do(
        "place_base", {**mark, **{f"{axis}_mm": float(c) for axis, c in zip("xyz", ball, strict=True)}}
    )
    cell.hands.do("clamp", {"base_point": 1})
    with pytest.raises(HandsError, match=r"cup 2 does not snap on: .* 2[789][0-9]\.[0-9] mm from the ball"):
        cell.hands.do("clamp", {"base_point": 2})

    assert [cup.base_point for cup in cell.fixture.cups] == [1]
    assert cell.fixture.cups[0].place_mm == pytest.approx(ball, abs=0.05)  # 0.01 per axis


async def test_a_fixture_without_a_mark_still_has_its_size(lrmate):
    cell = lrmate()
    cell.hands.do("place_base", {"placement": 1})
    cell.hands.do("fit_ball", {})
    await move(cell, SETUPS[0])
    cell.hands.do("clamp", {"base_point": 1})

    with pytest.raises(HandsError, match="cup 2 does not snap on"):
        cell.hands.do("clamp", {"base_point": 2})


async def test_a_cup_may_be_clamped_again_and_a_fixture_put_down_anew(posed):
    cell = await posed()
    first = {cup.base_point: cup.place_mm for cup in cell.fixture.cups}

    cell.hands.do("fit_ball", {})
    await move(cell, SETUPS[0])
    cell.hands.do("clamp", {"base_point": 1})
    again = {cup.base_point: cup.place_mm for cup in cell.fixture.cups}
    cell.hands.do("place_base", {"placement": 1})

    # Another clamp error and another stop: some hundredths of a millimetre.
    assert 0.0 < np.linalg.norm(again[1] - first[1]) < 0.15
    assert np.array_equal(again[2], first[2])
    assert cell.fixture.cups == ()


async def test_cups_of_earlier_placements_are_remembered(lrmate):
    cell = lrmate()

    await clamp_all(cell, placement=1)
    await clamp_all(cell, placement=2)

    assert [(cup.placement, cup.base_point) for cup in cell.fixture.cups] == [
        (placement, point) for placement in (1, 2) for point in (1, 2, 3)
    ]


async def test_the_same_seed_and_deeds_give_the_same_cell(lrmate):
    cells = [lrmate(), lrmate(), lrmate(seed=3)]
    for cell in cells:
        await clamp_all(cell)

    first, same, other = (np.array([cup.place_mm for cup in cell.fixture.cups]) for cell in cells)
    assert np.array_equal(first, same)
    assert not np.isin(other, first).any()


async def test_a_fixture_shift_moves_the_cups_that_stand(posed):
    cell = await posed(noise=False, ballbar=wide())
    cell.hands.do("connect", LEG)
    before = shown(cell).deviation_mm
    nest = cell.true_positions(cell.conditions_now())[0, LEG["tool"] - 1]
    cup = {cup.base_point: cup.place_mm for cup in cell.fixture.cups}[LEG["base"]]

    soon = cell.clock.now_s + 5.0
    cell.plant_change(PlantedChange("fixture_shift", "placement 1", 0.3, soon, {"direction": [0, 0, 1]}))
    still = shown(cell).deviation_mm
    await cell.clock.sleep(5.0)

    assert still == before
    expected = np.linalg.norm(nest - cup - [0.0, 0.0, 0.3]) - 300.0
    assert shown(cell).deviation_mm == pytest.approx(expected, abs=1e-9)


async def test_effects_of_the_ballbar_spoil_legs_and_not_the_calibrator(posed):
    changes = (
        PlantedChange("instrument_scale", "ballbar", 1e-4),
        PlantedChange("ballbar_zero", "ballbar", 0.01),
    )
    good, bad = [await posed(noise=False, ballbar=wide(), effects=some) for some in ((), changes)]

    on_calibrator = shown(bad).deviation_mm
    off = []
    for _ in range(2):
        for cell in (good, bad):
            cell.hands.do("calibrator", {"bars": "base"})
            cell.hands.do("connect", LEG)
        scaled = 1e-4 * true_mm(bad, **LEG)
        off.append(shown(bad).deviation_mm - shown(good).deviation_mm - scaled)

    assert on_calibrator == pytest.approx(CALIBRATOR_MM - 300.0, abs=1e-9)
    assert all(1e-5 < abs(error) < 0.05 for error in off)
    assert off[0] != pytest.approx(off[1], abs=1e-5)


async def test_a_confused_nest_is_the_one_that_is_read(posed):
    changes = (PlantedChange("label_swap", "nest 1, nest 2", 1.0),)
    cell = await posed(noise=False, ballbar=wide(), effects=changes)

    cell.hands.do("connect", {"base": 3, "tool": 1})

    assert shown(cell).deviation_mm == pytest.approx(true_mm(cell, 3, 2) - 300.0, abs=1e-9)


async def test_a_wild_connection_stays_wild_until_it_is_made_again(posed):
    wild = PlantedChange("outliers", "readings", 0.5, details={"size_mm": 0.2})
    cell = await posed(noise=False, ballbar=wide(), effects=(wild,))

    errors = []
    for _ in range(30):
        cell.hands.do("connect", LEG)
        pair = [shown(cell).deviation_mm + 300.0 - true_mm(cell, **LEG) for _ in range(2)]
        assert pair[0] == pair[1]
        errors.append(round(pair[0], 6))

    assert {-0.2, 0.0, 0.2} == set(errors)
