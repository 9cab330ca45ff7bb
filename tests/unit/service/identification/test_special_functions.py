"""Special functions against sums that end, and against a library."""

from decimal import Decimal, localcontext
from math import comb

import numpy as np
import pytest
from scipy.special import elliprg

from truepose.identification.distributions import beta_below, carlson_rg, gamma_above


@pytest.mark.parametrize(("shape", "start"), [(1, 0.3), (7, 6.5), (100, 150.0), (2408, 3627.6)])
def test_the_gamma_function_of_whole_shapes_is_a_sum_that_ends(shape, start):
    with localcontext() as context:
        context.prec = 60
        terms = [Decimal(1)]
        for k in range(1, shape):
            terms.append(terms[-1] * Decimal(start) / k)
        exact = float(sum(terms) * (-Decimal(start)).exp())  # DLMF 8.4.10

    assert gamma_above(float(shape), start) == pytest.approx(exact, rel=2e-13)


@pytest.mark.parametrize(("a", "b"), [(1, 1), (3, 40), (40, 3), (700, 300)])
@pytest.mark.parametrize("end", [1.0 / 1024, 0.25, 0.6875, 1023.0 / 1024])
def test_the_beta_function_of_whole_arguments_is_a_sum_that_ends(a, b, end):
    n = a + b - 1
    with localcontext() as context:
        context.prec = 400
        x = Decimal(end)
        exact = float(sum(comb(n, j) * x**j * (1 - x) ** (n - j) for j in range(a, n + 1)))  # DLMF 8.17.5

    assert beta_below(float(a), float(b), end, 1.0 - end) == pytest.approx(exact, rel=1e-12, abs=1e-300)


def test_rg_is_that_of_the_library():
    rng = np.random.default_rng(7)
    wide = 10.0 ** rng.uniform(-8.0, 8.0, (2000, 3))
    alike = 1.0 + 0.01 * rng.standard_normal((2000, 3))
    alone = wide[:200] * [0.0, 1.0, 1.0]
    arguments = np.concatenate([wide, alike, alone, alone[:, [1, 0, 2]], np.ones((3, 3))])

    np.testing.assert_allclose(carlson_rg(arguments), elliprg(*arguments.T), rtol=1e-14)


@pytest.mark.parametrize("arguments", [(0.0, 0.0, 4.0), (4.0, 0.0, 0.0)])
def test_rg_of_one_argument_is_half_its_root(arguments):
    assert carlson_rg(np.array([arguments])) == pytest.approx(1.0)


def test_rg_of_nothing_is_nothing():
    assert carlson_rg(np.zeros((1, 3))) == [0.0]
    assert carlson_rg(np.zeros((0, 3))).shape == (0,)
