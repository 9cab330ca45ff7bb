"""Noise that is larger at some readings than at others: over what, how large, and that it is no cause."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import NOISE_MM, leg_campaign, measured, nominal_campaign
from truepose.diagnosis.diagnose import diagnose
from truepose.diagnosis.scatter import telling_scatter, with_scatter
from truepose.domain.diagnosis import Verdict
from truepose.identification.fit.robust import robust_fit
from truepose.identification.problem.build import automatic_effects, build
from truepose.messages.catalogue import english

_TRACKER_MM = (2500.0, 0.0, 500.0)
_NO_ARM = replace(IRB_120, repeatability_mm=0.0)  # its own scatter would blur how large that of readings is


def _campaign(n=120, seed=0, **changes):
    told = {"robot": _NO_ARM, "tracker_position_mm": _TRACKER_MM} | changes
    campaign, _ = measured(nominal_campaign(n, seed, **told), seed=seed)
    points = campaign.calibration
    stops = replace(points.stops, time_s=30.0 * np.arange(n) + 500.0, attachment=1 + np.arange(n) // (n // 4))
    return replace(campaign, calibration=replace(points, stops=stops))


def _noisier(campaign, scale, seed=5):
    """The campaign with noise of `scale` (n,) times the stated size in place of once."""
    points = campaign.calibration
    more_mm = NOISE_MM * np.sqrt(scale**2 - 1.0)
    noise = np.random.default_rng(seed).standard_normal((len(points), 3))
    return replace(
        campaign, calibration=replace(points, position_mm=points.position_mm + more_mm[:, None] * noise)
    )


def _told(campaign):
    problem = build(campaign, automatic_effects(campaign))
    return telling_scatter(robust_fit(problem.structure, problem.blocks, problem.start), campaign)


def _over_time(n=120, times=4.0):
    return np.linspace(1.0, times, n)


@pytest.mark.parametrize("seed", range(4))
def test_scatter_that_grows_is_told_with_its_variable_and_its_size_at_both_ends(seed):
    told = _told(_noisier(_campaign(seed=seed), _over_time())).told
    assert (told.variable, told.subject, told.unit) == ("time", "", "s")
    assert told.low_mm == pytest.approx(NOISE_MM, rel=0.4)
    assert told.high_mm == pytest.approx(4.0 * NOISE_MM, rel=0.35)
    assert 0.0 <= told.at_low < 600.0 < 2900.0 < told.at_high <= 3570.0
    assert told.p_value < 1e-3


def test_scatter_with_the_distance_from_the_instrument_is_told_as_that():
    campaign = _campaign(200)
    range_mm = np.linalg.norm(campaign.calibration.position_mm - np.array(_TRACKER_MM), axis=1)
    far = (range_mm - range_mm.min()) / np.ptp(range_mm)
    told = _told(_noisier(campaign, 1.0 + 5.0 * far**2)).told
    assert told.variable == "range"
    assert told.at_high > told.at_low + 400.0


def test_a_nest_that_is_not_seated_well_scatters_and_has_its_number():
    campaign = _campaign()
    loose = campaign.calibration.nest == 2
    told = _told(_noisier(campaign, np.where(loose, 3.5, 1.0))).told
    assert (told.variable, told.at_high) == ("nest", 2.0)
    assert told.high_mm == pytest.approx(3.5 * NOISE_MM, rel=0.35)


def test_a_mounting_and_a_joint_are_told_too():
    campaign = _campaign()
    third = campaign.calibration.stops.attachment == 3
    told = _told(_noisier(campaign, np.where(third, 4.0, 1.0))).told
    assert (told.variable, told.at_high) == ("mounting", 3.0)
    angle = campaign.calibration.stops.joints_rad[:, 4]
    told = _told(_noisier(campaign, 1.0 + 4.0 * (angle / np.abs(angle).max()) ** 2)).told
    assert (told.variable, told.subject, told.unit) == ("angle", "joint 5", "deg")


@pytest.mark.parametrize("seed", range(12))
def test_noise_that_is_alike_everywhere_depends_on_nothing(seed):
    assert _told(_campaign(seed=seed)) is None


@pytest.mark.parametrize("seed", range(4))
def test_noise_that_is_larger_everywhere_depends_on_nothing(seed):
    assert _told(_noisier(_campaign(seed=seed), np.full(120, 3.0))) is None


@pytest.mark.parametrize("seed", range(4))
def test_heavy_tails_and_spoiled_readings_of_one_nest_are_no_scatter(seed):
    campaign = _campaign(seed=seed)
    degrees = np.random.default_rng(seed).chisquare(4.0, 120) / 4.0
    assert _told(_noisier(campaign, np.maximum(1.0 / np.sqrt(degrees), 1.0))) is None
    spoiled = np.zeros(120)
    spoiled[np.flatnonzero(campaign.calibration.nest == 1)[::10]] = 20.0
    assert _told(_noisier(campaign, 1.0 + spoiled)) is None


def test_a_few_readings_tell_nothing():
    assert _told(_noisier(_campaign(24), _over_time(24))) is None


def test_readings_are_as_uncertain_as_they_scatter_and_never_less_than_stated():
    campaign = _campaign(robot=IRB_120)
    campaign = replace(_noisier(campaign, _over_time(times=8.0)), validation=campaign.calibration)
    model = _told(campaign)
    scale = model.scale(campaign.calibration, campaign)
    assert scale.min() >= 1.0
    assert scale[-1] > 2.0 * scale[0]
    weighed = with_scatter(campaign, model)
    arm = IRB_120.repeatability_mm**2
    before = NOISE_MM**2 + arm
    for points in (weighed.calibration, weighed.validation):
        after = points.covariance_mm2[:, 0, 0] + arm
        np.testing.assert_allclose(after, scale**2 * before)
    np.testing.assert_array_equal(weighed.calibration.position_mm, campaign.calibration.position_mm)


def test_readings_whose_variable_is_unknown_stay_as_stated():
    campaign = _noisier(_campaign(), _over_time())
    model = _told(campaign)
    untimed = replace(campaign.calibration, stops=replace(campaign.calibration.stops, time_s=None))
    np.testing.assert_array_equal(model.scale(untimed, campaign), 1.0)


def test_lengths_scatter_too():
    campaign = leg_campaign(240)
    legs = campaign.legs
    stops = replace(legs.stops, time_s=np.arange(240.0))
    noise = np.random.default_rng(3).standard_normal(240)
    more_mm = 0.005 * np.sqrt(_over_time(240, 6.0) ** 2 - 1.0)
    campaign = replace(campaign, legs=replace(legs, stops=stops, length_mm=legs.length_mm + more_mm * noise))
    model = _told(campaign)
    assert model.told.variable == "time"
    weighed = with_scatter(campaign, model)
    assert weighed.legs.standard_uncertainty_mm[-1] > 3.0 * weighed.legs.standard_uncertainty_mm[0]


def test_a_diagnosis_calls_it_scatter_and_neither_outliers_nor_a_cause():
    campaign = _noisier(_campaign(), _over_time(times=5.0))
    answer = diagnose(campaign)
    assert (answer.verdict, answer.all_findings) == (Verdict.CONSISTENT, ())
    assert answer.noise.scatter.variable == "time"
    assert "The scatter is not uniform: the standard deviation per axis is 0.0" in english(answer.message)
    assert "after the first reading" in english(answer.noise.sentence)
    assert answer.noise.scale == pytest.approx(1.0, abs=0.25)


def test_what_a_model_lacks_is_not_called_scatter():
    campaign = _campaign(robot=IRB_120)
    points = campaign.calibration
    # A bump that only the far end of joint 2 sees: residuals are larger there, and alike.
    angle = points.stops.joints_rad[:, 1]
    bump = 0.3 * np.exp(-(((angle - np.quantile(angle, 0.9)) / 0.15) ** 2))
    bumped = replace(points, position_mm=points.position_mm + bump[:, None] * np.array([0.6, 0.0, 0.8]))
    answer = diagnose(replace(campaign, calibration=bumped))
    assert answer.noise.scatter is None
    assert answer.verdict is not Verdict.CONSISTENT
