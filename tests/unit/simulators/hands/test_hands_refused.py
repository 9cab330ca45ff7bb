"""What a person's hands cannot do, or must wait with."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.simulators.hands.deeds import (
    LEG,
    OTHER_POSE,
    POSE,
    SETUPS,
    move,
    shown,
    wide,
)
from truepose_simulators.cell.robot import SpeedLimits
from truepose_simulators.errors import HandsError
from truepose_simulators.physics.effects import PlantedChange


@pytest.mark.parametrize(
    ("action", "details", "sentence"),
    [
        ("wave", {}, 'no action "wave"; known: calibrator, connect'),
        ("connect", {"base": 1}, 'action connect: key "tool" is missing'),
        ("connect", {"base": 1, "tool": "1"}, 'key "tool" must be a whole number'),
        ("connect", {"base": 1, "tool": 2, "speed": 3}, 'unknown key "speed"'),
        ("connect", {"base": 4, "tool": 2}, "cup 4 is not clamped in placement 1"),
        ("connect", {"base": 3, "tool": 4}, "no nest 4 on the tool: it has 3"),
        ("connect", {"base": 2, "tool": 3}, "does not fit between B2 and T3: they are"),
        ("side", {"artefact": "tool", "a": 1, "b": 2}, "with the tool bars first"),
        ("side", {"artefact": "base", "a": 1, "b": 1}, "two different points"),
        ("side", {"artefact": "leg", "a": 1, "b": 2}, 'key "artefact" must be "tool" or "base"'),
        ("calibrator", {"bars": "long"}, 'key "bars" must be "tool" or "base"'),
        ("remove_ball", {}, "no setting ball in the tool"),
        ("clamp", {"base_point": 1}, "fit the setting ball in nest 1 first"),
        ("plug_cable", {}, "already plugged in"),
        ("place_base", {"placement": 0}, "count from 1"),
        ("place_base", {"placement": 1, "x_mm": 0.0}, "state all of them or none"),
    ],
)
async def test_what_cannot_be_done_is_refused_with_its_reason(posed, action, details, sentence):
    cell = await posed()
    before = cell.ballbar.seat(cell.clock.now_s)

    with pytest.raises(HandsError, match=sentence):
        cell.hands.do(action, details)

    assert cell.ballbar.seat(cell.clock.now_s) == before


@pytest.mark.parametrize(
    ("action", "details", "sentence"),
    [
        ("place_base", {"placement": 2}, "between B3 and T2: detach it before the base fixture is moved"),
        ("fit_ball", {}, "detach it before the setting ball is fitted"),
        ("pull_cable", {}, None),
        ("connect", {"base": 1, "tool": 2}, None),
        ("calibrator", {"bars": "base"}, None),
    ],
)
async def test_with_the_ballbar_attached_some_things_must_wait(posed, action, details, sentence):
    cell = await posed()
    cell.hands.do("connect", LEG)

    if sentence is None:
        cell.hands.do(action, details)
    else:
        with pytest.raises(HandsError, match=sentence):
            cell.hands.do(action, details)


async def test_the_ball_stands_in_the_way_of_nest_1_and_is_fitted_once(posed):
    cell = await posed()
    cell.hands.do("fit_ball", {})

    with pytest.raises(HandsError, match="the setting ball is in nest 1"):
        cell.hands.do("connect", {"base": 3, "tool": 1})
    with pytest.raises(HandsError, match="the setting ball is already in nest 1"):
        cell.hands.do("fit_ball", {})


async def test_the_ball_stays_while_the_robot_holds_it_in_a_clamped_cup(lrmate):
    cell = lrmate()
    cell.hands.do("place_base", {"placement": 1})
    cell.hands.do("fit_ball", {})
    await move(cell, SETUPS[0])
    cell.hands.do("clamp", {"base_point": 1})

    with pytest.raises(HandsError, match=r"nest 1 0\.\d mm from cup 1: have it back off .* taken out"):
        cell.hands.do("remove_ball", {})
    await move(cell, POSE)
    cell.hands.do("remove_ball", {})

    assert not cell.hands.ball_fitted


async def test_no_side_of_the_base_is_connected_at_the_cup_over_which_the_robot_stands(posed):
    cell = await posed(ballbar=wide())
    await move(cell, SETUPS[2])

    for a, b in ((1, 3), (3, 2)):
        with pytest.raises(HandsError, match=r"nest 1 0\.\d mm from cup 3: have it back off at least 60 mm"):
            cell.hands.do("side", {"artefact": "base", "a": a, "b": b})
    cell.hands.do("side", {"artefact": "base", "a": 1, "b": 2})

    assert shown(cell).signal == "good"


async def test_a_ball_that_no_cup_was_clamped_on_comes_out_anywhere(lrmate):
    cell = lrmate()
    cell.hands.do("fit_ball", {})
    cell.hands.do("remove_ball", {})

    assert not cell.hands.ball_fitted


def test_before_anything_is_there_nothing_can_be_connected(lrmate):
    hands = lrmate().hands
    with pytest.raises(HandsError, match="put it on the calibrator with the base bars first"):
        hands.do("connect", LEG)

    hands.do("calibrator", {"bars": "base"})
    with pytest.raises(HandsError, match="the base fixture is not in place yet"):
        hands.do("connect", LEG)

    hands.do("fit_ball", {})
    with pytest.raises(HandsError, match="the base fixture is not in place yet"):
        hands.do("clamp", {"base_point": 1})


async def test_hands_stay_away_from_a_moving_robot(posed):
    cell = await posed()
    cell.robot.start([np.radians(OTHER_POSE)], SpeedLimits(), np.zeros(3), cell.clock.now_s)

    for action, details in (("connect", LEG), ("fit_ball", {}), ("clamp", {"base_point": 1})):
        with pytest.raises(HandsError, match="the robot is moving: wait until it stands still"):
            cell.hands.do(action, details)


async def test_an_everyday_cell_stands_still_for_a_second_and_moves_over_minutes(lrmate):
    cell = lrmate("lrmate-everyday")

    first = cell.nests_at_mm(10.0)
    same_second, later = cell.nests_at_mm(10.9), cell.nests_at_mm(1810.0)

    assert np.array_equal(first, same_second)
    # Half an hour of warming up by most of 1.35 K: 18 um/K over half a metre.
    assert 0.001 < np.abs(later - first).max() < 0.05


async def test_a_change_that_begins_within_the_second_is_not_missed(lrmate):
    shift = PlantedChange("base_shift", "base", 0.5, 10.4, {"direction": [0, 0, 1]})
    cell = lrmate(effects=(shift,))

    before, after = cell.nests_at_mm(10.3), cell.nests_at_mm(10.5)

    assert (after - before)[:, 2] == pytest.approx([0.5, 0.5, 0.5], abs=1e-9)


def test_the_new_parts_of_the_cell_leave_the_tracker_as_it_was(make_cell):
    plain = make_cell()
    other = make_cell(ballbar=replace(plain.scenario.ballbar, noise_mm=0.1))

    assert np.array_equal(plain.plant.motions, other.plant.motions)
    assert np.array_equal(plain.tracker.frame, other.tracker.frame)


async def test_a_ballbar_in_a_hand_moves_and_is_mostly_out_of_range(posed):
    cell = await posed(noise=False)
    cell.hands.do("connect", LEG)

    cell.hands.do("hold", {})

    seen = [cell.ballbar.sample(cell.clock.now_s + 0.05 * n) for n in range(40)]
    assert {sample.signal for sample in seen} == {"good", "out_of_range"}
    assert sum(sample.signal == "good" for sample in seen) < 20
    inside = [sample.deviation_mm for sample in seen if sample.signal == "good"]
    assert max(inside) - min(inside) > 0.5
    await move(cell, OTHER_POSE)
    assert (cell.hands.accidents, cell.hands.motions_attached) == (0, 0)


async def test_a_ballbar_that_is_switched_off_says_nothing_and_is_torn_off_all_the_same(posed):
    cell = await posed(ballbar=wide())
    cell.hands.do("connect", LEG)

    cell.hands.do("switch_off", {})

    assert shown(cell).signal == "none"
    with pytest.raises(HandsError, match="already switched off"):
        cell.hands.do("switch_off", {})
    await move(cell, OTHER_POSE)
    assert cell.hands.accidents == 1
    cell.hands.do("switch_on", {})
    cell.hands.do("calibrator", {"bars": "base"})
    assert shown(cell).signal == "good"
