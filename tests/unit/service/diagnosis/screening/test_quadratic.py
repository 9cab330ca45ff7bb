"""The tail of weighted sums of chi-square variables, against closed forms and against drawing them."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats
from scipy.special import betainccinv

from truepose.diagnosis.screening.normal_equations import Products, Sums
from truepose.diagnosis.screening.significance import chance_beside, tail_probability

UNEQUAL = np.array([3.0, 1.0, 0.5, 0.1])
NU = 20


@pytest.mark.parametrize("k", [1, 3, 12])
@pytest.mark.parametrize("chance", [0.3, 0.05, 1e-3, 1e-7])
def test_equal_weights_follow_a_beta_distribution(k, chance):
    # with all k weights 1, U / nu is the share of the squares in k of nu directions
    statistic = NU * betainccinv(k / 2, (NU - k) / 2, chance)

    # an approximation of relative error: far out it loses a tenth for one weight, the least smooth case
    assert tail_probability(statistic, np.ones(k), NU) == pytest.approx(chance, rel=0.12)


@pytest.mark.parametrize("statistic", [6.0, 14.0, 22.0])
def test_unequal_weights_agree_with_drawn_residuals(statistic):
    drawn = np.random.default_rng(1).standard_normal((200_000, NU)) ** 2
    sums = drawn[:, :4] @ UNEQUAL / (drawn.sum(axis=1) / NU)
    share = float((sums > statistic).mean())

    found = tail_probability(statistic, UNEQUAL, NU)

    # four standard deviations of the share drawn, and what the approximation itself is off
    assert found == pytest.approx(share, abs=4 * np.sqrt(share / 200_000) + 0.05 * share)


def test_a_statistic_that_no_residuals_can_reach_has_no_chance():
    assert tail_probability(NU * 3.0 + 1e-6, UNEQUAL, NU) == 0.0


def test_nothing_to_see_is_never_improbable():
    assert tail_probability(0.0, np.zeros(3), NU) == 1.0
    assert tail_probability(0.0, np.zeros(0), NU) == 1.0


def test_a_statistic_of_nothing_is_always_exceeded():
    assert tail_probability(0.0, UNEQUAL, NU) == 1.0


def test_more_weights_than_degrees_are_no_error():
    # readings that share a stop count as few: a family may then have more columns than they are worth
    assert 0.0 < tail_probability(6.0, UNEQUAL, 3.0) < tail_probability(5.0, UNEQUAL, 3.0) < 1.0


def test_the_unit_of_the_weights_does_not_matter():
    assert tail_probability(14.0e9, 1e9 * UNEQUAL, NU) == pytest.approx(
        tail_probability(14.0, UNEQUAL, NU), rel=1e-6
    )


def test_more_is_never_more_probable_also_near_the_mean_and_with_as_many_weights_as_degrees():
    weights = np.geomspace(1.0, 1e-3, 10)
    statistics = np.linspace(0.01, 9.9, 400)

    chances = [tail_probability(u, weights, 10.0) for u in statistics]

    # the formula has a removable pole at the mean; around it a normal distribution stands in
    assert np.diff(chances).max() < 0.01
    assert chances[0] > 0.99
    assert chances[-1] < 1e-3


def test_weights_that_only_rounding_made_do_not_count():
    noisy = np.append(UNEQUAL, np.full(40, 1e-16))

    assert tail_probability(14.0, noisy, NU) == tail_probability(14.0, UNEQUAL, NU)


@pytest.mark.parametrize(("towards", "alike"), [(0.0, 1.0), (12.0, 1.0), (12.0, 2.0), (18.0, 1.0)])
def test_a_column_beside_a_pool_is_judged_by_the_f_test_of_what_it_leaves(towards, alike):
    column = 3.0 * np.eye(1, 30)
    products = Products(column, np.zeros((1, 4)), np.array([towards]))
    past = SimpleNamespace(
        sums=Sums(residual_square=60.0, degrees=26.0, observations=30.0, alike=alike),
        absorbed=lambda products: np.zeros((1, 4)),
        towards=lambda products, absorbed: products.with_residual,
    )

    found = chance_beside(products, np.array([1e6]), past, tried=5)

    explained, degrees = (towards / 3.0) ** 2, 26.0 / alike - 1.0
    alone = stats.f.sf(explained / ((60.0 - explained) / degrees), 1, degrees)
    assert found == pytest.approx(min(1.0, 5 * alone), rel=1e-6)
