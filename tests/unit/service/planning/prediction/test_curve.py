"""The curve: which numbers it is given for, and where its knee is."""

import numpy as np
import pytest

from truepose.planning.prediction.errors import NONE, CurvePoint, Errors, curve, gains_mm, knee, sizes


def made_up(mean_mm_of, numbers):
    return tuple(CurvePoint(n, mean_mm_of(n), 0.0, (0.0, 0.0), 0.0) for n in numbers)


TENS = (11, 20, 30, 40, 50, 60, 70, 80, 90, 100)


def test_errors_that_fall_with_the_root_of_the_number_have_their_knee_where_ten_more_gain_a_tenth():
    points = made_up(lambda n: 1.0 / np.sqrt(n), TENS)

    assert knee(points) == 50  # 1 - sqrt(40 / 50) is 10.6 %, 1 - sqrt(50 / 60) is 8.7 %


def test_errors_that_do_not_fall_need_no_more_than_the_usual_fewest():
    assert knee(made_up(lambda n: 0.1, TENS)) == 20


def test_errors_that_halve_with_every_step_have_no_knee_but_the_end():
    assert knee(made_up(lambda n: 0.5**n, TENS)) == 100


def test_a_step_of_another_length_is_counted_as_if_it_were_of_ten():
    points = made_up({20: 1.0, 25: 0.96, 35: 0.955}.__getitem__, (20, 25, 35))

    assert knee(points) == 20  # 0.04 in five are 0.08 in ten


def test_a_number_that_was_asked_for_is_on_the_curve():
    assert 37 in sizes(37, 5000)


def test_a_curve_ends_where_there_are_no_more_configurations():
    assert sizes(None, 34) == (11, 20, 30, 34)
    assert sizes(None, 5) == (5,)


def test_a_curve_goes_on_from_what_was_measured():
    assert sizes(None, 5000, 50)[:3] == (50, 60, 70)
    assert sizes(None, 50, 50) == (50,)


def test_the_knee_of_a_campaign_that_is_enough_is_what_was_measured():
    points = made_up({50: 0.100, 60: 0.099, 70: 0.098}.__getitem__, (50, 60, 70))

    assert knee(points) == 50
    assert gains_mm(points) == pytest.approx((0.001, 0.001))


def test_the_scatter_of_the_arm_is_in_a_visit_only():
    errors = Errors(lambda n: 0.01 / n * np.eye(3)[None], NONE, 0.005)

    few, many = curve(errors, (1, 100))

    assert many.mean_mm == pytest.approx(few.mean_mm / 100.0)
    assert many.visit_mean_mm == pytest.approx(0.005 * 2.0 * np.sqrt(2.0 / np.pi), rel=1e-3)
