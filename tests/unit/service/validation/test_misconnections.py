"""What may have been connected instead: odds by the figures of the module's head, densities by scipy."""

from collections import defaultdict

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from truepose.validation.misconnections import LengthForecast, log_likelihood, next_slips, slips


def odds_of(asked, pairs, *, questioned=False):
    odds = defaultdict(float)
    for row, log_odds in zip(*slips(asked, pairs, questioned=questioned), strict=True):
        odds[tuple(row.tolist())] += np.exp(log_odds)
    return odds


@pytest.mark.parametrize(("pairs", "others"), [(3, 8), (9, 8), (10, 9), (12, 11)])
def test_a_confusion_is_shared_among_all_other_pairs(pairs, others):
    odds = odds_of((0, 1), pairs)

    twice = 0.01 / others + 0.001
    assert odds[0, 1] == 1.0
    assert odds[2, 1] == odds[0, 2] == pytest.approx(0.01 / others)
    assert odds[1, 1] == odds[0, 0] == pytest.approx(twice)
    assert odds[pairs, 1] == pytest.approx(0.0002)
    assert odds[2, pairs] == pytest.approx(0.01 / others * 0.0002)
    assert odds[1, 0] == pytest.approx(0.5 * 0.01 / others + twice**2)


def test_who_was_asked_and_maintained_it_has_hardly_read_a_pair_twice():
    assert odds_of((0, 1), 3, questioned=True)[1, 1] == pytest.approx(0.1 * (0.01 / 8 + 0.001))
    assert odds_of((0, 1), 3, questioned=True)[2, 1] == pytest.approx(0.01 / 8)


def test_three_readings_that_changed_places_are_one_slip_more_than_two():
    odds = odds_of((0, 1, 2), 9)

    assert odds[1, 2, 0] == odds[2, 0, 1] == pytest.approx(0.5 * 0.01 / 8**2)


@pytest.mark.parametrize("affirmed", [False, True])
def test_the_next_reading_follows_what_was_read_before(affirmed):
    # Pair 1 is due of three, the last column is nothing; pair 0 was asked, and each of them read.
    usual, again, nothing = 0.01 / 8, 0.01 / 8 + 0.001, 0.0002
    expected = np.array([
        [again, 0.99, usual, nothing],
        [0.5, 0.5, usual, nothing],
        [usual, 0.99, again, nothing],
        [usual, 0.99, usual, nothing],
    ])
    if affirmed:
        expected[:, [0, 2, 3]] *= 0.1

    odds = next_slips(1, 3, [0], np.array([[0], [1], [2], [3]]), affirmed=affirmed)

    assert np.exp(odds) == pytest.approx(expected)


def test_the_likelihood_is_a_gaussian_mixed_over_how_well_the_forecast_is_founded():
    pairs, covariance = ((1, 1), (2, 1)), np.array([[0.04, 0.01], [0.01, 0.09]])
    forecast = LengthForecast(pairs, np.array([300.0, 300.5]), covariance, 0.01, 1.5)
    readings = {(1, 1): 300.2, (2, 1): 300.3}
    # As asked, exchanged, the second pair twice, and nothing (about the nominal length of what was asked).
    assignments = np.array([[0, 1], [1, 0], [1, 1], [2, 1]])

    found = log_likelihood(forecast, pairs, readings, assignments)

    alone = np.array([[1.5, 0.0], [0.0, 0.09]])
    means = [[300.0, 300.5], [300.5, 300.0], [300.5, 300.5], [300.0, 300.5]]
    for density, mean, taken in zip(found, means, assignments, strict=True):
        mixed = 0.0
        for scale, share in ((1.0, 0.95), (2.0, 0.04), (4.0, 0.01)):
            if 2 in taken:
                spread = alone * [[1.0, 0.0], [0.0, scale**2]]
            else:
                spread = scale**2 * covariance[np.ix_(taken, taken)]
            mixed += share * multivariate_normal(mean, spread + 0.01 * np.eye(2)).pdf([300.2, 300.3])
        assert density == pytest.approx(np.log(mixed))
