"""Promises of ballbar sessions: in the frame of the cups, from the poses that an arm offers."""

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell, domain_cell, fixture_before_the_arm
from truepose.planning.ballbar.lengths.information import (
    Scatter,
    WorkSpaceSample,
    arm_model,
    error_gradient,
    error_weight,
    work_space_sample,
)
from truepose.planning.errors import TooFewCandidatesError
from truepose.planning.promise.ballbar import promised_at

FIXTURES = (fixture_before_the_arm(),)


def planned(n=None, fixtures=FIXTURES, **given):
    return promised_at(domain_cell(), fixtures, n, **given)


@pytest.fixture(scope="module")
def plan():
    return planned()


def test_the_promise_falls_with_every_ten_more_poses(plan):
    means = [point.mean_mm for point in plan.curve]

    assert means == sorted(means, reverse=True)
    assert plan.curve[0].n == 11


def test_every_pose_has_its_six_legs_and_its_placement(plan):
    assert len(plan.poses.legs) == len(plan.joints_rad) == plan.advised
    assert {len(legs) for legs in plan.poses.legs} == {6}
    assert set(plan.poses.placement.tolist()) == {1}
    assert plan.left_open == ()


def test_a_curve_ends_with_the_poses_that_the_arm_offers(plan):
    with pytest.raises(TooFewCandidatesError, match=f"in {plan.curve[-1].n} from there"):
        planned(plan.curve[-1].n + 1)


def test_two_poses_promise_much_less_and_say_what_they_leave_open():
    few = planned(2)

    assert few.promised.mean_mm > 3.0 * planned(20).promised.mean_mm
    assert few.left_open


def test_poses_of_one_placement_follow_each_other():
    both = (FIXTURES[0], fixture_before_the_arm(number=2))

    found = planned(20, both)

    assert np.all(np.diff(found.poses.placement) >= 0)


def test_the_gradient_of_errors_gives_their_weight():
    model = arm_model(ballbar_cell(), Scatter())
    sample: WorkSpaceSample = work_space_sample(model, 20, np.random.default_rng(0))

    gradient = error_gradient(FIXTURES[0].cups_mm, sample)

    weight = np.einsum("mip,miq->pq", gradient, gradient) / len(gradient)
    assert error_weight(FIXTURES[0].cups_mm, sample) == pytest.approx(weight)


def test_a_motion_of_all_cups_and_nests_together_is_no_error():
    model = arm_model(ballbar_cell(), Scatter())
    sample = work_space_sample(model, 20, np.random.default_rng(0))
    shift = np.zeros(error_gradient(FIXTURES[0].cups_mm, sample).shape[2])
    shift[model.parameters :: 3] = 0.1  # all cups along x, in units of 10 mm

    error = error_gradient(FIXTURES[0].cups_mm, sample) @ shift

    assert error == pytest.approx(np.tile([-1.0, 0.0, 0.0], (len(error), 1)), abs=1e-9)
