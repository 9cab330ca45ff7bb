from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.builders import make_identification
from truepose.reports.identification.judged_figures import judged, noise_split, without_far_out


def test_held_out_readings_judge_where_there_are_such(identification, campaign):
    shown = judged(identification, campaign)

    assert len(shown.identified_mm) == 60
    norms = np.linalg.norm(shown.identified_mm, axis=1)
    # The report's own residuals must be those that the identification counted.
    assert norms.mean() == pytest.approx(identification.validation.identified.mean_mm, rel=1e-9)


def test_without_held_out_readings_those_of_the_calibration_are_shown_as_such(
    identification, campaign_without_validation
):
    shown = judged(identification, campaign_without_validation)

    assert len(shown.identified_mm) == 40


def test_without_a_model_there_is_nothing_to_judge(campaign):
    assert judged(make_identification(model=None), campaign) is None


def test_squares_of_model_instrument_and_scatter_add_up_to_the_measured_one(identification, campaign):
    shown = judged(identification, campaign)
    shown = replace(shown, block=replace(shown.block, scatter_mm=0.004))

    split = noise_split(shown, shown.nominal_mm)

    parts = split.model_mm**2 + split.instrument_mm**2 + split.scatter_mm**2
    assert parts == pytest.approx(split.measured_mm**2, rel=1e-12)
    assert split.instrument_mm == pytest.approx(np.sqrt(3.0) * 0.01, rel=1e-12)
    assert split.scatter_mm == pytest.approx(np.sqrt(3.0) * 0.004, rel=1e-12)


def test_where_noise_explains_more_than_was_measured_nothing_is_left_for_the_model(identification, campaign):
    shown = judged(identification, campaign)

    split = noise_split(shown, 0.1 * shown.identified_mm)

    assert split.model_mm is None
    assert split.instrument_share > 1.0


def test_a_blunder_among_held_out_readings_is_set_aside_for_comparison_only(identification, campaign):
    spoilt = campaign.validation.position_mm.copy()
    spoilt[5] += 3.0
    shown = judged(
        identification, replace(campaign, validation=replace(campaign.validation, position_mm=spoilt))
    )

    pair, dropped = without_far_out(shown)

    assert dropped == 1
    assert pair.identified.n == 59
    assert len(shown.identified_mm) == 60


def test_readings_that_all_are_usual_need_no_second_set_of_figures(identification, campaign):
    assert without_far_out(judged(identification, campaign)) is None
