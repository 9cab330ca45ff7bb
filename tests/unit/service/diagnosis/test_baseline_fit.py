"""The start: labels are put right before anything is judged, and what cannot be fitted is said."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import START, telling_campaign
from tests.helpers.diagnosis.selections import PRESENT, planted
from tests.helpers.identification.synthetic import shifted
from truepose.diagnosis.baseline_fit import NUISANCE, Start, fit_baseline
from truepose.diagnosis.diagnose import diagnose
from truepose.messages.catalogue import english
from truepose.messages.message import leading_key

SWAPPED = [10, 40]


def with_two_nests_confused(campaign):
    points = campaign.calibration
    nest = points.nest.copy()
    assert set(nest[SWAPPED].tolist()) == {2}
    nest[SWAPPED] = 3
    return replace(campaign, calibration=replace(points, nest=nest))


@pytest.fixture(scope="module")
def campaign():
    return planted({})


def test_swapped_labels_are_put_right_and_kept_as_they_were_written(campaign):
    start = fit_baseline(with_two_nests_confused(campaign), START, relabel=True)

    assert np.array_equal(start.campaign.calibration.nest, campaign.calibration.nest)
    assert start.written.calibration.nest[SWAPPED].tolist() == [3, 3]
    assert not start.fit.gross[0].any()


def test_where_labels_are_not_looked_at_they_stay_and_their_readings_are_gross(campaign):
    start = fit_baseline(with_two_nests_confused(campaign), START, relabel=False)

    assert start.campaign.calibration.nest[SWAPPED].tolist() == [3, 3]
    assert np.flatnonzero(start.fit.gross[0]).tolist() == SWAPPED


def test_labels_of_validation_readings_are_put_right_too(campaign):
    confused = with_two_nests_confused(campaign)
    both = replace(confused, validation=confused.calibration)

    start = fit_baseline(both, START, relabel=True)

    assert np.array_equal(start.campaign.validation.nest, campaign.calibration.nest)


def test_right_labels_leave_the_campaign_as_it_is(campaign):
    start = fit_baseline(campaign, START, relabel=True)

    assert isinstance(start, Start)
    assert start.campaign is campaign
    assert start.written is campaign


def test_certified_and_fixed_nests_may_move_while_a_diagnosis_runs(campaign):
    structure = fit_baseline(campaign, START, relabel=False).fit.structure

    assert set(NUISANCE) <= set(structure.effects)
    certified = [spec for spec in structure.specs if spec.name.startswith("certified_")]
    assert len(certified) == 9
    assert {spec.prior_width for spec in certified} == {0.002}  # as the nests' certificates say


def test_without_a_choice_the_usual_model_is_the_start(campaign):
    assert fit_baseline(campaign, None, relabel=False).effects == ("base", "geometry", "compliance")


def test_too_few_configurations_are_said_in_a_sentence():
    sentence = fit_baseline(planted({}, campaign=telling_campaign(5)), START, relabel=True)

    assert leading_key(sentence) == "status.too_few"
    assert "5" in english(sentence)


def with_wild(campaign, rows):
    """The campaign with readings off by a millimetre or so, each in a direction of its own."""
    return shifted(campaign, rows, np.random.default_rng(2).normal(0.0, 1.0, (len(rows), 3)))


def test_where_too_many_readings_are_wild_it_says_what_they_share(campaign):
    of_nest_2 = np.flatnonzero(campaign.calibration.nest == 2)

    doubt = english(fit_baseline(with_wild(campaign, of_nest_2), START, relabel=True).doubt)

    assert "no model can be trusted" in doubt
    assert f"of these readings were taken at nest 2, as were {len(of_nest_2)} of all readings" in doubt


def test_too_many_wild_readings_anywhere_share_nothing(campaign):
    anywhere = np.random.default_rng(5).choice(80, 26, replace=False)

    doubt = fit_baseline(with_wild(campaign, anywhere), START, relabel=True).doubt

    assert english(doubt).endswith("the order of the rows.")


def jumped_far(after, readings=100):
    """A campaign in which joint 3 jumped by ten times the noise: later readings fit none of the others."""
    stops = telling_campaign(readings, seed=3).calibration.stops
    time_s = np.sort(stops.time_s)
    middle_s = 0.5 * (time_s[after - 1] + time_s[after])
    return planted({"unnamed": {f"cell_jump_3_{middle_s:.0f}_turn": 6e-4}}, n=readings)


def test_readings_that_jumped_together_are_no_wild_ones():
    campaign = jumped_far(after=70)

    start = fit_baseline(campaign, PRESENT, relabel=False)

    assert isinstance(start, Start)
    assert english(start.doubt).startswith("30 of 100 readings do not fit the others")
    assert not start.fit.gross[0].any()
    found = diagnose(campaign, PRESENT)
    assert found.verdict == "explained"
    assert [one.subject for one in found.findings] == ["joint 3, time, jump"]


def test_readings_that_are_wild_leave_nothing_to_say():
    campaign = planted({}, n=90)
    points, rng = campaign.calibration, np.random.default_rng(5)
    moved = points.position_mm.copy()
    moved[rng.choice(90, 32, replace=False)] += rng.normal(0.0, 3.0, (32, 3))

    found = diagnose(replace(campaign, calibration=replace(points, position_mm=moved)), PRESENT)

    assert found.verdict == "unexplained"
    assert found.findings == ()
    assert "do not fit the others, so no model can be trusted" in english(found.message)
