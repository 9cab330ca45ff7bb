"""Triangles and clamped cups as observations: exact derivatives, and what they settle."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.campaigns import ballbar_campaign
from tests.helpers.identification.differences import require_alike
from truepose.domain.campaign import CupSetups, LegReadings, Stops
from truepose.identification import identify
from truepose.identification.model.structure import anchor_places
from truepose.identification.observations.blocks import linearise_blocks
from truepose.identification.observations.fixture import ClampBlock, SideBlock
from truepose.identification.observations.legs import LegBlock
from truepose.identification.problem.build import build

EFFECTS = ("geometry", "compliance")
BALANCED_MM = 1e-5  # torques are balanced to 1e-5: 2e-8 rad at half a metre


def test_legs_come_first_then_sides_then_clamped_cups():
    campaign, _ = ballbar_campaign()

    blocks = build(campaign, EFFECTS).blocks

    assert [type(block) for block in blocks] == [LegBlock, SideBlock, ClampBlock]
    # Sides and cups are no configurations: their numbers are below all of these, and each its own.
    numbers = np.concatenate([block.targets.stops.config for block in blocks[1:]])
    assert numbers.max() < 0
    assert len(set(numbers)) == len(numbers)


def test_a_campaign_of_legs_alone_has_legs_alone():
    campaign, _ = ballbar_campaign()

    blocks = build(replace(campaign, fixture=None, setup=None), EFFECTS).blocks

    assert [type(block) for block in blocks] == [LegBlock]


@pytest.mark.parametrize("which", [1, 2])
def test_sides_and_clamped_cups_are_differentiated_exactly(which):
    campaign, _ = ballbar_campaign(placements=2, cups=4)
    problem = build(campaign, ("geometry",))  # loads of springs are held while a step is differentiated
    structure, block = problem.structure, problem.blocks[which]
    values = problem.start + 0.2 * np.minimum(structure.prior_widths, 1.0) * np.random.default_rng(
        1
    ).standard_normal(len(problem.start))

    # residuals of 0.001 mm to 1 mm in units of 1 to 10 um: central differences are good to 1e-6 of them
    require_alike(
        structure,
        (block,),
        values,
        rel=1e-5,
        smallest=1.0,
        step_of=lambda spec: 1e-4 * min(spec.prior_width, 1.0),
    )


def test_a_robot_without_errors_closes_to_nothing():
    campaign, _ = ballbar_campaign(placements=2)

    answer = identify(campaign)

    assert answer.calibration.identified.max_mm < BALANCED_MM
    assert answer.positions.tied.identified.max_mm < 1e-4
    assert answer.effects == ("geometry", "compliance")


def test_sides_of_cups_without_legs_and_set_ups_of_them_are_left_out():
    campaign, _ = ballbar_campaign(cups=4)
    blocks = build(campaign, EFFECTS).blocks

    assert len(blocks[1].length_mm) == 6, "three sides of the tool, three of the cups that have legs"
    assert len(blocks[2].anchor) == 3


def test_a_fourth_cup_with_legs_is_tied_like_the_others():
    campaign, _ = ballbar_campaign(cups=4, pattern=((1, 1), (2, 1), (2, 2), (2, 3), (3, 2), (4, 3)))

    answer = identify(campaign)

    assert answer.calibration.identified.max_mm < BALANCED_MM
    assert {anchor.base_point for anchor in answer.model.nominal_anchors} == {1, 2, 3, 4}


def test_a_cup_whose_legs_come_round_regularly_is_placed_as_well():
    campaign, true = ballbar_campaign(stops=60, placements=2)  # every sixth of 720 legs is to cup 3

    model = identify(campaign, ("geometry",)).model

    for anchor in model.nominal_anchors:
        assert anchor.centre_mm == pytest.approx(
            true.cups_mm[anchor.placement][anchor.base_point - 1], abs=1e-4
        )


def test_a_triangle_that_contradicts_the_certificate_moves_the_nests_and_not_the_cups():
    off = np.array([[0.0, 0.0, 0.0], [0.03, 0.0, 0.0], [0.0, 0.0, 0.0]])
    campaign, true = ballbar_campaign(nests_off_mm=off)

    model = identify(campaign).model

    value = {parameter.name: parameter.value for parameter in model.parameters}
    found = np.array([[value[f"certified_{nest}_{axis}"] for axis in "xyz"] for nest in (1, 2, 3)])
    sides = [
        np.linalg.norm(
            found[a] - found[b] + np.subtract(campaign.nests[a].centre_mm, campaign.nests[b].centre_mm)
        )
        for a, b in ((0, 1), (1, 2), (0, 2))
    ]
    expected = [np.linalg.norm(true.nests_mm[a] - true.nests_mm[b]) for a, b in ((0, 1), (1, 2), (0, 2))]
    assert sides == pytest.approx(expected, abs=0.001), "sides were measured to a micrometre"


def test_a_certificate_that_the_triangle_bears_out_stays_as_wide_as_stated():
    campaign, _ = ballbar_campaign()

    specs = {spec.name: spec for spec in build(campaign, EFFECTS).structure.specs}

    assert specs["certified_2_x"].prior_width == 0.002


def test_a_set_up_far_from_its_cup_is_gross_and_bends_nothing():
    campaign, _ = ballbar_campaign(placements=2)
    joints = campaign.setup.joints_rad.copy()
    joints[0] += np.deg2rad(2.0)
    wrong = replace(campaign, setup=CupSetups(campaign.setup.placement, campaign.setup.base_point, joints))

    answer = identify(wrong)

    # 2 deg of every joint is tens of millimetres: no weight, and the rest still closes.
    assert answer.positions.tied.identified.max_mm < 0.01


def with_two_legs_of_cup_3(campaign):
    legs = campaign.legs
    kept = (legs.base_point != 3) | np.isin(legs.stops.config, np.unique(legs.stops.config)[:2])
    return replace(
        campaign,
        legs=LegReadings(
            Stops(legs.stops.config[kept], legs.stops.joints_rad[kept]),
            legs.placement[kept],
            legs.base_point[kept],
            legs.nest[kept],
            legs.length_mm[kept],
            legs.standard_uncertainty_mm[kept],
        ),
    )


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_clamped_cup_is_looked_for_where_the_robot_held_the_ball(seed):
    campaign, true = ballbar_campaign(seed=seed)
    few = with_two_legs_of_cup_3(campaign)  # which fit anywhere on a circle

    problem = build(few, ("geometry",))

    assert anchor_places(problem.structure, problem.start) == pytest.approx(true.cups_mm[1], abs=1e-6)


def test_a_cup_with_a_few_legs_that_nobody_clamped_is_looked_for_by_its_legs():
    campaign, true = ballbar_campaign()
    few = replace(with_two_legs_of_cup_3(campaign), setup=None)

    problem = build(few, ("geometry",))

    places = anchor_places(problem.structure, problem.start)
    assert places[:2] == pytest.approx(true.cups_mm[1][:2], abs=1e-6)
    assert problem.blocks[0].length_mm == pytest.approx(few.legs.length_mm)


def test_a_handful_of_legs_starts_cups_where_they_were_clamped():
    campaign, true = ballbar_campaign(stops=5)
    off = 0.5 * np.random.default_rng(2).standard_normal(len(campaign.legs))  # of a nominal robot, mm
    legs = replace(campaign.legs, length_mm=campaign.legs.length_mm + off)

    structure, start = (problem := build(replace(campaign, legs=legs), EFFECTS)).structure, problem.start

    first = structure.index_of("anchor_1_1_x")
    # a cup is as far off as the lengths, and not on the mirror side of them
    assert start[first : first + 9].reshape(3, 3) == pytest.approx(true.cups_mm[1], abs=3.0)


def test_a_cup_that_was_clamped_elsewhere_is_started_from_its_legs():
    campaign, true = ballbar_campaign()
    joints = campaign.setup.joints_rad.copy()
    joints[1] += np.deg2rad(5.0)  # tens of millimetres: not the place where this cup is
    elsewhere = CupSetups(campaign.setup.placement, campaign.setup.base_point, joints)

    structure, start = (
        (problem := build(replace(campaign, setup=elsewhere), EFFECTS)).structure,
        problem.start,
    )

    first = structure.index_of("anchor_1_2_x")
    assert start[first : first + 3] == pytest.approx(true.cups_mm[1][1], abs=1e-3)


def test_sides_between_tool_nests_at_one_place_show_no_direction():
    campaign, _ = ballbar_campaign()
    together = replace(campaign, nests=(campaign.nests[0],) * len(campaign.nests))
    problem = build(together, ("geometry",))

    joint = linearise_blocks(problem.structure, problem.blocks[1:2], problem.start, None)

    assert np.isfinite(joint.jacobian).all()
