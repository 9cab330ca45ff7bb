"""What uncertainty means for errors over a volume: closed forms, draws and known cases."""

import numpy as np
import pytest

from truepose.planning.prediction.errors import NONE, Discrepancy, drawn_norms, error_distribution, mean_norms

MAXWELL = 2.0 * np.sqrt(2.0 / np.pi)  # mean norm of three independent normal components of deviation 1


def causes(places=50, count=6, seed=2):
    return np.random.default_rng(seed).standard_normal((places, 3, count)) * np.linspace(0.1, 1.0, count)


def test_equal_errors_along_all_axes_have_the_mean_of_maxwell():
    assert mean_norms(0.02 * np.eye(3)[None], 0.0) == pytest.approx([0.02 * MAXWELL], rel=1e-4)


def test_an_error_along_one_axis_only_has_the_mean_of_half_a_normal():
    along = np.zeros((1, 3, 1))
    along[0, 1, 0] = 0.02

    assert mean_norms(along, 0.0) == pytest.approx([0.02 * np.sqrt(2.0 / np.pi)], rel=5e-3)


def test_the_expected_mean_is_that_of_many_draws():
    drawn = drawn_norms(causes(), Discrepancy(0.3), 4000).mean()

    assert mean_norms(causes(), 0.3).mean() == pytest.approx(drawn, rel=0.02)


def test_nine_of_ten_other_calibrations_have_their_mean_in_the_interval():
    errors = causes()
    rng = np.random.default_rng(99)
    drawn = errors @ rng.standard_normal((6, 3000))
    means = np.linalg.norm(drawn, axis=1).mean(axis=0)

    low, high = error_distribution(errors, NONE).interval_90_mm

    assert np.mean((means >= low) & (means <= high)) == pytest.approx(0.90, abs=0.03)


def test_what_is_drawn_at_every_place_anew_hardly_widens_the_interval_of_the_mean():
    none = np.zeros((400, 3, 1))

    found = error_distribution(none, Discrepancy(0.1))

    assert found.mean_mm == pytest.approx(0.1 * MAXWELL, rel=1e-3)
    low, high = found.interval_90_mm
    assert high - low < 0.1 * found.mean_mm


def test_a_discrepancy_that_is_hardly_known_widens_the_interval_and_keeps_the_mean():
    none = np.zeros((400, 3, 1))

    found = error_distribution(none, Discrepancy(0.1, 0.2), 4000)

    assert found.mean_mm == pytest.approx(0.1 * MAXWELL, rel=1e-3)
    assert drawn_norms(none, Discrepancy(0.1, 0.2), 4000).mean() == pytest.approx(found.mean_mm, rel=0.02)
    low, high = found.interval_90_mm
    assert np.log(high / low) == pytest.approx(2 * 1.645 * 0.2, rel=0.05)


def test_where_nothing_is_uncertain_no_error_is_promised():
    found = error_distribution(np.zeros((4, 3, 2)), NONE)

    assert (found.mean_mm, found.worst_mm, found.interval_90_mm) == (0.0, 0.0, (0.0, 0.0))


def test_the_worst_is_worse_than_the_mean():
    found = error_distribution(causes(), NONE)

    assert found.worst_mm > 1.5 * found.mean_mm
