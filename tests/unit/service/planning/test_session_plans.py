"""Plans made of chosen configurations: how good they are, in which order, which are visited again."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.unit.service.planning.test_candidates import SPACE
from truepose.domain.robot import LinkMass
from truepose.domain.session import PlannedStop, SessionPlan
from truepose.planning.observability import observability_o1
from truepose.planning.tracker.plans import (
    choose_calibration,
    plan_calibration,
    plan_session,
    plan_validation,
    scaled_jacobians,
    short_tour,
    with_revisits,
)
from truepose.planning.workspace.candidates import draw_candidates

FEW = 300  # candidates: enough for the tests, a tenth of the time


def rng():
    return np.random.default_rng(2)


@cache
def feasible_stops(n):
    drawn = draw_candidates(SPACE, n, rng())
    return tuple(
        PlannedStop(config, tuple(joints.tolist()), int(nest))
        for config, joints, nest in zip(range(1, n + 1), drawn.joints_rad, drawn.nest, strict=True)
    )


@pytest.fixture(scope="module")
def plan():
    return plan_calibration(SPACE, 30, seed=5, n_candidates=FEW)


def test_a_calibration_plan_has_the_configurations_asked_for_and_revisits_on_top(plan):
    first_visits = [stop for stop in plan.stops if stop.repeat_of is None]

    assert plan.role == "calibration"
    assert len({stop.joints_rad for stop in first_visits}) == len(first_visits) == 30
    assert [stop.config for stop in plan.stops] == list(range(1, 36))
    assert plan.approach_offset_rad == SPACE.approach_offset_rad


def test_what_is_chosen_determines_the_parameters_better_than_chance():
    candidates = draw_candidates(SPACE, FEW, rng())
    jacobians = scaled_jacobians(SPACE, candidates)

    chosen = choose_calibration(jacobians, 30, rng())

    by_chance = [np.random.default_rng(k).choice(FEW, 30, replace=False) for k in range(20)]
    of_chosen, *of_chance = (
        observability_o1(jacobians[rows].reshape(90, -1), 30) for rows in (chosen.indices, *by_chance)
    )
    # with 5,000 candidates the ratio is about 1.35; with 300 there is less to choose from
    assert of_chosen > 1.1 * max(of_chance)


def test_the_jacobians_have_the_thirty_parameters_of_this_robot_and_see_masses_as_springs():
    candidates = draw_candidates(SPACE, 40, rng())
    loaded = replace(SPACE, robot=replace(SPACE.robot, masses=(LinkMass(6, 2.7, (50.0, 25.0, 100.0)),)))

    geometry = scaled_jacobians(SPACE, candidates)
    with_springs = scaled_jacobians(loaded, candidates)

    assert geometry.shape == (40, 3, 26)  # 6 base, 19 DH-Modified, 1 tilt of the parallel axes
    assert with_springs.shape == (40, 3, 31)  # and the springs of joints 2 to 6


def test_a_jacobian_is_the_difference_quotient_of_the_nominal_robot():
    candidates = draw_candidates(SPACE, 10, rng())
    jacobians = scaled_jacobians(SPACE, candidates, ("base",))

    # the first three parameters move the base: every nest goes with it, one standard width of the
    # prior counted in readings of 0.015 mm
    first_three = jacobians[:, :, :3]
    assert np.allclose(first_three, first_three[0, 0, 0] * np.eye(3))


@pytest.mark.parametrize(("n", "again"), [(3, 5), (5, 5), (30, 5), (50, 5), (51, 6), (120, 12)])
def test_a_tenth_is_visited_again_and_never_fewer_than_five(n, again):
    stops = with_revisits(SPACE, feasible_stops(n), rng())

    revisits = [stop for stop in stops if stop.repeat_of is not None]
    assert len(stops) == n + again
    assert revisits == list(stops[n:])  # late: after all first visits
    by_number = {stop.config: stop for stop in stops}
    for stop in revisits:
        assert stop.joints_rad == by_number[stop.repeat_of].joints_rad
        assert stop.nest == by_number[stop.repeat_of].nest
    assert len({stop.config for stop in stops}) == len(stops)


def test_revisits_come_in_another_order_than_the_first_visits_whatever_the_seed():
    for seed in range(50):
        stops = with_revisits(SPACE, feasible_stops(5), np.random.default_rng(seed))

        assert [stop.repeat_of for stop in stops[5:]] != [1, 2, 3, 4, 5], seed


def test_a_validation_plan_visits_feasible_configurations_on_short_ways():
    plan = plan_validation(SPACE, 200, seed=9)

    joints = np.array([stop.joints_rad for stop in plan.stops])
    way = np.max(np.abs(np.diff(joints, axis=0)), axis=1).sum()
    by_chance = np.max(np.abs(np.diff(np.random.default_rng(0).permutation(joints), axis=0)), axis=1).sum()
    assert plan.role == "validation"
    assert len(plan.stops) == 200
    assert way < 0.7 * by_chance


def test_a_tour_visits_every_configuration_once():
    joints = np.random.default_rng(0).standard_normal((40, 6))

    assert sorted(short_tour(joints)) == list(range(40))


def test_the_same_seed_gives_the_same_plan_and_another_another():
    first = plan_calibration(SPACE, 12, seed=5, n_candidates=FEW)

    assert plan_calibration(SPACE, 12, seed=5, n_candidates=FEW) == first
    assert plan_calibration(SPACE, 12, seed=6, n_candidates=FEW) != first


def test_calibration_and_validation_of_one_seed_share_no_configuration():
    calibration = plan_calibration(SPACE, 12, seed=5, n_candidates=FEW)
    validation = plan_validation(SPACE, 50, seed=5)

    assert not {s.joints_rad for s in calibration.stops} & {s.joints_rad for s in validation.stops}


@pytest.mark.parametrize("role", ["calibration", "validation"])
def test_a_template_says_role_approach_and_everything_but_the_stops(role):
    template = SessionPlan(role, (), approach_offset_rad=None, settle_s=7.0, reference_every=3)

    plan = plan_session(SPACE, template, 8, seed=1)

    assert (plan.role, plan.approach_offset_rad) == (role, None)
    assert (plan.settle_s, plan.reference_every) == (7.0, 3)
    assert len(plan.stops) == (13 if role == "calibration" else 8)
