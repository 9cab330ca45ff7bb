"""Information of a session against finite differences and against drawn sessions."""

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell, fixture_before_the_arm, frame
from truepose.planning.ballbar.arm_model import Scatter, arm_model
from truepose.planning.ballbar.bodies import base_fixture
from truepose.planning.ballbar.expected_information import (
    error_weight,
    information_beforehand,
    of_poses,
    pose_rows,
    predicted_error_mm,
    setting_information,
    with_placement,
    work_space_sample,
)
from truepose.planning.ballbar.pose_selection import (
    candidates,
    choose,
    exchanged_for_error,
    information_after,
    least_error_first,
)
from truepose.planning.ballbar.poses import setups

CELL, FIXTURE = ballbar_cell(), fixture_before_the_arm()
MODEL = arm_model(CELL)
HELD = setups(CELL, FIXTURE)
OFFER = candidates(MODEL, FIXTURE, HELD)
SPACE = work_space_sample(MODEL, 60, np.random.default_rng(0))
RNG_SEED = 3


def test_the_unknowns_are_those_of_the_arm():
    names = {spec.name for spec in MODEL.structure.specs}

    assert {"alpha_2", "a_3", "theta_6", "beta_3", "c_2"} <= names
    assert MODEL.parameters == 25


def test_whitened_rows_make_scattered_legs_independent_with_unit_variance():
    legs = OFFER.found.assembly[0].legs
    joints = OFFER.found.joints_rad[:1]
    nests, _ = MODEL.nests(joints)
    ways = np.array([nests[0, t - 1] - FIXTURE.cups_mm[b - 1] for b, t in legs])
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    scatter = MODEL.scatter

    rows = pose_rows(MODEL, FIXTURE.cups_mm, joints, [legs])

    # a shift of all three cups is a shift of all nests the other way: the information it brings is known
    shift = rows.cups[0].reshape(6, 3, 3).sum(axis=1) / 10.0
    covariance = scatter.leg_mm**2 * np.eye(6) + scatter.stop_mm**2 * ways @ ways.T
    assert shift.T @ shift == pytest.approx(ways.T @ np.linalg.solve(covariance, ways))


def test_a_pose_with_fewer_legs_says_less_and_nothing_wrong():
    legs = OFFER.found.assembly[0].legs
    joints = np.repeat(OFFER.found.joints_rad[:1], 2, axis=0)

    rows = pose_rows(MODEL, FIXTURE.cups_mm, joints, [legs, legs[:4]])

    whole, part = (of_poses(rows.some(np.array([k]))) for k in (0, 1))
    assert np.all(rows.arm[1, 4:] == 0.0)
    assert np.linalg.eigvalsh(whole - part).min() > -1e-6 * np.trace(whole)


def test_what_is_known_grows_with_every_configuration():
    few, many = (information_after(MODEL, [OFFER], [np.arange(n)]) for n in (10, 60))

    assert predicted_error_mm(many, SPACE) < predicted_error_mm(few, SPACE)


def test_the_predicted_error_is_that_of_drawn_sessions():
    # Parameters drawn from what remains unknown, positions taken relative to the cups: 400 draws of a mean
    # square over the whole space know its root to better than 10 %.
    known = information_after(MODEL, [OFFER], [None])
    rng = np.random.default_rng(1)
    drawn = rng.multivariate_normal(np.zeros(len(known.matrix)), np.linalg.inv(known.matrix), 400)
    arm, cups = drawn[:, : MODEL.parameters], 10.0 * drawn[:, MODEL.parameters :].reshape(400, 3, 3)
    square = 0.0
    for own, moved in zip(arm, cups, strict=True):
        turn, shift = _fit(FIXTURE.cups_mm, moved)
        error = SPACE.motion @ own - (shift + np.cross(turn, SPACE.position_mm))
        square += float(np.mean(np.sum(error**2, axis=1))) / 400

    assert predicted_error_mm(known, SPACE) == pytest.approx(np.sqrt(square), rel=0.1)


def _fit(points, moved):
    """Small turn and shift that fit moved points best, by normal equations."""
    rows = np.concatenate([np.hstack([np.eye(3), -_skew(p)]) for p in points])
    solved = np.linalg.lstsq(rows, moved.reshape(-1), rcond=None)[0]
    return solved[3:], solved[:3]


def _skew(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def test_set_ups_and_sides_are_worth_something():
    without = setting_information(MODEL, FIXTURE.cups_mm, None)
    joints = np.array([setup.joints_rad for setup in HELD])

    with_setups = setting_information(MODEL, FIXTURE.cups_mm, joints)

    assert np.linalg.slogdet(with_setups)[1] > np.linalg.slogdet(without)[1]


def test_priors_of_the_arm_count_once_whatever_the_number_of_placements():
    own = setting_information(MODEL, FIXTURE.cups_mm, None)
    nothing = information_beforehand(MODEL)

    twice = with_placement(with_placement(nothing, own, FIXTURE.cups_mm), own, FIXTURE.cups_mm + 100.0)

    assert twice.matrix[: MODEL.parameters, : MODEL.parameters] == pytest.approx(np.eye(MODEL.parameters))
    assert len(twice.cups_mm) == 6


def test_the_choice_is_better_than_chance():
    rng = np.random.default_rng(RNG_SEED)
    (chosen,) = choose(MODEL, [OFFER], 30, rng, SPACE)
    random = [rng.choice(len(OFFER), 30, replace=False) for _ in range(20)]

    errors = [predicted_error_mm(information_after(MODEL, [OFFER], [rows]), SPACE) for rows in random]

    assert len(chosen) == len(set(chosen.tolist())) == 30
    assert predicted_error_mm(information_after(MODEL, [OFFER], [chosen]), SPACE) < min(errors)


def test_no_more_than_there_is_can_be_chosen():
    (chosen,) = choose(MODEL, [OFFER], 10_000, np.random.default_rng(0))

    assert chosen.tolist() == list(range(len(OFFER)))


def test_an_exchange_ends_where_no_single_one_lowers_the_error_by_a_thousandth():
    prior = information_after(MODEL, [OFFER], [np.zeros(0, dtype=np.int64)])
    rows = np.concatenate([OFFER.rows.arm, OFFER.rows.cups], axis=2)[:24]
    weight = error_weight(FIXTURE.cups_mm, SPACE)

    chosen = exchanged_for_error(rows, np.arange(12), prior.matrix, weight)

    def figure(members):
        flat = rows[members].reshape(-1, rows.shape[2])
        return float(np.sum(weight * np.linalg.inv(flat.T @ flat + prior.matrix)))

    others = [k for k in range(24) if k not in chosen]
    neighbours = [
        figure([*(k for k in chosen if k != leaving), entering]) for leaving in chosen for entering in others
    ]
    assert figure(chosen) < figure(np.arange(12))
    assert min(neighbours) > figure(chosen) * (1 - 1e-3)


def test_one_after_another_each_lowers_the_error_most_of_all_that_are_left():
    rng = np.random.default_rng(4)
    rows, half = rng.standard_normal((12, 2, 5)), rng.standard_normal((5, 5))
    known, weight = np.eye(5), half @ half.T

    def left(chosen):
        flat = rows[chosen].reshape(-1, 5)
        return np.sum(weight * np.linalg.inv(known + flat.T @ flat))

    order = least_error_first(rows, 20, known, weight).tolist()

    assert sorted(order) == list(range(12))
    for place, row in enumerate(order):
        others = set(range(12)) - set(order[:place])
        assert row == min(others, key=lambda other: left([*order[:place], other]))


def test_more_scatter_is_a_larger_error():
    loose = arm_model(CELL, Scatter(stop_mm=0.1))
    offer = candidates(loose, FIXTURE, HELD)

    error = predicted_error_mm(information_after(loose, [offer], [None]), SPACE)

    assert error > predicted_error_mm(information_after(MODEL, [OFFER], [None]), SPACE)


def test_an_unreachable_placement_offers_nothing_to_choose_from():
    nothing = candidates(MODEL, base_fixture(1, frame(3000, 0, 100)))

    assert len(nothing) == 0
    assert [rows.tolist() for rows in choose(MODEL, [nothing], 5, np.random.default_rng(0))] == [[]]
