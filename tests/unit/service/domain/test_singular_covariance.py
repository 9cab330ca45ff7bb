"""Equations with covariances: as ever where definite, in the determined subspace where singular."""

import numpy as np
import pytest

from truepose.domain.singular_covariance import inverse, solve_singular, whitening_root

RNG = np.random.default_rng(4)
SIZES = np.array([1e-8, 1.0, 300.0, 1e3])  # parameters in rad per N mm beside others in mm


def definite(k=4):
    root = RNG.standard_normal((k, k + 3))
    return root @ root.T * np.outer(SIZES, SIZES)


def singular():
    """Two parameters that are one, and two more."""
    three = definite()[1:, 1:]
    twice = np.array([[1.0, 0, 0], [1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
    return twice @ three @ twice.T, three, twice


def test_a_definite_covariance_is_solved_and_inverted_as_ever():
    covariance, right = definite(), RNG.standard_normal(4)

    assert np.array_equal(solve_singular(covariance, right), np.linalg.solve(covariance, right))
    assert np.array_equal(inverse(covariance), np.linalg.inv(covariance))


def test_parameters_that_are_one_are_solved_as_that_one():
    covariance, three, twice = singular()
    right = twice @ np.array([0.3, -2.0, 5.0])

    found = solve_singular(covariance, right)

    assert covariance @ found == pytest.approx(right, rel=1e-9)
    assert right @ found == pytest.approx(right[1:] @ np.linalg.solve(three, right[1:]), rel=1e-9)
    assert inverse(covariance) @ right == pytest.approx(found, rel=1e-9)


def test_what_does_not_vary_is_no_direction():
    covariance = np.diag([4.0, 0.0])

    assert solve_singular(covariance, np.array([8.0, 3.0])) == pytest.approx([2.0, 0.0])
    assert solve_singular(np.zeros((2, 2)), np.array([1.0, 1.0])) == pytest.approx([0.0, 0.0])
    assert solve_singular(np.zeros((0, 0)), np.zeros(0)).shape == (0,)


def test_a_definite_covariance_is_whitened_by_its_cholesky_factor():
    covariance = np.stack([definite(), definite()])

    root = whitening_root(covariance)

    assert root @ covariance @ np.swapaxes(root, 1, 2) == pytest.approx(np.stack([np.eye(4)] * 2), abs=1e-7)
    assert np.triu(root[0], 1) == pytest.approx(0.0, abs=1e-12)


def test_readings_that_share_all_they_vary_by_are_whitened_to_rounding():
    shared = np.array([[1.0, 1.0, 1.0]])
    covariance = np.stack([1e-18 * np.eye(3) + shared.T @ shared, np.eye(3)])

    root = whitening_root(covariance)

    with pytest.raises(np.linalg.LinAlgError):
        np.linalg.cholesky(covariance)
    assert np.isfinite(root).all()
    assert (root[0] @ np.ones(3)) ** 2 @ np.ones(3) == pytest.approx(1.0)
    assert root[1] @ root[1].T == pytest.approx(np.eye(3))
