"""Random functions: as large as the data ask for, and nothing where there is nothing."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from truepose.diagnosis.screening.normal_equations import Sums
from truepose.diagnosis.screening.significance import chance, most_likely


def waves(angle, highest=30):
    return np.stack([wave(k * angle) for k in range(1, highest + 1) for wave in (np.sin, np.cos)])


def drawn(seed, width=0.0, n=400, noise=1.0):
    rng = np.random.default_rng(seed)
    columns = waves(rng.uniform(-1.6, 1.6, n))
    return columns, width * rng.standard_normal(len(columns)) @ columns + noise * rng.standard_normal(n)


def fitted(columns, residual):
    sums = Sums(float(residual @ residual), float(len(residual)), float(len(residual)), 1.0)
    return most_likely(columns @ columns.T, columns @ residual, sums)


def profile(columns, residual, ratio):
    """Twice the log likelihood by the definition: the covariance of the readings, its determinant."""
    n = len(residual)
    covariance = np.eye(n) + ratio * columns.T @ columns
    square = residual @ np.linalg.solve(covariance, residual)
    return -n * np.log(square / n) - np.linalg.slogdet(covariance)[1]


@pytest.mark.parametrize(("seed", "width"), [(1, 0.05), (2, 0.2), (3, 1.0)])
def test_the_size_is_that_of_the_largest_likelihood_of_the_readings(seed, width):
    columns, residual = drawn(seed, width)
    found = fitted(columns, residual)
    best = minimize_scalar(
        lambda x: -profile(columns, residual, np.exp(x)), bounds=(-15.0, 5.0), method="bounded"
    )

    assert found.gain == pytest.approx(-best.fun - profile(columns, residual, 0.0), abs=0.5)  # of the grid
    assert found.width == pytest.approx(width, rel=0.35)


def test_more_parameters_than_readings_are_no_obstacle():
    columns, residual = drawn(4, 0.5, n=40)
    found = fitted(columns, residual)

    assert 0.0 < found.size < 40.0
    assert found.explained < residual @ residual


def test_a_function_that_is_not_there_gains_nothing_and_is_within_chance():
    chances, gains = [], []
    for seed in range(200):
        columns, residual = drawn(seed)
        sums = Sums(float(residual @ residual), float(len(residual)), float(len(residual)), 1.0)
        gains.append(fitted(columns, residual).gain)
        chances.append(chance(columns @ columns.T, columns @ residual, sums))

    assert np.mean(np.array(gains) > 4.0) < 0.05
    assert np.mean(np.array(chances) < 0.1) == pytest.approx(0.1, abs=0.06)


def test_columns_that_see_nothing_are_nothing():
    sums = Sums(10.0, 9.0, 9.0, 1.0)

    assert most_likely(np.zeros((3, 3)), np.zeros(3), sums).gain == -np.inf


def test_a_function_is_no_larger_than_physics_allows():
    columns, residual = drawn(3, 1.0)
    sums = Sums(float(residual @ residual), float(len(residual)), float(len(residual)), 1.0)
    gram, towards = columns @ columns.T, columns @ residual

    free, held = most_likely(gram, towards, sums), most_likely(gram, towards, sums, widest=0.5)

    assert free.width > 0.5 >= held.width > 0.3
    assert held.gain < free.gain


def test_readings_of_a_stop_that_err_alike_are_fitted_best_under_the_width_that_is_found():
    """Three readings a stop with the same error: a fit that counts each must shrink thrice as much."""
    width, squares, found_widths = 0.1, [], []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        columns = np.repeat(waves(rng.uniform(-np.pi, np.pi, 100), highest=4), 3, axis=1)
        weights = width * rng.standard_normal(len(columns))
        residual = weights @ columns + np.repeat(rng.standard_normal(100), 3)
        gram, towards = columns @ columns.T, columns @ residual
        found = most_likely(gram, towards, Sums(float(residual @ residual), 300.0, 300.0, 3.0))
        found_widths.append(found.width)
        squares.append([
            np.sum((np.linalg.solve(gram + np.eye(len(gram)) / prior**2, towards) - weights) ** 2)
            for prior in (found.width, np.sqrt(3.0) * found.width)
        ])

    as_found, as_it_is = np.mean(squares, axis=0)
    # A width by eight weights is known to a quarter, the mean square of a hundred of them to a twentieth.
    assert np.sqrt(3.0 * np.mean(np.square(found_widths))) == pytest.approx(width, rel=0.15)
    assert as_found < as_it_is
