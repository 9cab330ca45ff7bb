"""Screening: what a candidate explains, and how improbable noise alone makes it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.least_squares import left_square, left_square_beside, stacked
from tests.helpers.diagnosis.selections import make_selected, make_start, proposed
from truepose.diagnosis.screening.candidates import pool_candidates
from truepose.diagnosis.screening.significance import screen
from truepose.effects.ports import ParameterSpec

GAINS = [("joint_gain", f"joint {joint}") for joint in (2, 4, 5)]
COUPLING = ("joint_coupling", "joint 6")
WAVE = ("joint_harmonics", "joint 6", "wave_6_2_sin")
WIDE = 1e6  # a belief that says nothing


@pytest.fixture(scope="module")
def start():
    return make_start({})


def candidate(start, *name, width=None):
    found = proposed(start.scene, *name)[0]
    if width is None:
        return found
    return found._replace(specs=tuple(spec._replace(prior_width=width) for spec in found.specs))


def least_squares_gain(fit, columns, widths):
    """What a real fit with further parameters would take off the sum of squares."""
    return left_square(*stacked(fit)) - left_square_beside(fit, columns, widths)


@pytest.mark.parametrize("name", [GAINS[0], GAINS[1], COUPLING, WAVE])
def test_a_candidate_explains_what_a_fit_with_it_would(start, name):
    tried = candidate(start, *name, width=WIDE)
    pool = pool_candidates(start.fit, [tried])

    screened = screen(pool.view())

    expected = least_squares_gain(start.fit, pool.rows(0), np.full(len(tried.specs), WIDE))
    # normal equations keep half of the digits of a sum of squares of about 300
    assert screened.explained[0] == pytest.approx(expected, rel=1e-4, abs=1e-6)
    assert screened.size[0] == len(tried.specs)


def test_a_belief_shrinks_what_a_single_parameter_explains_as_in_a_fit(start):
    column = pool_candidates(start.fit, [candidate(start, *GAINS[1])]).rows(0)
    width = 1.0 / float(np.linalg.norm(column))  # as much as the data know

    screened = screen(pool_candidates(start.fit, [candidate(start, *GAINS[1], width=width)]).view())

    expected = least_squares_gain(start.fit, column, [width])
    assert screened.explained[0] == pytest.approx(expected, rel=1e-4, abs=1e-6)


def test_an_amplitude_that_nobody_would_believe_explains_nothing(start):
    screened = screen(pool_candidates(start.fit, [candidate(start, *GAINS[1], width=1e-12)]).view())

    assert screened.explained[0] == pytest.approx(0.0, abs=1e-9)
    assert (screened.size[0], screened.p_value[0], screened.score[0]) == (0.0, 1.0, -np.inf)


def test_what_the_model_already_has_is_not_found_again(start):
    selected = make_selected(start, [GAINS[1]], [GAINS[0]])

    screened = screen(selected.pool.view())

    assert [pick.subject for pick in selected.pool.all] == ["joint 4", "joint 2"]
    # a second parameter of the same column only widens the belief in the first, which is nearly zero here
    assert screened.explained[0] < 1e-3
    assert screened.p_value[0] > 0.5
    assert screened.score[0] < 0.0


def test_a_pick_taken_out_of_the_model_explains_what_it_explained(start):
    with_gain = make_start({"joint_gain": {"gain_4": 3e-4}})
    before = screen(pool_candidates(with_gain.fit, [candidate(with_gain, *GAINS[1])]).view())
    selected = make_selected(with_gain, [GAINS[1]])

    again = screen(selected.pool.view(without=("gain_4",)))

    # the fit without the gain takes what it lacks for noise (a discrepancy), so it sees less of it
    assert again.explained[0] > before.explained[0] > 20.0
    assert again.p_value[0] < 1e-6


def noise_on(pool, rng):
    """The pool as it were if the model were right and the readings were noise of unit variance."""
    fit = pool.fit
    final, structure = fit.solution.final, fit.structure
    noise = rng.standard_normal(final.residual.size)
    normal = replace(
        pool.normal,
        deviation=structure.prior_widths * rng.standard_normal(len(structure.names)),
        towards=final.jacobian @ noise,
        residual_square=float(noise @ noise),
    )
    products = replace(pool.products, with_residual=pool.products.columns @ noise)
    return replace(pool, normal=normal, products=products)


@pytest.mark.parametrize("name", [GAINS[1], WAVE])
def test_noise_makes_every_p_value_equally_often(start, name):
    from scipy.stats import kstest  # takes each process that collects this a quarter of a second

    rng = np.random.default_rng(4)
    pool = pool_candidates(start.fit, [candidate(start, *name, width=WIDE)])

    p_values = [screen(noise_on(pool, rng).view()).p_value[0] for _ in range(500)]

    # Kolmogorov and Smirnov would reject uniform values once in a thousand seeds; this one is fixed
    assert kstest(p_values, "uniform").pvalue > 1e-3


def test_the_size_of_the_noise_is_that_of_the_residuals_not_what_is_stated(start):
    pool = noise_on(
        pool_candidates(start.fit, [candidate(start, *GAINS[1], width=WIDE)]), np.random.default_rng(0)
    )
    louder = replace(
        pool,
        normal=replace(
            pool.normal,
            deviation=7.0 * pool.normal.deviation,
            towards=7.0 * pool.normal.towards,
            residual_square=49.0 * pool.normal.residual_square,
        ),
        products=replace(pool.products, with_residual=7.0 * pool.products.with_residual),
    )

    assert screen(louder.view()).p_value == pytest.approx(screen(pool.view()).p_value, rel=1e-6)


def test_the_level_is_shared_by_all_causes_and_within_a_cause_by_all_its_candidates(start):
    gains, coupling = [candidate(start, *name) for name in GAINS], candidate(start, *COUPLING)

    alone = [float(screen(pool_candidates(start.fit, [one]).view()).p_value[0]) for one in (*gains, coupling)]
    together = screen(pool_candidates(start.fit, [*gains, coupling]).view()).p_value

    expected = [min(1.0, 2 * 3 * p) for p in alone[:3]] + [min(1.0, 2 * alone[3])]
    assert together == pytest.approx(expected, rel=1e-6)
    assert together.min() < 1.0


def test_readings_that_repeat_one_another_make_nothing_less_probable(start):
    pool = pool_candidates(start.fit, [candidate(start, *WAVE)])
    alike = replace(pool, normal=replace(pool.normal, alike=3.0))

    assert screen(alike.view()).p_value[0] > screen(pool.view()).p_value[0]


def test_what_was_searched_over_costs_score(start):
    waves = proposed(start.scene, "joint_harmonics", "joint 6")

    alone = screen(pool_candidates(start.fit, waves[:1]).view()).score[0]
    among = screen(pool_candidates(start.fit, waves).view()).score[0]

    assert alone - among == pytest.approx(2.0 * np.log(len(waves)), rel=1e-6)


def test_the_shape_that_takes_no_search_does_not_pay_for_it(start):
    drifts = proposed(start.scene, "base_drift", "base")

    alone = [screen(pool_candidates(start.fit, [drift]).view()).score[0] for drift in drifts[:2]]
    among = screen(pool_candidates(start.fit, drifts).view()).score[:2]

    assert [drift.variant > 0.0 for drift in drifts[:2]] == [False, True]
    assert alone - among == pytest.approx([0.0, 2.0 * np.log(len(drifts))], rel=1e-6)


def test_nothing_tried_is_nothing_screened(start):
    assert screen(pool_candidates(start.fit, []).view()).p_value.size == 0


def test_parameters_with_one_column_twice_count_once(start):
    gain = candidate(start, *GAINS[1])
    double = gain._replace(specs=(gain.specs[0], ParameterSpec(gain.names[0], "1", 0.0, WIDE)))

    assert screen(pool_candidates(start.fit, [double]).view()).size[0] == 1.0
