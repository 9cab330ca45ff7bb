"""Readings that no place of the arm gives take no part, and the model is that of the data without them."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.synthetic import leg_campaign, measured, nominal_campaign, shifted
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.identification import Status
from truepose.identification import identify
from truepose.identification.observations.blocks import whitener
from truepose.identification.verdict.outliers import within_reach
from truepose.messages.catalogue import english

ROW = 7
IMPOSSIBLE = [1e4, -1e4, 1e6, 1e9, -1e12, 1e29, 1e300, np.inf, np.nan]


@pytest.fixture(scope="module")
def campaign():
    return measured(nominal_campaign(40), effects=("base", "geometry"))[0]


@pytest.fixture(scope="module")
def without(campaign):
    """What the campaign gives without the row."""
    spoilt = with_position(campaign, 1e9, 0)
    return identify(within_reach(spoilt).campaign, ("base", "geometry"))


def with_position(campaign, value, axis):
    position = campaign.calibration.position_mm.copy()
    position[ROW, axis] = value
    return replace(campaign, calibration=replace(campaign.calibration, position_mm=position))


def values_of(answer):
    return [parameter.value for parameter in answer.parameters]


@pytest.mark.parametrize("value", IMPOSSIBLE)
@pytest.mark.parametrize("axis", [0, 2])
def test_one_impossible_position_leaves_the_model_as_it_is_without_it(campaign, without, value, axis):
    answer = identify(with_position(campaign, value, axis), ("base", "geometry"))

    assert answer.status is Status.CONVERGED
    assert values_of(answer) == values_of(without)
    (outlier,) = answer.outliers
    assert (outlier.row, outlier.config) == (ROW, campaign.calibration.stops.config[ROW])
    assert "impossible for this arm" in english(outlier.reason)
    assert "1 reading beyond the reach of this arm was excluded before the fit" in english(answer.message)
    assert answer.counts.outliers == answer.model.identified_from["readings_without_weight"] == 1
    assert answer.model.identified_from["readings"] == len(campaign.calibration)


@pytest.mark.parametrize("value", [1e5, *IMPOSSIBLE[2:]])
def test_one_impossible_length_is_set_aside(value):
    campaign = leg_campaign(120)
    length = campaign.legs.length_mm.copy()
    length[ROW] = value

    reached = within_reach(replace(campaign, legs=replace(campaign.legs, length_mm=length)))

    assert [outlier.row for outlier in reached.outliers] == [ROW]
    assert ROW not in reached.rows
    assert len(reached.campaign.legs) == len(campaign.legs) - 1


def test_outliers_keep_the_rows_of_their_table(campaign):
    spoilt = shifted(with_position(campaign, 1e6, 1), [20], 5.0)

    answer = identify(spoilt, ("base", "geometry"))

    assert [outlier.row for outlier in answer.outliers] == [ROW, 20]
    assert answer.outliers[1].config == campaign.calibration.stops.config[20]


def test_joints_that_nobody_meant_are_an_outlier_and_no_harm(campaign, without):
    joints = campaign.calibration.stops.joints_rad.copy()
    joints[ROW, 2] = np.radians(1e4)
    stops = replace(campaign.calibration.stops, joints_rad=joints)

    answer = identify(
        replace(campaign, calibration=replace(campaign.calibration, stops=stops)), ("base", "geometry")
    )

    assert [outlier.row for outlier in answer.outliers] == [ROW]
    np.testing.assert_allclose(values_of(answer), values_of(without), atol=1e-6)


def test_many_readings_far_away_are_no_accident_and_stay_for_the_verdict(campaign):
    rows = np.arange(12)

    assert within_reach(shifted(campaign, rows, 1e5)).outliers == ()


def test_a_campaign_within_reach_is_left_alone(campaign):
    assert within_reach(campaign).campaign is campaign


def test_a_diagnosis_sets_them_aside_and_says_so(campaign):
    answer = diagnose(with_position(campaign, 1e29, 0), ("base", "geometry"))

    assert answer.after.max_mm < 1.0
    assert answer.model.identified_from["readings_without_weight"] == 1
    assert "1 reading beyond the reach of this arm was excluded before the fit" in english(answer.message)


def test_a_reading_without_weight_has_no_part_however_far_off_it_is():
    residual = np.array([[0.1, 0.2, 0.3], [1e12, -1e12, 1e12], [0.3, 0.1, 0.2]])
    weights, stop = np.array([1.0, 0.0, 1.0]), np.array([1, 1, 2])
    scatter = np.broadcast_to(0.05 * np.eye(3), (3, 3, 3))

    white = whitener(np.broadcast_to(1e-4 * np.eye(3), (3, 3, 3)), weights, stop, scatter).apply(residual)
    alone = whitener(np.full((1, 1, 1), 1e-4) * np.eye(3), np.ones(1), np.ones(1), scatter[:1])

    assert np.abs(white[1]).max() == 0.0
    np.testing.assert_allclose(white[0], alone.apply(residual[:1])[0], rtol=1e-12)


@pytest.mark.parametrize("u_mm", [100.0, 1000.0])
def test_readings_that_say_nothing_do_not_converge(campaign, u_mm):
    coarse = replace(campaign.calibration, standard_uncertainty_mm=np.full(len(campaign.calibration), u_mm))

    answer = identify(replace(campaign, calibration=coarse), ("base", "geometry"))

    assert answer.status is Status.TOO_FEW_DATA
    assert f"standard uncertainty of {u_mm:.3g} mm each (u_mm), they are too inaccurate" in english(
        answer.message
    )
