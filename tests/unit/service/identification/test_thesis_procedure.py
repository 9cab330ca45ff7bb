"""The thesis' procedure: six legs to positions, exact where nothing is wrong; what is missing is named."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.campaigns import ballbar_campaign, places
from truepose.domain.errors import ConfigurationError
from truepose.identification.thesis_procedure import identify_as_thesis, positions_from_legs


def test_six_legs_give_the_positions_of_a_robot_without_errors():
    campaign, true = ballbar_campaign(stops=12, seed=1)

    found = positions_from_legs(campaign)

    points = found.campaign.calibration
    there = places(points.stops.joints_rad, true.nests_mm)[np.arange(len(points)), points.nest - 1]
    assert points.position_mm == pytest.approx(there, abs=1e-6)
    assert found.campaign.legs is None


def test_its_cups_are_where_the_robot_held_the_ball():
    campaign, true = ballbar_campaign(stops=12, placements=2, seed=1)

    cups = positions_from_legs(campaign).cups

    for cup in cups:
        assert cup.centre_mm == pytest.approx(true.cups_mm[cup.placement][cup.base_point - 1], abs=1e-6)


# Table 3.1: standard uncertainty of x, y and z of each nest over that of a length, in every solution.
NEST_1 = [(1.5, 1.6, 0.7)]
NEST_2 = [(1.5, 1.9, 1.1), (1.5, 1.2, 1.6)]
NEST_3 = [(1.6, 2.6, 1.0), (1.1, 2.5, 1.5), (1.0, 2.1, 1.7), (1.6, 2.2, 1.7)]


def test_coordinates_are_as_uncertain_as_lengths_make_them():
    campaign, _ = ballbar_campaign(stops=12, seed=1)
    variances = [np.mean(np.square(nest)) for nest in (NEST_1, NEST_2, NEST_3)]

    points = positions_from_legs(campaign).campaign.calibration

    expected_mm = np.sqrt(np.mean(variances)) * campaign.legs.standard_uncertainty_mm[0]
    assert points.standard_uncertainty_mm == pytest.approx(expected_mm, rel=0.01)


def test_a_configuration_with_five_legs_is_lost_and_named():
    campaign, _ = ballbar_campaign(stops=12, seed=1)
    legs = campaign.legs
    kept = np.flatnonzero(~((legs.stops.config == 103) & (legs.base_point == 3)))
    fewer = replace(
        legs,
        stops=replace(legs.stops, config=legs.stops.config[kept], joints_rad=legs.stops.joints_rad[kept]),
        **{
            name: getattr(legs, name)[kept]
            for name in ("placement", "base_point", "nest", "length_mm", "standard_uncertainty_mm")
        },
    )

    found = positions_from_legs(replace(campaign, legs=fewer))

    assert found.lost == (103,)


def test_a_side_that_was_not_measured_is_named():
    campaign, _ = ballbar_campaign(stops=12, seed=1)
    fixture = campaign.fixture
    kept = np.flatnonzero(~((fixture.placement == 1) & (fixture.point_a == 2) & (fixture.point_b == 3)))
    open_triangle = replace(
        fixture,
        **{
            name: getattr(fixture, name)[kept]
            for name in ("placement", "point_a", "point_b", "length_mm", "standard_uncertainty_mm")
        },
    )

    with pytest.raises(ConfigurationError, match=r"Side 2-3 of placement 1 was not measured"):
        positions_from_legs(replace(campaign, fixture=open_triangle))


def test_it_is_judged_by_positions_tied_with_its_own_cups():
    campaign, _ = ballbar_campaign(stops=40, seed=1)

    answer, _ = identify_as_thesis(campaign)

    assert answer.quantity == "position"
    assert answer.positions.tied.identified.max_mm < 1e-3  # priors of springs that hardly move hold the rest
