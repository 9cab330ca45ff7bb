"""Whitening: the factor undoes the covariance, whatever readings share."""

import numpy as np
import pytest

from truepose.domain.campaign import PointReadings, Stops
from truepose.identification.observations.blocks import equal_variance, of_independent, whitener
from truepose.identification.observations.poses import position_block

UNIT = np.broadcast_to(np.eye(3), (6, 3, 3))
STOPS = np.array([4, 4, 7, 9, 9, 9])


def covariances(n=6, seed=0):
    factors = np.random.default_rng(seed).standard_normal((n, 3, 3))
    return factors @ np.swapaxes(factors, 1, 2) + 0.1 * np.eye(3)


def as_matrix(whitening, n=6, d=3):
    """The whitening as one matrix, found by whitening unit vectors."""
    return whitening.apply(np.eye(n * d).reshape(n * d, n, d)).reshape(n * d, n * d).T


def stacked(own, stops, scatter, d=3):
    """The covariance of all readings written out: their own, and the arm's wherever stops agree."""
    together = np.kron(stops[:, None] == stops[None, :], np.eye(d)) * scatter**2
    for k, block in enumerate(own):
        together[d * k : d * k + d, d * k : d * k + d] += block
    return together


def test_equal_axes_on_their_own_are_divided_by_their_uncertainty():
    sigma = np.array([0.1, 0.2, 0.5, 1.0, 2.0, 4.0])
    own = sigma[:, None, None] ** 2 * np.eye(3)

    whitening = whitener(own, np.ones(6), np.arange(6), 0.0 * UNIT)

    residual = np.ones((6, 3))
    assert whitening.apply(residual) == pytest.approx(residual / sigma[:, None])


def test_readings_that_state_no_uncertainty_weigh_nothing_yet():
    sigma = np.array([0.1, 0.0, 0.5, 1.0, 0.0, 4.0])

    whitening = whitener(sigma[:, None, None] ** 2 * np.eye(3), np.ones(6), np.arange(6), 0.0 * UNIT)

    assert whitening.isotropic == pytest.approx([10.0, 0.0, 2.0, 1.0, 0.0, 0.25])


@pytest.mark.parametrize(
    "stops", [np.arange(6), STOPS, np.zeros(6, dtype=int)], ids=["alone", "mixed", "one"]
)
@pytest.mark.parametrize("scatter", [0.0, 0.7])
def test_whitened_readings_have_unit_covariance(stops, scatter):
    own = covariances()

    matrix = as_matrix(whitener(own, np.ones(6), stops, scatter * UNIT))

    white = matrix @ stacked(own, stops, scatter) @ matrix.T
    assert white == pytest.approx(np.eye(18), abs=1e-10)


def test_lengths_share_the_scatter_along_their_own_directions():
    direction = np.array([[1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    own = np.full((3, 1, 1), 0.04)

    matrix = as_matrix(whitener(own, np.ones(3), np.ones(3), 0.5 * direction[:, None, :]), n=3, d=1)

    covariance = 0.04 * np.eye(3) + 0.25 * direction @ direction.T
    assert matrix @ covariance @ matrix.T == pytest.approx(np.eye(3), abs=1e-12)


@pytest.mark.parametrize("stops", [np.arange(6), STOPS], ids=["alone", "mixed"])
def test_a_reading_of_no_weight_says_nothing_and_leaves_the_others_alone(stops):
    own, weights = covariances(), np.array([1.0, 0.0, 1.0, 1.0, 1.0, 0.0])
    kept = weights > 0
    residual = np.random.default_rng(1).standard_normal((6, 3))

    white = whitener(own, weights, stops, 0.3 * UNIT).apply(residual)

    alone = whitener(own[kept], np.ones(4), stops[kept], 0.3 * UNIT[kept]).apply(residual[kept])
    # no weight is a variance 1e12 times as large: what is left of it is of the order of 1e-6
    assert np.sum(white**2) == pytest.approx(np.sum(alone**2), rel=1e-5)


def test_derivatives_are_whitened_like_residuals():
    whitening = whitener(covariances(), np.ones(6), STOPS, 0.3 * UNIT)
    several = np.random.default_rng(2).standard_normal((5, 6, 3))

    together = whitening.apply(several)

    assert together == pytest.approx(np.stack([whitening.apply(one) for one in several]))


def test_readings_that_share_nothing_weigh_by_their_variance_alone():
    variance, weights = np.linspace(0.5, 2.0, 6), np.array([1.0, 0.0, 0.3, 1.0, 1e-14, 1.0])
    residual = np.random.default_rng(1).normal(size=(6, 3))

    once = of_independent(variance + 0.09, weights).apply(residual)

    general = whitener(variance[:, None, None] * np.eye(3), weights, np.arange(6), 0.3 * UNIT).apply(residual)
    assert once == pytest.approx(general, rel=1e-12)


def test_a_reading_that_is_worse_along_one_axis_has_no_one_variance():
    equal = np.linspace(0.5, 2.0, 6)[:, None, None] * np.eye(3)
    leaning = equal.copy()
    leaning[2, 2, 2] *= 1.01

    assert equal_variance(equal) == pytest.approx(np.linspace(0.5, 2.0, 6))
    assert equal_variance(leaning) is None


@pytest.mark.parametrize(
    ("stops", "scatter_mm", "alone"),
    [((1, 2, 3), 0.03, 0.05**2), ((1, 1, 2), 0.0, 0.04**2), ((1, 1, 2), 0.03, None)],
)
def test_one_number_whitens_positions_unless_readings_of_a_stop_share_the_scatter(stops, scatter_mm, alone):
    at = Stops(np.array(stops), np.zeros((3, 6)))

    block = position_block(PointReadings(at, np.ones(3, int), np.zeros((3, 3)), np.full(3, 0.04)), scatter_mm)

    assert block.lone_mm2 == (None if alone is None else pytest.approx(np.full(3, alone)))
