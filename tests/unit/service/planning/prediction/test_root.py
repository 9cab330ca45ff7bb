"""The root of a covariance: as the information has it, and where that has lost its digits."""

import numpy as np

from truepose.planning.prediction.expected_covariance import covariance_root


def test_it_is_that_of_the_information():
    rows = np.random.default_rng(1).standard_normal((20, 6))

    root, turned = covariance_root(rows)

    np.testing.assert_allclose(root, np.linalg.inv(np.linalg.cholesky(rows.T @ rows)).T, atol=1e-12)
    np.testing.assert_allclose(turned, rows @ root, atol=1e-12)


def test_of_what_readings_do_not_show_the_prior_is_left_however_exact_they_are():
    seen = np.array([[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]) / 1e-12

    root, _ = covariance_root(np.vstack([np.eye(3), seen]))

    unseen = np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)
    np.testing.assert_allclose(root @ root.T, np.outer(unseen, unseen), atol=1e-3)
