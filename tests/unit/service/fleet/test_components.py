"""Variance components against published ones, a general optimiser, and closed forms."""

import numpy as np
import pytest
from scipy.optimize import minimize

from tests.helpers.fleet.linear import Dense, drawn, told
from truepose.effects.ports import ParameterSpec
from truepose.fleet.campaigns import FleetCampaign, fleet_of
from truepose.fleet.mixed_model import Equations, estimate, uncertainties

# Yields of six batches, five samples each: O. L. Davies, P. L. Goldsmith, Statistical Methods in Research
# and Production, 4th ed., 1972, table 6.2. Restricted maximum likelihood: 1764.05 between, 2451.25 within
# (D. Bates, M. Maechler, B. Bolker, S. Walker, lme4, data set Dyestuff).
_DYES = (
    (1545, 1440, 1440, 1520, 1580),
    (1540, 1555, 1490, 1560, 1495),
    (1595, 1550, 1605, 1510, 1560),
    (1445, 1440, 1595, 1465, 1545),
    (1595, 1630, 1515, 1635, 1625),
    (1520, 1455, 1450, 1480, 1445),
)
_WITHIN, _BETWEEN = 2451.25, 1764.05
# The same with a variance between batches of nothing: G. E. P. Box, G. C. Tiao, Bayesian Inference in
# Statistical Analysis, 1973, table 5.1.4 (Dyestuff2).
_NO_DIFFERENCE = (
    (7.298, 3.846, 2.434, 9.566, 7.990),
    (5.220, 6.556, 0.608, 11.788, -0.892),
    (0.110, 10.386, 13.434, 5.510, 8.166),
    (2.212, 4.852, 7.092, 9.288, 4.980),
    (0.282, 9.014, 4.458, 9.446, 7.198),
    (1.722, 4.782, 8.106, 0.758, 3.758),
)


def _batches(table, within, width):
    spec = ParameterSpec("theta_2", "rad", 0.0, width)
    sigma = np.sqrt(within)
    return fleet_of([
        FleetCampaign(
            f"batch {k}",
            "scales",
            0.0,
            told(np.full((1, len(row)), 1 / sigma), np.array(row) / sigma, [spec]),
        )
        for k, row in enumerate(table)
    ])


def test_a_published_example_is_met():
    width = 1e4  # of the mean of the yields: next to no knowledge

    found = estimate(Equations(_batches(_DYES, _WITHIN, width)))

    assert found.settled
    assert found.variances.robot[0] * width**2 == pytest.approx(
        _BETWEEN, rel=0.03
    )  # of its settled likelihood


def test_the_uncertainty_of_a_balanced_design_is_its_closed_form():
    width, batches, samples = 1e4, 6, 5

    found = estimate(Equations(_batches(_DYES, _WITHIN, width)))

    between = found.variances.robot[0] * width**2
    expected = np.sqrt(2.0 / (batches - 1)) * (between + _WITHIN / samples)
    assert uncertainties(found)[0] * width**2 == pytest.approx(expected, rel=1e-3)


def test_where_nothing_differs_the_variance_is_nothing():
    width = 1e3

    found = estimate(Equations(_batches(_NO_DIFFERENCE, 13.81, width)))

    assert np.sqrt(found.variances.robot[0]) * width < 0.2  # a twentieth of the spread within


def test_a_general_optimiser_finds_the_same():
    made = drawn(4)
    dense = Dense(made)

    found = estimate(Equations(made.fleet()))

    best = minimize(
        lambda logs: -dense.log_likelihood(np.exp(logs[:3]), np.exp(logs[3])),
        np.full(4, -3.0),
        method="L-BFGS-B",
    )
    assert found.settled
    ours = dense.log_likelihood(found.variances.robot, found.variances.day)
    assert ours == pytest.approx(-best.fun, abs=0.02)  # twenty times what a step must still gain


@pytest.mark.parametrize("seed", range(4))
def test_robots_that_differ_by_more_than_was_stated_differ_by_what_was_stated(seed):
    variances = estimate(
        Equations(drawn(seed, robot=(3.0, 2.0, 3.0), day=3.0, readings=40).fleet())
    ).variances

    assert max(*variances.robot, variances.day) <= 1.0


def test_no_step_lowers_the_likelihood():
    equations = Equations(drawn(5, robot=(0.5, 0.0, 0.0), day=0.0).fleet())
    start = estimate(equations)

    again = estimate(equations, start.variances)

    assert again.log_likelihood >= start.log_likelihood - 1e-3


def test_of_a_parameter_that_no_campaign_shows_no_more_is_known_than_was_stated():
    seen, unseen = ParameterSpec("theta_2", "rad", 0.0, 1e4), ParameterSpec("theta_6", "rad", 0.0, 1.0)
    sigma = np.sqrt(_WITHIN)
    fleet = fleet_of([
        FleetCampaign(
            f"batch {k}",
            "scales",
            0.0,
            told(np.array([[1 / sigma] * len(row), [0.0] * len(row)]), np.array(row) / sigma, [seen, unseen]),
        )
        for k, row in enumerate(_DYES)
    ])

    assert uncertainties(estimate(Equations(fleet)))[1] == 1.0


def test_readings_stated_far_better_than_numbers_are_kept_have_variances():
    """Of information of 1e25 squared widths rounding leaves some below nothing."""
    rng = np.random.default_rng(2)
    specs = [ParameterSpec(f"theta_{joint}", "rad", 0.0, 1.0) for joint in range(1, 7)]
    ways = rng.standard_normal((6, 3)) @ rng.standard_normal((3, 20))
    fleet = fleet_of([
        FleetCampaign(f"robot {k}", "tracker", 0.0, told(1e12 * ways, 1e12 * rng.standard_normal(20), specs))
        for k in (0, 1, 2)
    ])

    found = uncertainties(estimate(Equations(fleet)))

    assert ((found > 0.0) & (found <= 1.0)).all()
