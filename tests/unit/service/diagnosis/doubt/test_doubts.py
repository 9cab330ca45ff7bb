"""Doubts: what owes its place to the rest is found out, and a smooth family may tell the story better."""

import pytest

from tests.helpers.diagnosis.selections import left_of, make_selected, make_start
from truepose.diagnosis.confidence import better_families, owed_to_the_rest
from truepose.diagnosis.evidence.residual_structure import prepared_families, score_families

GAIN = ("joint_gain", "joint 4")
# no single wave and no gain: five waves of joint 4 at once
CURVE = {f"wave_4_{order}_{wave}": 3e-4 / order for order in (1, 2, 3, 4, 5) for wave in ("cos", "sin")}


@pytest.fixture(scope="module")
def honest():
    """A gain that is there, and picked."""
    start = make_start({"joint_gain": {"gain_4": 1e-3}})
    return start, make_selected(start, [GAIN])


@pytest.fixture(scope="module")
def borrowed():
    """A gain that is not there, picked because the joint's angle matters in another way."""
    start = make_start({"joint_harmonics": CURVE})
    return start, make_selected(start, [GAIN])


def better(start, selected):
    return better_families(selected, selected.picks, prepared_families(selected.fit, start.scene))


def owed(start, selected):
    return owed_to_the_rest(selected, [selected.picks], left_of(start, selected))


def test_a_cause_that_is_there_owes_nothing_to_the_rest(honest):
    assert owed(*honest) == (False,)


def test_a_cause_beside_an_unrelated_structure_owes_nothing_to_it():
    start = make_start({"joint_gain": {"gain_4": 1e-3}, "base_drift": {"drift_linear_x": 0.4}})
    selected = make_selected(start, [GAIN])
    left = left_of(start, selected)

    assert any(one.kind == "time" for one in left.depends)
    assert owed_to_the_rest(selected, [selected.picks], left) == (False,)


def test_a_cause_that_stands_in_for_another_curve_owes_its_place_to_it(borrowed):
    start, selected = borrowed
    left = left_of(start, selected)

    assert any(one.variable == "angle of joint 4" for one in left.depends)
    assert owed_to_the_rest(selected, [selected.picks], left) == (True,)


def test_every_group_is_asked_and_none_where_there_is_none(borrowed):
    start, selected = borrowed
    left = left_of(start, selected)

    assert owed_to_the_rest(selected, [], left) == ()
    assert len(owed_to_the_rest(selected, [selected.picks, selected.picks], left)) == 2


def test_the_right_name_tells_the_story_better_than_any_smooth_family(honest):
    assert better(*honest) == ()


def test_a_wrong_name_is_beaten_by_the_family_of_its_own_variable(borrowed):
    (family,) = better(*borrowed)

    assert (family.variable, family.joint) == ("angle of joint 4", 3)


def test_the_chance_of_a_better_family_is_that_of_its_own_score_test(borrowed):
    start, selected = borrowed
    families = prepared_families(selected.fit, start.scene)

    (relation,) = better_families(selected, selected.picks, families)

    past = selected.pool.normal.past(without=("gain_4",))
    (own,) = [one for one in score_families(families, past) if one.products is relation.products]
    # Ten waves of up to 0.3 mrad, in readings of 15 um at 300 mm: no chance gives that.
    assert relation.p_value == own.p_value < 1e-9


@pytest.mark.parametrize("seed", [8, 13])
def test_an_even_drift_does_not_pay_for_the_settling_ones_that_were_searched(seed):
    """Four time constants were searched, 2 ln 5 = 3.2 in BIC; the plain drift was not (variant 0)."""
    start = make_start({"base_drift": {"drift_linear_x": 0.07}}, seed=seed)
    drift = ("base_drift", "base")

    alone, among_others = make_selected(start, [drift]), make_selected(start, [drift], [drift])

    assert better(start, alone) == better(start, among_others) == ()


def test_no_family_is_better_where_there_is_none(honest):
    _, selected = honest

    assert better_families(selected, selected.picks, ()) == ()
