"""Chances of single variates against those of a library of distributions, far into the tails."""

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from truepose.identification.distributions import chi2_exceeded, chi2_limit, chi2_median, f_exceeded, holm

DEGREES = st.floats(0.5, 3000.0)
SQUARES = st.floats(0.0, 1e4)
LIBRARY = 1e-11  # the library's own digits end there, far in the tails
# Of ratios it is wrong farther out: by 2e-10 of itself at 7e-271, wholly at 2e-298, as fractions say.
LIBRARY_ENDS = 1e-200


@given(SQUARES, DEGREES)
def test_chi_square_is_that_of_the_library(squared, degrees):
    of_library = stats.chi2.sf(squared, degrees)

    assert chi2_exceeded(squared, degrees) == pytest.approx(of_library, rel=LIBRARY, abs=1e-300)


@given(st.floats(1e-12, 0.999), DEGREES)
def test_a_limit_is_exceeded_with_its_chance(chance, degrees):
    limit = chi2_limit(chance, degrees)

    assert limit == pytest.approx(stats.chi2.isf(chance, degrees), rel=LIBRARY)
    assert chi2_exceeded(limit, degrees) == pytest.approx(chance, rel=1e-9)


@given(DEGREES)
def test_half_of_all_lie_beyond_the_median(degrees):
    assert chi2_exceeded(chi2_median(degrees), degrees) == pytest.approx(0.5)


@given(st.floats(0.0, 1e4), DEGREES, DEGREES)
def test_a_ratio_of_mean_squares_is_that_of_the_library(ratio, above, below):
    of_library = stats.f.sf(ratio, above, below)

    found = f_exceeded(ratio, above, below)
    assert found == pytest.approx(of_library, rel=LIBRARY) or max(found, of_library) < LIBRARY_ENDS


@pytest.mark.parametrize(
    ("ratio", "above", "below"), [(48, 48, 1592), (57, 50, 1406), (3, 2, 8), (1, 40, 60), (9, 600, 20)]
)
def test_a_ratio_of_mean_squares_is_that_of_fractions(ratio, above, below):
    # Of even degrees of freedom it is a binomial sum: Abramowitz and Stegun, 26.5.24 and 26.6.
    a, b = below // 2, above // 2
    x = Fraction(below, below + above * ratio)
    n = a + b - 1
    exact = sum(math.comb(n, j) * x**j * (1 - x) ** (n - j) for j in range(a, n + 1))

    # 1e-12: a logarithm of up to 690 has lost three of its sixteen digits.
    assert f_exceeded(ratio, above, below) == pytest.approx(float(exact), rel=1e-12, abs=0.0)


def test_nothing_exceeds_what_has_no_limit():
    assert chi2_exceeded(math.inf, 3.0) == f_exceeded(math.inf, 3.0, 5.0) == 0.0


def test_everything_exceeds_nothing():
    assert chi2_exceeded(0.0, 3.0) == f_exceeded(0.0, 3.0, 5.0) == 1.0


def test_what_is_no_number_has_no_chance():
    assert math.isnan(chi2_exceeded(math.nan, 3.0))


@pytest.mark.parametrize(
    ("alone", "corrected"),
    [
        ([], []),
        ([0.01], [0.01]),
        ([0.01, None, 0.04, 0.03], [0.03, None, 0.06, 0.06]),
        ([0.9, 0.2, 0.5], [1.0, 0.6, 1.0]),
    ],
)
def test_of_several_tests_each_counts_as_the_smallest_of_those_not_yet_refused(alone, corrected):
    assert holm(alone) == pytest.approx(corrected)
