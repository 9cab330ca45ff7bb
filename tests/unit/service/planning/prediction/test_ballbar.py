"""Promises of ballbar sessions: in the frame of the cups, from the poses that an arm offers."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell, domain_cell, fixture_before_the_arm, frame
from truepose.domain.robot import JointRange
from truepose.planning.ballbar.arm_model import Scatter, arm_model
from truepose.planning.ballbar.bodies import base_fixture
from truepose.planning.ballbar.expected_information import (
    WorkSpaceSample,
    error_gradient,
    error_weight,
    information_beforehand,
    of_poses,
    pose_rows,
    work_space_sample,
)
from truepose.planning.ballbar.poses import reach
from truepose.planning.errors import TooFewCandidatesError
from truepose.planning.prediction.ballbar import plan_with_fixtures
from truepose.planning.prediction.errors import MOST
from truepose.planning.prediction.plan import WorkVolume

FIXTURES = (fixture_before_the_arm(),)


def planned(n=None, fixtures=FIXTURES, **given):
    return plan_with_fixtures(domain_cell(), fixtures, n, **given)


@pytest.fixture(scope="module")
def plan():
    return planned()


@pytest.fixture(scope="module")
def twenty():
    return planned(20)


def test_the_promise_falls_with_every_ten_more_poses(plan):
    means = [point.mean_mm for point in plan.curve]

    assert means == sorted(means, reverse=True)
    assert plan.curve[0].n == 11


def test_every_pose_has_its_six_legs_and_its_placement(plan):
    assert len(plan.poses.legs) == len(plan.joints_rad) == plan.advised
    assert {len(legs) for legs in plan.poses.legs} == {6}
    assert set(plan.poses.placement.tolist()) == {1}
    assert plan.left_open == ()


def test_no_more_poses_are_planned_than_the_arm_offers():
    offered = len(reach(ballbar_cell(), FIXTURES[0]))

    with pytest.raises(TooFewCandidatesError, match=f"only {offered} can be measured from these placements"):
        planned(offered + 1)


def test_a_fixture_from_which_nothing_can_be_measured_is_a_sentence():
    # The arm holds the setting ball at each of its cups, but no bar finds room above them.
    below_the_arm = base_fixture(1, frame(300, -200, 300, 180, 0, 60))

    with pytest.raises(TooFewCandidatesError, match="No configuration can be measured from placement 1"):
        planned(fixtures=(below_the_arm,))


def test_more_poses_than_the_curve_shows_are_planned():
    poses = MOST + 5

    plan = planned(poses)

    assert len(plan.joints_rad) == poses == plan.curve[-1].n


def test_legs_are_in_the_order_of_the_hands(twenty):
    for legs in twenty.poses.legs:
        assert all(before[0] == leg[0] or before[1] == leg[1] for before, leg in pairwise(legs))


def test_two_poses_promise_much_less_and_say_what_they_leave_open(twenty):
    few = planned(2)

    assert few.promised.mean_mm > 3.0 * twenty.promised.mean_mm
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


def test_uncertain_tool_nests_make_the_promise_larger_and_are_no_parameters_of_the_arm(plan):
    exact = tuple(replace(nest, standard_uncertainty_mm=0.0) for nest in domain_cell().nests)

    of_exact = plan_with_fixtures(replace(domain_cell(), nests=exact), FIXTURES)

    assert of_exact.promised.mean_mm < 0.95 * plan.promised.mean_mm
    assert of_exact.observability.keys() == plan.observability.keys()
    assert of_exact.observability["O1"] == pytest.approx(plan.observability["O1"], rel=0.2)


def test_the_measured_triangle_tells_the_sides_between_uncertain_nests_and_nothing_else():
    certain, uncertain = arm_model(ballbar_cell()), arm_model(ballbar_cell(), certified_mm=(0.002,) * 3)

    told = information_beforehand(uncertain).matrix - np.eye(uncertain.parameters)

    assert information_beforehand(certain).matrix == pytest.approx(np.eye(certain.parameters))
    assert uncertain.parameters == uncertain.own_parameters + 9 == certain.parameters + 9
    assert np.linalg.matrix_rank(told, tol=1e-6) == 3
    assert told[: certain.parameters, : certain.parameters] == pytest.approx(0.0, abs=1e-6)


def test_lengths_whose_zero_does_not_walk_err_as_they_are_weighed():
    model, found = arm_model(ballbar_cell(), Scatter()), reach(ballbar_cell(), FIXTURES[0])
    legs = [assembly.legs for assembly in found.assembly]

    weighed, erring = (
        of_poses(pose_rows(one, FIXTURES[0].cups_mm, found.joints_rad, legs))
        for one in (model, replace(model, erring=True))
    )

    assert erring == pytest.approx(weighed, rel=1e-9, abs=1e-6 * np.abs(weighed).max())


def test_lengths_whose_zero_walks_err_as_simulated_ones_do():
    scatter = Scatter(stop_mm=0.0, leg_mm=0.002, zero_mm=0.0018)
    model, found = arm_model(ballbar_cell(), scatter), reach(ballbar_cell(), FIXTURES[0])
    joints, legs = found.joints_rad[:1], [found.assembly[0].legs]
    weighed = pose_rows(model, FIXTURES[0].cups_mm, joints, legs)
    rng, draws = np.random.default_rng(3), 40_000
    walk = np.cumsum(rng.standard_normal((draws, 6)), axis=1) * 0.0018 / np.sqrt(3.5)  # RMS over six: 0.0018
    read = walk + np.sqrt(0.002**2 - 0.0018**2) * rng.standard_normal((draws, 6))
    derivatives = np.concatenate([weighed.arm, weighed.cups], axis=2)[0] * 0.002
    sums = read @ derivatives / 0.002**2

    erring = of_poses(pose_rows(replace(model, erring=True), FIXTURES[0].cups_mm, joints, legs))

    simulated = sums.T @ sums / draws
    assert erring == pytest.approx(simulated, abs=0.03 * np.abs(simulated).max())


def test_poses_are_chosen_for_the_volume_where_accuracy_counts(twenty):
    box = WorkVolume(box_mm=((350.0, 550.0), (-150.0, 150.0), (200.0, 450.0)))

    for_box = planned(20, volume=box)

    assert {tuple(joints) for joints in for_box.joints_rad} != {tuple(joints) for joints in twenty.joints_rad}
    assert for_box.promised.mean_mm < twenty.promised.mean_mm


def test_the_work_space_is_drawn_within_the_ranges_and_above_the_table():
    pose = reach(ballbar_cell(), FIXTURES[0]).joints_rad[0]
    narrow = replace(ballbar_cell(), ranges=tuple(JointRange(q - 1e-3, q + 1e-3) for q in pose))

    sample = work_space_sample(arm_model(narrow), 20, np.random.default_rng(1))

    middle, _ = arm_model(narrow).nests(np.array([pose]))
    apart = np.linalg.norm(sample.position_mm.reshape(20, 3, 3) - middle, axis=2)
    assert 0.1 < apart.max() < 8.0  # six joints of 0.001 rad, a metre away at most
    assert not len(
        work_space_sample(arm_model(replace(narrow, table_z_mm=5000.0)), 5, np.random.default_rng(1)).motion
    )
