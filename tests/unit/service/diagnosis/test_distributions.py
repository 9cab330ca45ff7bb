"""Chances over arrays against those of a library of distributions, far into the tails."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from truepose.diagnosis.distributions import (
    chi2_log_density,
    f_exceeded,
    hypergeometric_tail,
    normal_exceeded,
)

DEGREES = st.floats(0.5, 3000.0)


@given(st.floats(0.0, 1e4), DEGREES)
def test_a_density_is_that_of_the_library(squared, degrees):
    assert chi2_log_density(squared, degrees) == pytest.approx(stats.chi2.logpdf(squared, degrees), rel=1e-9)


@given(st.floats(0.0, 1e4), DEGREES, DEGREES)
def test_a_ratio_of_mean_squares_is_that_of_the_library(ratio, above, below):
    assert f_exceeded(ratio, above, below) == pytest.approx(stats.f.sf(ratio, above, below), rel=1e-12)


@given(st.floats(-40.0, 40.0))
def test_a_normal_deviate_is_that_of_the_library(deviate):
    assert normal_exceeded(deviate) == pytest.approx(stats.norm.sf(deviate), rel=1e-12)


@given(st.data())
def test_so_many_drawn_are_those_of_the_library(data):
    total = data.draw(st.integers(1, 3000))
    drawn, marked = (data.draw(st.integers(0, total)) for _ in range(2))
    reached = data.draw(st.integers(0, min(drawn, marked)))

    of_library = stats.hypergeom.sf(reached - 1, total, marked, drawn)

    assert hypergeometric_tail(reached, drawn, marked, total) == pytest.approx(
        of_library, rel=1e-8, abs=1e-300
    )


def test_more_than_are_marked_are_never_drawn():
    assert hypergeometric_tail(3, 5, 2, 10) == 0.0


def test_arrays_go_together():
    degrees = np.array([1, 3, 6])

    np.testing.assert_allclose(
        f_exceeded([1.0, 2.0, 3.0], degrees, 9), stats.f.sf([1.0, 2.0, 3.0], degrees, 9)
    )
