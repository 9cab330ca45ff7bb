"""What is hidden: drawn from the seed, scaled as a whole, written as a scenario file."""

import pickle
import tomllib

import pytest

from tests.studies.diagnosis_report.planted.cases import (
    BARELY_VISIBLE,
    FOR_INFORMATION,
    REALISTIC,
    pairs_alike,
    pairs_of,
)
from tests.studies.diagnosis_report.planted.planting import scaled, scenario_text
from truepose.domain.diagnosis import Cause

EVERY = (*REALISTIC, *FOR_INFORMATION, *BARELY_VISIBLE)


def case(part):
    (found,) = (one for one in EVERY if part in one.label)
    return found


def test_a_seed_hides_the_same_again():
    wave = case("wave of joint 6")

    assert wave.planted(3, 100) == wave.planted(3, 100)


def test_orders_of_waves_go_from_once_per_turn_to_twice_the_gear_ratio():
    wave = case("wave of joint 6")

    orders = {wave.planted(seed, 100).order for seed in range(2000)}

    # 100 orders, each missed by 2,000 draws with a chance of 2e-9.
    assert orders == set(range(1, 101))


def test_a_jump_comes_in_the_middle_of_the_campaign():
    jumps = [case("jumps").planted(seed, 50).from_s for seed in range(50)]

    assert min(jumps) >= 0.4 * 50 * 28
    assert max(jumps) <= 0.6 * 50 * 28


def test_twice_as_large_turns_twice_as_far_and_is_right_at_twice_the_amplitude():
    reseated = scaled(case("reseats").planted(1, 100), 2.0)

    assert reseated.amplitude == pytest.approx(0.06)
    assert reseated.details["rotation_rad"] == pytest.approx(6e-4)
    assert reseated.right == {Cause("tool_reseating", "tool"): pytest.approx(0.06)}


def test_a_wave_twice_as_large_keeps_its_order():
    wave = case("order 202")

    assert wave.planted(1, 100, factor=2.0).order == 202.0


def test_bad_readings_become_worse_and_not_more():
    bad = case("readings off").planted(1, 100, factor=2.0)

    assert bad.amplitude == pytest.approx(0.03)
    assert bad.details["size_mm"] == pytest.approx(0.6)


def test_backlash_of_all_joints_may_be_named_joint_by_joint():
    backlash = case("backlash").planted(1, 100, factor=2.0)

    assert backlash.right[Cause("backlash", "joints")] == pytest.approx(0.074)
    assert backlash.right[Cause("backlash", "joint 5")] == pytest.approx(0.034)


@pytest.mark.parametrize("one", EVERY, ids=lambda one: one.label)
def test_every_case_is_a_scenario_that_can_go_to_another_process(one):
    planted = one.planted(5, 100)

    document = tomllib.loads(scenario_text("irb120-tilted", (planted,)))

    (effect,) = document["effect"]
    assert (effect["name"], effect["subject"]) == (planted.effect, planted.subject)
    assert effect["amplitude"] == planted.amplitude
    assert {key: effect[key] for key in planted.details} == dict(planted.details)
    assert pickle.loads(pickle.dumps(planted)) == planted


def test_a_scenario_may_have_heavy_tails_and_stand_still():
    document = tomllib.loads(scenario_text("irb120-everyday", (), heavy_tails=True, over_time=False))

    assert document == {
        "extends": "irb120-everyday",
        "tracker": {"noise_degrees_of_freedom": 4.0},
        "everyday": {"over_time": False},
    }


def test_every_pair_of_cases_is_listed_once():
    together, apart = pairs_of(REALISTIC), pairs_alike(REALISTIC)

    assert len({frozenset((a.label, b.label)) for a, b in (*together, *apart)}) == 18 * 17 // 2
    assert [{one.planted(0, 100).effect for one in pair} for pair in apart] == [{"base_drift", "base_shift"}]
