"""Cross-validation: folds in closed form against folds that are fitted."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import NOISE_MM, measured, nominal_campaign
from truepose.domain.campaign import sites
from truepose.identification.fit.assessment import held_out_residuals
from truepose.identification.fit.robust import fit, robust_fit
from truepose.identification.fit.solver import covariance_of, posterior_covariance
from truepose.identification.problem.build import automatic_effects, build


def fitted(n, *, noise_mm=NOISE_MM, **changes):
    campaign = nominal_campaign(n, seed=5, **changes)
    campaign, _ = measured(campaign, noise_mm=noise_mm, seed=2)
    problem = build(campaign, automatic_effects(campaign))
    return robust_fit(problem.structure, problem.blocks, problem.start)


def refitted(found, held):
    """Residuals and variance of readings, by a fit of the others."""
    kept = tuple(block.taken(np.flatnonzero(~held)) for block in found.blocks)
    solution = fit(found.structure, kept, found.values)
    out = found.blocks[0].taken(np.flatnonzero(held)).result(found.structure, solution.values, None)
    spread = np.einsum("pni,pq,qni->n", out.jacobian, solution.covariance, out.jacobian)
    return out.residual, spread / out.residual.shape[1]


@pytest.mark.parametrize("n", [14, 40])
def test_what_one_configuration_is_foretold_is_what_a_fit_of_the_others_foretells(n):
    found = fitted(n)

    residual, variance = held_out_residuals(found)

    # Beside the noise of 15 um: a fit stops 1e-3 of a standard uncertainty short, and one configuration of 14
    # moves the parameters by so much that the second order of turns of 1e-4 rad shows at 0.5 m.
    for row in range(n):
        again, spread = refitted(found, np.arange(n) == row)
        assert residual[[row]] == pytest.approx(again, abs=1e-3, rel=2e-3)
        assert variance[row] == pytest.approx(spread[0], rel=1e-2)


def test_of_many_configurations_a_tenth_is_foretold_at_once():
    found = fitted(60)
    once = held_out_residuals(found)[0]
    parts = np.array_split(np.random.default_rng(0).permutation(60), 10)

    for part in parts:
        held = np.isin(np.arange(60), part)
        assert once[held] == pytest.approx(refitted(found, held)[0], abs=2e-4)


def test_all_readings_of_a_place_are_left_out_together():
    joints = np.repeat(nominal_campaign(20, seed=5).calibration.stops.joints_rad, 2, axis=0)
    found = fitted(40, joints_rad=joints)
    stops = found.blocks[0].targets.stops
    revisits = np.where(np.arange(40) % 2 == 1, stops.config - 1, -1)
    targets = replace(found.blocks[0].targets, stops=replace(stops, repeat_of=revisits))
    block = replace(found.blocks[0], targets=targets)
    revisiting = replace(found, blocks=(block,))

    residual, _ = held_out_residuals(revisiting)

    held = sites(targets.stops) == stops.config[0]
    assert held.sum() == 2
    assert residual[held] == pytest.approx(refitted(found, held)[0], abs=1e-3, rel=2e-3)


def test_without_errors_nothing_is_left_of_what_is_held_out():
    found = fitted(45, noise_mm=0.0, robot=replace(IRB_120, repeatability_mm=0.0))

    residual, variance = held_out_residuals(found)

    # what the priors pull, a tenth of the parameters' share in uncertainty
    assert np.abs(residual).max() < 1e-3
    assert np.all(variance > 0.0)


def test_a_fold_without_which_rounding_leaves_nothing_is_worked_out_from_the_derivatives():
    # the others see the first parameter 1e12 times as well as the second one's prior holds it
    jacobian = np.array([[1e12, 1e12], [1e12, 1e12]])
    precision = np.ones(2)

    assert covariance_of(jacobian @ jacobian.T + np.diag(precision)) is None
    assert np.isfinite(posterior_covariance(jacobian, precision)).all()


def test_a_model_without_parameters_foretells_all_by_itself():
    found = fitted(20)
    bare = found.structure.without(found.structure.effects)
    nominal = replace(found, structure=bare, solution=fit(bare, found.blocks, np.zeros(0)))

    residual, variance = held_out_residuals(nominal)

    assert np.array_equal(residual, nominal.results[0].residual)
    assert np.array_equal(variance, np.zeros(20))
