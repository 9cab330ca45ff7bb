"""What is left: families are alike in every block, silent on noise, and see what is theirs."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.selections import make_start
from truepose.diagnosis.evidence.residual_structure import (
    as_random_effect,
    prepared_families,
    score_families,
)
from truepose.diagnosis.screening.normal_equations import normal_of
from truepose.diagnosis.screening.smooth_functions import families, terms_of

DRAWS = 40
LEVEL = 0.05


@pytest.fixture(scope="module")
def start():
    return make_start({})


@pytest.fixture(scope="module")
def prepared(start):
    return prepared_families(start.fit, start.scene)


def of(prepared, variable):
    return next(products for family, products in prepared if family.variable == variable)


def seen_with(start, prepared, rng, variable=None, width=0.0):
    """Families and projection as they were if noise of unit variance, and perhaps a family, were all."""
    final, structure = start.fit.solution.final, start.fit.structure
    residual = rng.standard_normal(final.residual.size)
    if variable is not None:
        columns = of(prepared, variable).columns
        residual += columns.T @ (width * rng.standard_normal(len(columns)))
    normal = replace(
        normal_of(start.fit),
        deviation=structure.prior_widths * rng.standard_normal(len(structure.names)),
        towards=final.jacobian @ residual,
        residual_square=float(residual @ residual),
    )
    seen = tuple(
        (family, replace(products, with_residual=products.columns @ residual))
        for family, products in prepared
    )
    return seen, normal.past()


def test_a_family_has_as_many_parameters_in_every_block(start):
    for family in families(start.scene):
        counts = {len(family.build(result.state)) for result in start.fit.results}
        assert len(start.fit.results) == 2  # the arm's nest and the fixed nests
        assert len(counts) == 1, family.variable


def test_terms_are_numbered_parameter_by_parameter(start):
    state = start.fit.results[0].state
    for family in families(start.scene):
        numbers = {term.parameter for term in terms_of(family, state)}
        assert numbers == set(range(len(family.build(state)))), family.variable


def test_every_variable_that_varies_has_its_family(start):
    variables = {family.variable for family in families(start.scene)}

    expected = {f"angle of joint {joint}" for joint in range(1, 7)}
    expected |= {"temperature", "attachment of the tool", "nest", "place in the work space"}
    expected |= {"time (place of the base)", "time (frame of the instrument)", "direction of joint 3"}
    assert expected <= variables
    assert "torque of joint 1" not in variables  # it stands upright


def test_a_variable_that_never_changes_has_none(start):
    stops = start.scene.stops
    plain = replace(stops, direction=None, temperature_c=None, time_s=None, attachment=None)

    kinds = {family.kind for family in families(replace(start.scene, stops=plain))}

    assert kinds.isdisjoint({"direction", "temperature", "time", "attachment"})


def test_noise_alone_is_structure_no_more_often_than_the_level_says(start, prepared):
    rng = np.random.default_rng(8)

    smallest = [score_families(*seen_with(start, prepared, rng))[0].p_value for _ in range(DRAWS)]

    # Bonferroni keeps 5 % or less: 2 of 40 expected at most, 7 and more once in three hundred
    assert sum(p < LEVEL for p in smallest) <= 6


@pytest.mark.parametrize(
    "variable", ["angle of joint 4", "time (place of the base)", "direction of joint 3", "nest"]
)
def test_what_depends_on_a_variable_is_said_to(start, prepared, variable):
    columns = of(prepared, variable).columns
    width = 4.0 / np.sqrt(np.mean(columns**2) * len(columns))  # four times the noise, in all

    found = score_families(*seen_with(start, prepared, np.random.default_rng(2), variable, width))

    assert found[0].family.variable == variable
    assert found[0].p_value < 1e-6


@pytest.mark.parametrize("relative", [1.0, 10.0])
def test_a_random_effect_is_found_in_its_own_size(start, prepared, relative):
    columns = of(prepared, "angle of joint 4").columns
    width = relative / np.sqrt(np.mean(columns**2) * len(columns))
    rng = np.random.default_rng(5)

    widths = []
    for _ in range(10):
        seen, past = seen_with(start, prepared, rng, "angle of joint 4", width)
        widths.append(as_random_effect(of(seen, "angle of joint 4"), past).width)

    # twelve waves a time: each width is off by 1 / sqrt(24), the median of ten by a tenth; the grid by 0.1
    assert np.median(widths) == pytest.approx(width, rel=0.4)


def test_a_random_effect_of_noise_is_not_worth_its_parameter(start, prepared):
    rng = np.random.default_rng(6)

    scores = []
    for _ in range(DRAWS):
        seen, past = seen_with(start, prepared, rng)
        scores.append(as_random_effect(of(seen, "angle of joint 4"), past).score)

    # ln(294) = 5.7 exceeds half of a chi-square of one degree once in a hundred times
    assert sum(score > 0.0 for score in scores) <= 2


def test_a_family_that_nobody_can_see_has_no_size(start, prepared):
    seen, past = seen_with(start, prepared, np.random.default_rng(0))
    products = of(seen, "angle of joint 4")
    blind = replace(
        products,
        columns=0.0 * products.columns,
        with_jacobian=0.0 * products.with_jacobian,
        with_residual=0.0 * products.with_residual,
    )

    effect = as_random_effect(blind, past)

    assert (effect.width, effect.score) == (0.0, -np.inf)
