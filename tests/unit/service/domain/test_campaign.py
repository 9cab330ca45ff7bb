"""What a campaign is identified from, and what judges it: of one kind, positions before lengths."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.synthetic import leg_campaign, nominal_campaign
from truepose.identification.problem.problem_setup import outline

POINTS, LEGS = nominal_campaign(12), leg_campaign(12)
BOTH = replace(POINTS, legs=LEGS.legs)


def test_positions_come_before_lengths():
    assert BOTH.readings is BOTH.calibration
    assert LEGS.readings is LEGS.legs
    assert replace(LEGS, legs=None).readings is None


@pytest.mark.parametrize(
    ("campaign", "held_out"),
    [
        (replace(POINTS, validation=POINTS.calibration, validation_legs=LEGS.legs), POINTS.calibration),
        (replace(POINTS, validation_legs=LEGS.legs), None),  # lengths judge no model of positions
        (replace(LEGS, validation=POINTS.calibration), None),  # nor positions one of lengths: frames differ
        (replace(LEGS, validation_legs=LEGS.legs), LEGS.legs),
    ],
)
def test_a_model_is_judged_by_readings_of_the_kind_that_made_it(campaign, held_out):
    assert campaign.held_out is held_out


NOTHING = POINTS.calibration.taken(np.zeros(0, dtype=np.int64))


def test_an_empty_table_judges_nothing():
    assert replace(POINTS, validation=NOTHING).held_out is None


def test_an_empty_table_beside_others_counts_for_none_of_the_questions():
    campaign = replace(LEGS, calibration=NOTHING, validation=POINTS.calibration, validation_legs=LEGS.legs)

    assert campaign.identified_from == "legs"
    assert campaign.readings is LEGS.legs
    assert campaign.held_out is LEGS.legs
    assert (
        campaign.of_rows(np.array([3, 1])).readings.length_mm.tolist() == LEGS.legs.length_mm[[3, 1]].tolist()
    )
    assert outline(campaign).lengths


def test_an_empty_campaign_is_identified_from_nothing():
    campaign = replace(POINTS, calibration=NOTHING)

    assert (campaign.identified_from, campaign.readings, campaign.held_out) == (None, None, None)
    assert campaign.of_rows(np.zeros(0, dtype=np.int64)) is campaign


@pytest.mark.parametrize("campaign", [POINTS, LEGS])
def test_some_rows_are_those_of_the_readings_that_identify(campaign):
    some = campaign.of_rows(np.array([3, 1]))

    assert some.readings.stops.config.tolist() == campaign.readings.stops.config[[3, 1]].tolist()
    assert some.readings.observed_mm.tolist() == campaign.readings.observed_mm[[3, 1]].tolist()


def test_scatter_within_the_stated_uncertainty_is_not_added_to_it():
    assert POINTS.scatter_mm == POINTS.robot.repeatability_mm > 0.0
    assert replace(POINTS, repeatability_in_uncertainty=True).scatter_mm == 0.0
