"""Findings about readings: bad ones of every kind, and what putting swapped labels right gains."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.leg_scenes import LEG_START, telling_legs
from tests.helpers.diagnosis.selections import left_of, make_selected
from tests.helpers.identification.synthetic import leg_campaign, nominal_campaign
from truepose.diagnosis.baseline_fit import started
from truepose.diagnosis.evidence.held_out_errors import on_validation
from truepose.diagnosis.reading_findings import readings_found


def found_in(campaign, effects):
    """What is wrong with the readings of a campaign in which nothing else was found."""
    start = started(campaign, effects, relabel=True)
    selected = make_selected(start, ())
    judged = on_validation(start.campaign, (start.fit, selected.fit), selected, ())
    return readings_found(start, selected, left_of(start, selected), judged)


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
