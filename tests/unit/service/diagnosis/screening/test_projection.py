"""What the present parameters absorb, by a basis and by normal equations, against plain least squares."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from tests.helpers.diagnosis.least_squares import left_square, left_square_beside, stacked
from tests.helpers.diagnosis.selections import make_selected, make_start
from truepose.diagnosis.screening.normal_equations import design_effect, normal_of, products_of
from truepose.domain.campaign import Stops
from truepose.identification.fit.robust import fit

GAIN = ("joint_gain", "joint 4")
NAMES = ("first", "second", "third", "fourth", "fifth", "sixth")


@pytest.fixture(scope="module")
def start():
    return make_start({"joint_gain": {"gain_4": 3e-4}})


@pytest.fixture(scope="module")
def extended(start):
    """The model with the gain of joint 4."""
    return make_selected(start, [GAIN], [("joint_gain", "joint 2"), ("joint_coupling", "joint 6")])


def trial_columns(selected):
    return selected.pool.products.columns[1:]  # all but the pick's own


def projected(matrix, vectors):
    """Vectors less their part within the columns of a matrix, by an orthonormal basis."""
    basis, _ = np.linalg.qr(matrix / np.linalg.norm(matrix, axis=0))
    for _ in range(2):
        vectors = vectors - basis @ (basis.T @ vectors)
    return vectors


def test_normal_equations_leave_what_a_projection_leaves(extended):
    matrix, residual = stacked(extended.fit)
    columns = trial_columns(extended)
    wider = np.vstack([columns.T, np.zeros((matrix.shape[1], len(columns)))])
    past = normal_of(extended.fit).past()
    products = products_of(extended.fit, columns)

    absorbed = past.absorbed(products)

    left, left_of_residual = projected(matrix, wider), projected(matrix, residual)
    # normal equations square the condition of the derivatives: half of the sixteen digits remain
    assert past.sums.residual_square == pytest.approx(left_of_residual @ left_of_residual, rel=1e-6)
    assert columns @ columns.T - absorbed @ absorbed.T == pytest.approx(left.T @ left, rel=1e-6)
    assert past.towards(products, absorbed) == pytest.approx(left.T @ left_of_residual, rel=1e-5)


def test_priors_count_as_observations_so_that_their_parameters_cost_no_degree(extended):
    # P parameters with P priors; 80 readings of a nest and 18 of fixed nests, all of them good
    assert normal_of(extended.fit).past().sums.degrees == 3 * (80 + 18)


def test_a_pick_in_the_pool_leaves_what_a_fit_with_it_would_leave(extended):
    pick = extended.pool.all[1]  # the first one that is not fitted

    view = extended.pool.beside(1, pick).view()

    widths = [spec.prior_width for spec in pick.specs]
    expected = left_square_beside(extended.fit, extended.pool.rows(1), widths)
    assert view.sums.residual_square == pytest.approx(expected, rel=1e-6)
    assert set(pick.names) <= view.fitted
    # nothing of its own columns is left but what its prior holds back
    assert np.abs(np.diag(view.gram(1))).max() < 1e-3 * np.diag(extended.pool.grams[1]).max()


def test_the_pool_of_some_readings_is_that_of_a_fit_which_never_saw_the_others(extended):
    final = extended.fit.solution.final
    rows = np.arange(final.residual.size) % 7 != 0

    part = extended.pool.of_rows(rows)

    matrix, residual = stacked(extended.fit)
    kept = np.append(rows, np.ones(matrix.shape[1], dtype=bool))
    assert part.view().sums.residual_square == pytest.approx(
        left_square(matrix[kept], residual[kept]), rel=1e-6
    )
    assert part.view().sums.observations == rows.sum()
    assert part.grams[1] == pytest.approx(extended.pool.rows(1)[:, rows] @ extended.pool.rows(1)[:, rows].T)


def test_the_step_leads_to_the_least_squares_solution(extended):
    matrix, residual = stacked(extended.fit)
    final = extended.fit.solution.final
    rows = np.arange(final.residual.size) % 7 != 0
    kept = np.append(rows, np.ones(matrix.shape[1], dtype=bool))
    scale = np.linalg.norm(matrix, axis=0)

    step = normal_of(extended.fit, rows).past().step()

    expected = np.linalg.lstsq(matrix[kept] / scale, residual[kept], rcond=None)[0] / scale
    spread = np.sqrt(np.diag(extended.fit.solution.covariance))
    assert step / spread == pytest.approx(expected / spread, abs=1e-5)


def test_a_parameter_taken_out_of_the_linear_problem_is_as_if_it_had_never_been_fitted(extended):
    matrix, residual = stacked(extended.fit)
    out = extended.fit.structure.index_of("gain_4")
    m = extended.fit.solution.final.residual.size
    rows, columns = np.arange(len(residual)) != m + out, np.arange(matrix.shape[1]) != out
    raw = residual + matrix[:, out] * extended.fit.values[out]  # the residual with a gain of zero

    past = normal_of(extended.fit).past(without=("gain_4",))

    expected = left_square(matrix[np.ix_(rows, columns)], raw[rows])
    assert past.sums.residual_square == pytest.approx(expected, rel=1e-6)


def test_without_a_parameter_the_linear_problem_is_that_of_a_fit_without_it(start, extended):
    without = start.fit.structure
    values = [extended.fit.values[extended.fit.structure.index_of(name)] for name in without.names]
    again = fit(without, extended.fit.blocks, np.array(values))  # weights and discrepancy as they are
    priors = (without.prior_means - again.values) / without.prior_widths

    past = normal_of(extended.fit).past(without=("gain_4",))

    square = float(again.final.residual @ again.final.residual + priors @ priors)
    # to first order: the gain turns the joint by up to 0.8 mrad, so derivatives change by a thousandth
    assert past.sums.residual_square == pytest.approx(square, rel=2e-3)
    assert square > 2.0 * normal_of(extended.fit).past().sums.residual_square


def test_random_effects_besides_are_parameters_with_a_prior(extended):
    columns = trial_columns(extended)
    widths = np.geomspace(1e-5, 1e-3, len(columns))

    past = (
        normal_of(extended.fit)
        .beside(products_of(extended.fit, columns), widths, NAMES[: len(columns)])
        .past()
    )

    expected = left_square_beside(extended.fit, columns, widths)
    assert past.sums.residual_square == pytest.approx(expected, rel=1e-6)


@dataclass
class Plain:
    """Readings of equal, independent components: all that counting them looks at."""

    residual: np.ndarray
    direction: None = None

    @property
    def whitening(self):
        return SimpleNamespace(apply=lambda residual: residual)


def block_of(config, weights=None):
    config = np.asarray(config)
    stops = Stops(config, np.zeros((len(config), 6)))
    weights = np.ones(len(config)) if weights is None else weights
    return SimpleNamespace(weights=weights, counts=weights > 0.5, targets=SimpleNamespace(stops=stops))


def vectors(n, seed=0):
    return np.random.default_rng(seed).standard_normal((n, 3))


def test_single_readings_of_a_stop_are_worth_one_each():
    assert design_effect(block_of(np.arange(40)), Plain(vectors(40))) == 1.0


@pytest.mark.parametrize("copies", [2, 3, 5])
def test_copies_of_a_reading_are_worth_one_together(copies):
    config = np.repeat(np.arange(40), copies)

    alike = design_effect(block_of(config), Plain(np.repeat(vectors(40), copies, axis=0)))

    assert alike == pytest.approx(copies)


def test_independent_readings_of_a_stop_are_worth_nearly_one_each():
    alike = design_effect(block_of(np.repeat(np.arange(200), 3)), Plain(vectors(600)))

    # 1800 pairs of components: the correlation has a standard deviation of 0.024, its clip at 0 helps
    assert 1.0 <= alike <= 1.0 + 2 * 3 * 0.024


def test_readings_without_weight_do_not_count():
    config = np.repeat(np.arange(40), 2)
    weights = np.tile([1.0, 0.0], 40)

    assert design_effect(block_of(config, weights), Plain(np.repeat(vectors(40), 2, axis=0))) == 1.0
