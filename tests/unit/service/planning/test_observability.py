"""The indices against their definitions on matrices with known singular values."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose.domain.errors import ConfigurationError, UnderdeterminedError
from truepose.planning.observability import (
    observability_o1,
    observability_o2,
    observability_o3,
    observability_o4,
    observability_o5,
)

INDICES = (
    lambda jacobian: observability_o1(jacobian, 5),
    observability_o2,
    observability_o3,
    observability_o4,
    observability_o5,
)


def with_singular_values(values, rows=15, seed=0):
    rng = np.random.default_rng(seed)
    left = np.linalg.qr(rng.standard_normal((rows, len(values))))[0]
    right = np.linalg.qr(rng.standard_normal((len(values), len(values))))[0]
    return left @ np.diag(values) @ right


def test_each_index_is_what_its_definition_says():
    jacobian = with_singular_values([8.0, 2.0, 0.5])

    assert observability_o1(jacobian, 4) == pytest.approx((8.0 * 2.0 * 0.5) ** (1 / 3) / 2.0)
    assert observability_o2(jacobian) == pytest.approx(0.5 / 8.0)
    assert observability_o3(jacobian) == pytest.approx(0.5)
    assert observability_o4(jacobian) == pytest.approx(0.5**2 / 8.0)
    assert observability_o5(jacobian) == pytest.approx(1.0 / (1 / 8.0 + 1 / 2.0 + 1 / 0.5))


def test_o1_survives_a_product_that_no_double_holds():
    huge = with_singular_values([1e30] * 31, rows=40)  # the product would be 1e930

    assert observability_o1(huge, 1) == pytest.approx(1e30, rel=1e-9)


@pytest.mark.parametrize("index", INDICES)
def test_a_parameter_that_cannot_be_identified_makes_every_index_zero(index):
    jacobian = with_singular_values([3.0, 1.0, 1.0])
    jacobian[:, 2] = 2.0 * jacobian[:, 0] - jacobian[:, 1]

    assert index(jacobian) == 0.0


@pytest.mark.parametrize("index", INDICES)
def test_fewer_observations_than_parameters_are_refused(index):
    with pytest.raises(UnderdeterminedError, match="2 observations cannot determine 3 parameters"):
        index(np.ones((2, 3)))


@pytest.mark.parametrize("jacobian", [np.ones(3), np.full((3, 2), np.nan), np.zeros((3, 0))])
def test_what_is_no_jacobian_is_refused(jacobian):
    with pytest.raises(ConfigurationError):
        observability_o3(jacobian)


@given(st.integers(0, 1000), st.floats(0.1, 10.0))
def test_indices_ignore_the_order_of_rows_and_all_but_o2_grow_with_the_derivatives(seed, factor):
    rng = np.random.default_rng(seed)
    jacobian = rng.standard_normal((12, 4))

    for index in INDICES:
        assert index(rng.permutation(jacobian)) == pytest.approx(index(jacobian))
        scaled = index(jacobian) * (1.0 if index is observability_o2 else factor)
        assert index(factor * jacobian) == pytest.approx(scaled)
