"""The solver against closed forms: linear problems, curved valleys, priors, and ends it does not reach."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from truepose.identification.fit.solver import posterior_covariance, solve


@dataclass(frozen=True)
class Point:
    """A problem at one point, as the solver sees it."""

    residual: np.ndarray
    jacobian: np.ndarray

    def with_derivatives_of(self, near):
        return replace(self, jacobian=near.jacobian)


def linear(design, observed):
    """Predictions design @ p; design of shape (m, P)."""
    return lambda values, _previous: Point(observed - design @ values, design.T)


def rosenbrock(values, _previous):
    """Residuals 1 - x and 10 (y - x^2), in the sign of observation minus prediction."""
    x, y = values
    return Point(np.array([1.0 - x, 10.0 * (x**2 - y)]), np.array([[1.0, -20.0 * x], [0.0, 10.0]]))


def problem(seed=0, m=40, parameters=4):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((m, parameters)), rng.standard_normal(m)


def test_a_linear_problem_ends_at_the_closed_form():
    design, observed = problem()
    means, widths = np.array([1.0, -2.0, 0.5, 0.0]), np.array([0.3, 1.0, 10.0, 0.1])

    solution = solve(linear(design, observed), np.zeros(4), means, widths)

    precision = np.diag(1.0 / widths**2)
    closed = np.linalg.solve(design.T @ design + precision, design.T @ observed + precision @ means)
    assert solution.converged
    assert solution.values == pytest.approx(closed, rel=1e-10)  # one exact step; the second changes rounding


def test_the_covariance_is_the_inverse_of_information_and_prior():
    design, observed = problem()
    widths = np.array([0.3, 1.0, 10.0, 0.1])

    solution = solve(linear(design, observed), np.zeros(4), np.zeros(4), widths)

    closed = np.linalg.inv(design.T @ design + np.diag(1.0 / widths**2))
    assert solution.covariance == pytest.approx(closed, rel=1e-10)
    assert posterior_covariance(design.T, 1.0 / widths**2) == pytest.approx(closed, rel=1e-10)


def test_repeated_draws_of_truth_and_noise_scatter_as_the_covariance_says():
    design, _ = problem(m=8, parameters=3)
    widths, rng = np.array([0.2, 1.0, 3.0]), np.random.default_rng(4)
    errors = []
    for _ in range(3000):
        truth = widths * rng.standard_normal(3)
        observed = design @ truth + rng.standard_normal(8)
        solution = solve(linear(design, observed), np.zeros(3), np.zeros(3), widths)
        errors.append(solution.values - truth)

    scatter = np.cov(np.array(errors).T)
    scale = np.sqrt(np.outer(np.diag(solution.covariance), np.diag(solution.covariance)))
    # 3,000 draws know each entry to sqrt(2 / 3000) = 2.6 %; four times that
    assert np.abs(scatter - solution.covariance).max() < 0.11 * scale.max()
    assert np.diag(scatter) == pytest.approx(np.diag(solution.covariance), rel=0.11)


def test_parameters_of_very_different_size_meet_on_equal_terms():
    design, observed = problem()
    units = np.array([1e3, 1.0, 1e-8, 1e-3])
    wide = 1e6 / units

    solution = solve(linear(design * units, observed), np.zeros(4), np.zeros(4), wide)

    closed = np.linalg.lstsq(design, observed, rcond=None)[0] / units
    # the priors pull by one part in 1e12 of 1e6 widths
    assert solution.values == pytest.approx(closed, rel=1e-8)


def test_a_curved_valley_is_followed_to_its_end():
    solution = solve(rosenbrock, np.array([-1.2, 1.0]), np.zeros(2), np.full(2, 1e6))

    assert solution.converged
    # stopped when less than a thousandth of a standard uncertainty (1 and 2 here) remains
    assert solution.values == pytest.approx([1.0, 1.0], abs=2e-3)


def test_where_a_full_step_overshoots_it_is_damped():
    def steep(values, _previous):  # arctan: full Gauss-Newton steps diverge from 2
        return Point(-10.0 * np.arctan(values), (10.0 / (1.0 + values**2))[None])

    solution = solve(steep, np.array([2.0]), np.zeros(1), np.array([1e6]))

    assert solution.converged
    assert abs(solution.values[0]) < 1e-3 * np.sqrt(solution.covariance[0, 0])


@pytest.mark.parametrize(("steps_away", "kept"), [(0.02, True), (10.0, False)])
def test_after_a_short_step_the_derivatives_of_the_point_before_stand(steps_away, kept):
    def curved(values, _previous):  # zero at the root of 1 = x + x^2 / 10
        return Point(1e3 * (1.0 - values - values**2 / 10.0), 1e3 * (1.0 + values / 5.0)[None])

    root = 5.0 * (np.sqrt(1.4) - 1.0)
    uncertainty = 1e-3 / (1.0 + root / 5.0)
    start = np.array([root + steps_away * uncertainty])

    solution = solve(curved, start, np.zeros(1), np.array([1e6]))

    assert solution.converged
    assert solution.values == pytest.approx([root], abs=1e-3 * uncertainty)
    assert (solution.final.jacobian == curved(start, None).jacobian) == kept


def test_too_few_iterations_are_not_called_converged():
    solution = solve(rosenbrock, np.array([-1.2, 1.0]), np.zeros(2), np.full(2, 1e6), max_iterations=2)

    assert not solution.converged
    assert solution.iterations == 2


def test_a_short_step_that_damping_made_is_no_end():
    """A derivative of the wrong sign leads uphill, so every step is refused until damping gives up."""

    def misled(values, _previous):
        return Point(np.array([5.0 - values[0]]), np.array([[-1.0]]))

    solution = solve(misled, np.zeros(1), np.zeros(1), np.array([1e6]))

    assert not solution.converged
    assert abs(solution.values[0]) < 0.1  # the minimum is at 5; uphill it creeps no further than it may


def test_what_the_data_do_not_see_stays_at_its_prior():
    design, observed = problem()
    design[:, 2] = 0.0

    solution = solve(linear(design, observed), np.zeros(4), np.array([0.0, 0.0, 7.0, 0.0]), np.ones(4))

    assert solution.values[2] == pytest.approx(7.0)
    assert solution.covariance[2, 2] == pytest.approx(1.0)


@pytest.mark.parametrize("precise", [1e3, 1e7, 1e9])
def test_a_prior_is_not_lost_beside_readings_of_any_precision(precise):
    """Only the sum is seen: the difference stays as uncertain as believed, whatever doubles lose in J J^T."""
    design = precise * np.ones((10, 2))

    solution = solve(linear(design, 3.0 * design[:, 0]), np.zeros(2), np.array([1.0, 0.0]), np.ones(2))

    difference = np.array([1.0, -1.0])
    assert difference @ solution.covariance @ difference == pytest.approx(2.0, rel=1e-3)
    assert solution.values == pytest.approx([2.0, 1.0], rel=1e-3)


def test_a_model_without_parameters_is_where_it_should_be():
    solution = solve(linear(np.zeros((5, 0)), np.ones(5)), np.zeros(0), np.zeros(0), np.zeros(0))

    assert solution.converged
    assert solution.covariance.shape == (0, 0)
