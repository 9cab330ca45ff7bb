"""Validation readings in the curves of findings: what the model without the finding leaves on them."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.selections import make_selected, started, with_unseen
from truepose.diagnosis.curves import curve_with_unseen, finding_curve, unseen_of

EFFECTS = {"joint_gain": {"gain_4": 1e-3}, "backlash": {"gap_2": np.deg2rad(0.02)}}


@pytest.fixture(scope="module")
def start():
    return started(with_unseen(EFFECTS))


@pytest.fixture(scope="module")
def selected(start):
    picked = [("joint_gain", "joint 4", None), ("backlash", "joint 2", None), ("base_drift", "base", None)]
    return make_selected(start, picked)


def drawn(start, selected, effect):
    group = tuple(pick for pick in selected.picks if pick.effect == effect)
    curve = finding_curve(selected, start.scene, group)
    return curve_with_unseen(curve, unseen_of(start, selected), group)


def test_they_stand_where_they_were_measured_and_on_the_line(start, selected):
    curve = drawn(start, selected, "joint_gain")

    turns_deg = np.rad2deg(start.campaign.validation.stops.joints_rad[:, 3])
    assert set(curve.unseen.x.round(6)) <= set(turns_deg.round(6))
    assert len(curve.unseen.x) > 0.9 * len(turns_deg)
    line = np.interp(curve.unseen.x, curve.line_x, curve.line)
    off = (curve.unseen.residual - line) / curve.unseen.standard_uncertainty
    # what the parameters are not known adds little to noise of one component
    assert np.sqrt((off**2).mean()) < 1.5
    assert np.corrcoef(curve.unseen.residual, curve.unseen.x)[0, 1] > 0.9


def test_the_curve_itself_stays_that_of_the_readings_that_were_fitted(start, selected):
    group = tuple(pick for pick in selected.picks if pick.effect == "joint_gain")
    plain = finding_curve(selected, start.scene, group)

    curve = drawn(start, selected, "joint_gain")

    assert plain.unseen is None
    assert np.array_equal(curve.x, plain.x)
    assert np.array_equal(curve.line, plain.line)


def test_levels_are_those_that_the_readings_came_from(start, selected):
    curve = drawn(start, selected, "backlash")

    assert set(curve.unseen.x) == {-1.0, 1.0}


def test_what_is_drawn_in_a_unit_of_its_own_readings_is_left_alone(start, selected):
    assert drawn(start, selected, "base_drift").unseen is None


def test_without_validation_readings_nothing_is_added(start, selected):
    alone = replace(start, campaign=replace(start.campaign, validation=None))

    assert unseen_of(alone, selected) is None
    assert drawn(alone, selected, "joint_gain").unseen is None


def test_where_there_is_no_curve_there_is_nothing_to_add_to(start, selected):
    assert curve_with_unseen(None, unseen_of(start, selected), selected.picks[:1]) is None
