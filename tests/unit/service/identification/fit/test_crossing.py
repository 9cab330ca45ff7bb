"""A crossing is found between two ends, in few looks, however the function bends."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose.identification.fit.root_finding import crossing


@given(st.floats(1e-3, 0.999), st.sampled_from([1, 3, 9]))
def test_a_crossing_is_found_within_a_millionth(root, power):
    found = crossing(lambda x: root**power - x**power, 0.0, 1.0)

    assert found == pytest.approx(root, rel=1e-6)


def test_a_steep_end_costs_few_looks():
    looks = []

    def falling(x):
        looks.append(x)
        return 1.0 / (1e-6 + x) ** 2 - 4.0

    assert crossing(falling, 0.0, 10.0) == pytest.approx(0.5 - 1e-6, rel=1e-6)
    assert len(looks) < 30


@pytest.mark.parametrize("root", [0.0, 2.0])
def test_an_end_may_be_the_crossing(root):
    assert crossing(lambda x: root - x, 0.0, 2.0) == pytest.approx(root, abs=1e-11)


def test_rising_functions_cross_as_well():
    assert crossing(lambda x: math.atan(x - 1.0), 0.0, 100.0) == pytest.approx(1.0, rel=1e-6)
