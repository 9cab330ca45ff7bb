import math

import pytest

from truepose.reports.rounding import (
    MISSING,
    exact,
    format_rounded,
    interval,
    millimetres,
    p_value,
    uncertainty,
    with_uncertainty,
)


@pytest.mark.parametrize(
    ("value", "u", "text"),
    [
        (301.91862, 0.00471, "301.9186"),
        (-90.0704, 0.0032, "-90.0704"),
        (12.345, 0.0996, "12.35"),  # 0.0996 is 0.10 to two digits
        (1234.5, 27.0, "1234"),
        (3.5934e-8, 9.8e-10, "3.593e-08"),
        (-0.00001, 0.0012, "0.0000"),  # no negative zero
        (2.5, 0.0, "2.5"),
        (2.5, math.nan, "2.5"),
    ],
)
def test_a_value_ends_at_the_second_digit_of_its_uncertainty(value, u, text):
    assert format_rounded(value, u) == text


@pytest.mark.parametrize(("value", "text"), [(0.0996, "0.10"), (0.00471, "0.0047"), (9.8e-10, "9.8e-10")])
def test_an_uncertainty_has_two_digits(value, text):
    assert uncertainty(value) == text


def test_what_is_not_a_number_is_shown_as_missing():
    assert format_rounded(math.nan, 0.1) == millimetres(math.inf) == MISSING


@pytest.mark.parametrize(
    ("value", "text"), [(-90.00000000000001, "-90"), (-1e-17, "0"), (270.0, "270"), (69.8125, "69.8125")]
)
def test_a_nominal_value_keeps_the_digits_it_was_given_with(value, text):
    assert exact(value) == text


def test_lengths_below_a_tenth_of_a_millimetre_show_tenths_of_a_micrometre():
    assert [millimetres(value) for value in (0.02785, 0.79512, 12.3456)] == ["0.0278", "0.795", "12.35"]


def test_a_tiny_p_value_is_only_said_to_be_small():
    assert (p_value(3e-9), p_value(0.0421)) == ("< 0.0001", "0.042")


@pytest.mark.parametrize(
    ("value", "u", "printed"),
    [
        (0.0293, 0.0019, "0.0293 ± 0.0019"),
        (-0.5, 0.25, "\N{MINUS SIGN}0.50 ± 0.25"),
        (2.07e-4, 1.9e-5, "(2.07 ± 0.19) \N{MULTIPLICATION SIGN} 10⁻⁴"),
        (5e-9, 4e-10, "(5.00 ± 0.40) \N{MULTIPLICATION SIGN} 10⁻⁹"),
        (1e-6, 3e-5, "(0.1 ± 3.0) \N{MULTIPLICATION SIGN} 10⁻⁵"),
        (3.0, 0.0, "3"),
        (3.0, float("nan"), "3"),
    ],
)
def test_a_value_and_its_uncertainty_end_at_the_same_digit(value, u, printed):
    assert with_uncertainty(value, u) == printed


def test_the_ends_of_an_interval_have_the_digits_of_the_uncertainty():
    assert interval(0.02558, 0.03302, 0.0019) == "0.0256 to 0.0330"
    assert interval(-4e-6, 2e-4, 5e-5) == "(\N{MINUS SIGN}0.04 to 2.00) \N{MULTIPLICATION SIGN} 10⁻⁴"


def test_a_difference_of_nothing_has_no_sign():
    assert millimetres(-1e-6) == "0.0000"
