"""Lengths of vectors that are known with a covariance."""

import numpy as np
import pytest

from truepose.effects.causes import norm_beyond_noise, norm_with_uncertainty

DRAWS = 1500


@pytest.mark.parametrize("true", [0.5, 1.0, 2.0, 3.0, 5.0, 10.0])
@pytest.mark.parametrize("dimensions", [2, 3])
def test_a_length_lies_within_its_stated_interval_as_often_as_it_says(true, dimensions):
    rng = np.random.default_rng(5)
    estimates = rng.standard_normal((DRAWS, dimensions)) + true * np.eye(dimensions)[0]

    found = np.array([norm_with_uncertainty(vector, np.eye(dimensions)) for vector in estimates])

    within = np.mean(np.abs(found[:, 0] - true) < 1.96 * found[:, 1])
    # 95 % stated, 97 % where the length is hardly known; 1500 draws of that scatter by 0.6 %
    assert 0.93 < within < 0.99


def test_a_length_that_is_well_known_is_that_of_the_vector_with_the_spread_along_it():
    covariance = np.diag([4e-6, 1e-6])

    amplitude, uncertainty = norm_with_uncertainty(np.array([3.0, 0.0]), covariance)

    assert (amplitude, uncertainty) == (pytest.approx(3.0), pytest.approx(2e-3))


def test_a_vector_that_is_nothing_is_as_uncertain_as_all_its_components():
    assert norm_with_uncertainty(np.zeros(2), np.diag([9.0, 16.0])) == (0.0, 5.0)


@pytest.mark.parametrize("turn_rad", [0.0, 0.3, 0.7, 2.2])
def test_a_length_that_noise_across_explains_is_nothing_even_where_it_is_known_exactly_along(turn_rad):
    along = np.array([np.cos(turn_rad), np.sin(turn_rad)])
    across = np.array([-along[1], along[0]])

    amplitude, uncertainty = norm_with_uncertainty(along, 4.0 * np.outer(across, across))

    assert amplitude == pytest.approx(0.0, abs=1e-7)
    assert uncertainty == pytest.approx(1.0)


def test_what_noise_explains_is_no_length():
    assert norm_beyond_noise(np.zeros(2), np.eye(2)) == 0.0
    assert norm_beyond_noise(np.array([0.6, 0.8]), np.eye(2)) == 0.0


def test_a_length_beyond_noise_is_less_than_that_of_the_vector_and_continues_the_amplitude():
    vector, covariance = np.array([3.0, 4.0]), np.eye(2)

    assert norm_beyond_noise(vector, covariance) == pytest.approx(np.sqrt(24.0))
    assert norm_with_uncertainty(vector, covariance)[0] == pytest.approx(np.sqrt(24.0))
