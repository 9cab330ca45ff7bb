"""Rivals: what these data cannot tell from a pick; wholes and parts are no rivals of each other."""

from dataclasses import replace

import pytest

from tests.helpers.diagnosis.point_scenes import ORIGIN_S
from tests.helpers.diagnosis.selections import make_selected, make_start
from truepose.diagnosis.alternatives import weigh_alternatives
from truepose.diagnosis.screening.candidates import pool_candidates
from truepose.domain.diagnosis import Cause

GAIN = ("joint_gain", "joint 4")
SLOW_WAVE = ("joint_harmonics", "joint 4", "wave_4_1_sin")


def rivals_of(start, pick, *others, structure_left=False):
    selected = make_selected(start, [pick], others)
    return weigh_alternatives(selected, selected.picks, structure_left=structure_left)


@pytest.fixture(scope="module")
def small_gain():
    """So small that over 300 deg of joint 4 a slow wave is only 15 behind in BIC."""
    return make_start({"joint_gain": {"gain_4": 6e-5}})


@pytest.fixture(scope="module")
def large_gain():
    return make_start({"joint_gain": {"gain_4": 2e-3}})


def test_a_small_gain_and_a_slow_wave_of_the_same_joint_are_rivals(small_gain):
    found = rivals_of(small_gain, GAIN, SLOW_WAVE)

    assert found.rivals == (Cause("joint_harmonics", "joint 4"),)


def test_a_gain_that_stands_out_has_no_rival(large_gain):
    found = rivals_of(large_gain, GAIN, SLOW_WAVE, ("joint_gain", "joint 2"), ("nest_offset", "nest 1"))

    assert found.rivals == ()
    assert found.p_value < 1e-6


@pytest.mark.parametrize(
    "changes", [{"subject": "joint 6"}, {"variant": 3.0}, {"effect": "nest_offset"}], ids=str
)
def test_as_far_behind_what_differs_in_more_than_the_shape_of_a_slow_curve_is_none(small_gain, changes):
    selected = make_selected(small_gain, [GAIN], [SLOW_WAVE])
    pick, wave = selected.pool.all
    renamed = replace(selected.pool, all=(pick, wave._replace(**changes)))  # with the same columns

    found = weigh_alternatives(replace(selected, pool=renamed), selected.picks, structure_left=False)

    assert found.rivals == ()


def test_one_joint_is_no_rival_of_all_joints():
    start = make_start({"backlash": {"backlash_3": 4e-4}})
    one, every = ("backlash", "joint 3"), ("backlash", "joints")

    assert Cause(*every) not in rivals_of(start, one, every).rivals


def test_a_rival_is_named_once_however_many_of_its_ways_come_close(small_gain):
    selected = make_selected(small_gain, [GAIN], [SLOW_WAVE])
    pick, wave = selected.pool.all
    pool = pool_candidates(selected.fit, (pick, wave, wave._replace(variant=1.5)))

    found = weigh_alternatives(replace(selected, pool=pool), selected.picks, structure_left=False)

    assert found.rivals == (Cause("joint_harmonics", "joint 4"),)


def test_beside_unexplained_structure_a_rival_must_fall_further_behind():
    # the wave is more than 20 behind, but less than 15 % of what the gain explains
    start = make_start({"joint_gain": {"gain_4": 9e-5}})

    assert rivals_of(start, GAIN, SLOW_WAVE).rivals == ()
    assert rivals_of(start, GAIN, SLOW_WAVE, structure_left=True).rivals == (Cause(*SLOW_WAVE[:2]),)


def test_a_named_cause_has_a_rival_in_a_cell_without_a_name_that_explains_as_much():
    """A first joint whose zero jumped turns the arm as a base does that turned on its foot."""
    moment = f"{ORIGIN_S + 30.0 * 39.5:.0f}"
    start = make_start({"unnamed": {f"cell_jump_1_{moment}_turn": 3e-4}})
    pick = ("base_shift", "base", f"jump_{moment}_x")
    jump = ("unnamed", "joint 1, time, jump", f"cell_jump_1_{moment}_turn")

    assert rivals_of(start, pick, jump).rivals == (Cause(*jump[:2]),)
    assert rivals_of(start, jump, pick).rivals == ()


def test_the_same_place_and_variable_in_a_shape_without_a_name_is_a_rival_by_the_usual_margin_only():
    # a wave of the angle of joint 5 is 14 in BIC behind this coupling: between the two margins
    start = make_start({"joint_coupling": {"coupling_6_5": 4e-4}})
    wave = ("unnamed", "joint 6, angle of joint 5, wave", "cell_cross_6-5_1_sin")

    found = rivals_of(start, ("joint_coupling", "joint 6", "coupling_6_5"), wave)

    assert found.rivals == ()
