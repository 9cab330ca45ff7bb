"""Findings about readings: bad ones of every kind, and what putting swapped labels right gains."""

from dataclasses import replace

import numpy as np

from tests.helpers.diagnosis.leg_scenes import LEG_START, telling_legs
from tests.helpers.diagnosis.point_scenes import telling_campaign
from tests.helpers.diagnosis.selections import PRESENT, left_of, make_selected, planted
from tests.helpers.identification.synthetic import NESTS, configurations, leg_campaign, nominal_campaign
from truepose.diagnosis.baseline_fit import fit_baseline
from truepose.diagnosis.evidence.held_out_errors import on_validation
from truepose.diagnosis.reading_findings import readings_found
from truepose.domain.robot import Nest


def found_in(campaign, effects):
    """What is wrong with the readings of a campaign in which nothing else was found."""
    start = fit_baseline(campaign, effects, relabel=True)
    selected = make_selected(start, ())
    judged = on_validation(start.campaign, (start.fit, selected.fit), selected, ())
    return readings_found(start, selected, left_of(start, selected), judged)


def with_swapped(points, rows, first, second):
    """Points with the labels of two nests exchanged in some rows."""
    nest = points.nest.copy()
    here = nest[rows]
    nest[rows] = np.where(here == first, second, np.where(here == second, first, here))
    return replace(points, nest=nest)


def test_a_bad_length_is_judged_by_lengths_where_positions_were_validated_too():
    campaign = telling_legs()
    length = campaign.legs.length_mm.copy()
    length[7] += 1.0
    campaign = replace(
        campaign,
        legs=replace(campaign.legs, length_mm=length),
        validation_legs=leg_campaign(90, seed=4).legs.taken(np.arange(60, 90)),
        validation=nominal_campaign(12, seed=8).calibration,
    )

    (finding,) = found_in(campaign, LEG_START)

    assert (finding.effect, finding.details[0].value) == ("outliers", 1)
    # Thirty lengths of 5 um: what one of sixty was off by spoils them without a weight of its own.
    assert finding.gain.rms_after_mm < finding.gain.rms_before_mm


def test_the_farther_two_nests_lie_apart_the_less_chance_swaps_them():
    def chance(apart_mm):
        near = (*NESTS[:2], (NESTS[0][0] + apart_mm, *NESTS[0][1:]))
        campaign = planted({}, replace(telling_campaign(80), nests=tuple(Nest(one, 0.002) for one in near)))
        swapped = with_swapped(campaign.calibration, np.arange(6), 1, 3)
        finding, *_ = found_in(replace(campaign, calibration=swapped), PRESENT)
        assert (finding.effect, finding.subject) == ("label_swap", "nest 1, nest 3")
        return finding.p_value

    # 0.018 mm of noise and scatter: eight standard deviations and sixteen, exp(-32) and exp(-128)
    assert 1e-30 * chance(0.15) > chance(0.3) > 0.0


def test_a_revisit_counts_as_its_configuration_in_what_labels_put_right_gain():
    twice = np.tile(configurations(20, seed=9), (2, 1))
    unseen = planted({}, telling_campaign(40, joints_rad=twice), seed=11)
    points = with_swapped(unseen.calibration, np.arange(0, 40, 5), 1, 2)
    stops, first = points.stops, np.tile(points.stops.config[:20], 2)
    campaign = planted({}, telling_campaign(80))
    campaign = replace(campaign, calibration=with_swapped(campaign.calibration, np.arange(4), 1, 2))

    def gained(**told):
        validation = replace(points, stops=replace(stops, **told))
        (finding,) = found_in(replace(campaign, validation=validation), PRESENT)
        return finding.gain

    again = gained(repeat_of=np.where(np.arange(40) < 20, -1, first))

    assert again == gained(config=first)
    assert again.interval_95_mm != gained().interval_95_mm
