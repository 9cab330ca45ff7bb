"""One judge for every kind of observation: a model and its nominal robot against readings."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification import lacking
from tests.helpers.identification.synthetic import leg_campaign, measured, nominal_campaign
from truepose.domain.errors import ConfigurationError
from truepose.identification import identify, judge, predict
from truepose.identification.model.derivatives import rotation_jacobian
from truepose.identification.model.estimates import identified_estimate, nominal_estimate
from truepose.identification.observations.poses import OrientationBlock
from truepose.identification.verdict.judge import judge_estimates

TURN_RAD = 2e-3


def points():
    campaign, _ = measured(nominal_campaign(80))
    rows = np.arange(80)
    held_out = campaign.calibration.taken(rows[60:])
    return replace(campaign.of_rows(rows[:60]), validation=held_out)


def legs():
    campaign = leg_campaign(160)
    rows = np.arange(160)
    return replace(campaign.of_rows(rows[:120]), validation_legs=campaign.legs.taken(rows[120:]))


@pytest.fixture(scope="module", params=[points, legs], ids=["positions", "lengths"])
def judged(request):
    campaign = request.param()
    answer = identify(campaign)
    return campaign, answer, judge(answer.model, campaign.held_out, campaign.scatter_mm)


def test_residuals_are_observed_minus_predicted(judged):
    campaign, _, found = judged
    moved = replace(found.block, **_moved(found.block, 0.25))

    further = judge_estimates(moved, *(_estimates(judged)))

    assert further.identified_mm - found.identified_mm == pytest.approx(
        np.full(campaign.held_out.observed_mm.shape, 0.25)
    )


def _moved(block, by_mm):
    name = "length_mm" if block.quantity == "length" else "measured_mm"
    return {name: getattr(block, name) + by_mm}


def _estimates(judged):
    _, answer, _ = judged
    return nominal_estimate(answer.model), identified_estimate(answer.model)


def test_the_answer_of_the_identification_is_that_of_the_judge(judged):
    _, answer, found = judged

    assert found.pair() == answer.validation


def test_statistics_of_some_readings_are_theirs_alone(judged):
    _, _, found = judged
    kept = np.arange(len(found.variance)) < 7

    pair = found.pair(kept)

    assert pair.identified.n == 7
    assert pair.identified.mean_mm == pytest.approx(
        np.linalg.norm(found.identified_mm[:7], axis=1).mean(), rel=1e-12
    )


def test_a_model_of_readings_with_noise_alone_lacks_nothing_to_speak_of(judged):
    _, _, found = judged

    # tens of readings tell their variance within a fifth: the root of that share of it is no more than noise
    assert found.discrepancy_mm() < np.sqrt(found.noise_variance.mean())
    assert (found.variance > 0.0).all()


def test_what_a_model_claims_grows_with_what_it_lacks(judged):
    campaign, answer, found = judged
    poor = replace(answer.model, shortfall=None, discrepancy_mm=50.0)

    assert found.claimed_mm() > found.pair().identified.noise_mm
    # far beyond noise the mean norm is the discrepancy's: sqrt(8 / pi) of three axes, sqrt(2 / pi) of one
    factor = np.sqrt((8.0 if found.block.components == 3 else 2.0) / np.pi)
    assert judge(poor, campaign.held_out, 0.0).claimed_mm() == pytest.approx(50.0 * factor, rel=1e-2)


def test_readings_of_another_robot_are_refused(judged):
    campaign, answer, _ = judged
    stops = campaign.held_out.stops
    fewer = replace(campaign.held_out, stops=replace(stops, joints_rad=stops.joints_rad[:, :5]))

    with pytest.raises(ConfigurationError, match="has 6 joints, but the rows have 5"):
        judge(answer.model, fewer, 0.0)


def test_orientations_are_judged_as_any_other_kind():
    campaign = points()
    nominal, identified = (of(identify(campaign).model) for of in (nominal_estimate, identified_estimate))
    targets = judge(identify(campaign).model, campaign.held_out, 0.0).block.targets
    about_z = np.array([[1.0, -TURN_RAD, 0.0], [TURN_RAD, 1.0, 0.0], [0.0, 0.0, 1.0]])
    seen = OrientationBlock(
        targets=targets,
        weights=np.ones(20),
        uncertainty=np.full(20, 1e-4),
        measured=np.tile(np.eye(3), (20, 1, 1)),
    )
    state = seen.result(identified.structure, identified.values, None).state
    block = replace(seen, measured=about_z @ state.orientation)

    found = judge_estimates(block, nominal, identified)

    assert found.identified_mm == pytest.approx(np.tile([0.0, 0.0, TURN_RAD], (20, 1)), abs=1e-8)
    jacobian = rotation_jacobian(state)
    spread = np.einsum("pni,pq,qni->n", jacobian, identified.covariance, jacobian) / 3.0
    # the residual is no small rotation: its derivative departs by half of it
    assert found.variance == pytest.approx(spread, rel=TURN_RAD)
    assert found.pair().identified.mean_mm == pytest.approx(TURN_RAD, rel=1e-4)


def test_what_a_model_lacks_is_judged_as_an_instrument_that_scales_sees_it():
    read, *_ = lacking.robot(gap_2=lacking.GAP_RAD)
    model = identify(read, (*lacking.MODEL, "instrument_scale")).model
    without, points = replace(model, shortfall=None), read.calibration

    judged = [judge(one, points, read.scatter_mm).variance for one in (model, without)]
    foretold = [predict(one, points.stops, points.nest)[1] ** 2 for one in (model, without)]

    assert judged[0] - judged[1] == pytest.approx(foretold[0] - foretold[1], rel=1e-6)
