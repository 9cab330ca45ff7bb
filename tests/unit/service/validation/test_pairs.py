"""Distances between all pairs of points: the fast way against the plain one."""

from dataclasses import replace

import numpy as np
import pytest

from truepose.validation import distance_errors
from truepose.validation.distance_errors import pair_errors


def plain(seen, predicted):
    """Errors of all pairs one by one, with more digits than the fast way has."""
    first, second = np.triu_indices(len(seen), 1)
    here, there = (points.astype(np.longdouble) for points in (seen, predicted))
    lengths = [np.sqrt(np.sum((points[first] - points[second]) ** 2, axis=1)) for points in (here, there)]
    return (lengths[0] - lengths[1]).astype(float)


def cloud(n, spread_mm=700.0, error_mm=0.3, middle_mm=(0.0, 0.0, 0.0), seed=1):
    rng = np.random.default_rng(seed)
    seen = np.array(middle_mm) + rng.uniform(-spread_mm, spread_mm, (n, 3))
    return seen, seen + error_mm * rng.standard_normal((n, 3))


def assert_same(found, errors, atol):
    assert found.n == len(errors)
    assert found.mean_mm == pytest.approx(errors.mean(), abs=atol)
    assert found.mean_absolute_mm == pytest.approx(np.abs(errors).mean(), abs=atol)
    assert found.rms_mm == pytest.approx(np.sqrt(np.mean(errors**2)), abs=atol)
    assert found.largest_mm == pytest.approx(np.abs(errors).max(), abs=atol)


# 2e-7 of an error is what is promised for points a millimetre or more apart: 0.4 nm of 2 mm.
@pytest.mark.parametrize("n", [2, 3, 31, 32, 33, 64, 65, 300], ids="{} points".format)
def test_all_pairs_are_counted_once(n):
    seen, predicted = cloud(n)

    found = pair_errors(seen, (predicted,))[0]

    assert_same(found, plain(seen, predicted), atol=4e-7)


@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (7, 5), (64, 16)])
def test_how_pairs_are_cut_into_blocks_changes_nothing(monkeypatch, rows, columns):
    seen, predicted = cloud(90)
    whole = pair_errors(seen, (predicted,))[0]
    monkeypatch.setattr(distance_errors, "_ROWS", rows)
    monkeypatch.setattr(distance_errors, "_COLUMNS", columns)

    cut = pair_errors(seen, (predicted,))[0]

    assert cut.histogram == whole.histogram
    assert_same(cut, plain(seen, predicted), atol=4e-7)


@pytest.mark.parametrize("middle_mm", [(0.0, 0.0, 0.0), (3000.0, -2000.0, 1500.0)])
@pytest.mark.parametrize("error_mm", [5.0, 0.001])
def test_errors_of_micrometres_survive_lengths_of_metres(middle_mm, error_mm):
    seen, predicted = cloud(400, middle_mm=middle_mm, error_mm=error_mm)

    found = pair_errors(seen, (predicted,))[0]

    errors = plain(seen, predicted)
    assert_same(found, errors, atol=2e-7 * np.abs(errors).max())


def test_places_that_were_commanded_twice_keep_their_micrometres():
    rng = np.random.default_rng(5)
    predicted = np.repeat(rng.uniform(-700.0, 700.0, (20, 3)), 30, axis=0)
    seen = predicted + 0.005 * rng.standard_normal(predicted.shape)

    found = pair_errors(seen, (predicted,))[0]

    assert_same(found, plain(seen, predicted), atol=1e-4)  # what is promised where places coincide


@pytest.mark.parametrize("error_mm", [1e-7, 1e-6, 4e-6])
def test_places_that_nearly_coincide_have_no_error_out_of_reach(error_mm):
    """Five metres off their middle, squares of lengths are rounded at 1e-8 mm2: lengths at 1e-4 mm."""
    rng = np.random.default_rng(29)
    seen = np.repeat(rng.uniform(-5000.0, 5000.0, (100, 3)), 2, axis=0)
    seen += 3e-5 * rng.standard_normal(seen.shape)
    predicted = seen + error_mm * rng.standard_normal(seen.shape)

    found = pair_errors(seen, (predicted,))[0]

    assert sum(found.histogram.counts) == found.n == 200 * 199 // 2
    assert found.largest_mm < 1e-4  # what is promised where places coincide


def test_an_error_of_nothing_is_nothing():
    seen, _ = cloud(200)

    found = pair_errors(np.vstack([seen, seen[:3]]), (np.vstack([seen, seen[:3]]),))[0]

    assert (found.mean_mm, found.rms_mm, found.sd_absolute_mm, found.largest_mm) == (0.0, 0.0, 0.0, 0.0)
    assert found.positive_share == 0.0
    assert found.histogram.counts == (found.n,)
    assert found.histogram.from_mm == 0.0


def test_a_shift_of_the_frame_is_no_error():
    seen, _ = cloud(100)

    found = pair_errors(seen, (seen + np.array([10.0, -5.0, 3.0]),))[0]

    assert found.largest_mm < 1e-9


@pytest.mark.parametrize("shift_mm", [100.0, 1e4, 1e6])
def test_places_that_were_read_twice_bear_a_frame_far_off(shift_mm):
    seen = np.repeat(cloud(40)[0], 2, axis=0)

    found = pair_errors(seen, (seen + shift_mm * np.array([1.0, 0.3, -0.1]),))[0]

    assert (found.n, sum(found.histogram.counts)) == (3160, 3160)
    assert found.largest_mm < 1e-6


@pytest.mark.parametrize(("scale", "share"), [(1.001, 0.0), (0.999, 1.0)])
def test_a_scale_shows_in_the_signs(scale, share):
    seen, _ = cloud(100)

    found = pair_errors(seen, (scale * seen,))[0]

    assert found.positive_share == share
    assert found.mean_mm == pytest.approx((1.0 - scale) * plain(seen, 0.0 * seen).mean())


@pytest.mark.parametrize("error_mm", [3.0, 0.02, 1e-5])
def test_the_histogram_holds_every_pair_in_its_bin(error_mm):
    seen, predicted = cloud(150, error_mm=error_mm)
    errors = plain(seen, predicted)

    bins = pair_errors(seen, (predicted,))[0].histogram

    edges = bins.from_mm + bins.width_mm * np.arange(len(bins.counts) + 1)
    assert bins.counts == tuple(np.histogram(errors, edges)[0])
    assert sum(bins.counts) == len(errors)
    assert bins.counts[0] > 0
    assert bins.counts[-1] > 0
    assert 10 <= len(bins.counts) <= 60
    assert bins.first < 0 < bins.first + len(bins.counts)  # 0 is an edge: signs do not mix


def test_several_predictions_are_judged_as_if_alone():
    seen, first = cloud(80)
    second = cloud(80, error_mm=2.0)[1]

    both = pair_errors(seen, (first, second))

    assert both == (*pair_errors(seen, (first,)), *pair_errors(seen, (second,)))


def test_one_pair_has_no_scatter():
    seen, predicted = cloud(2)

    found = pair_errors(seen, (predicted,))[0]

    assert found.n == 1
    assert found.sd_absolute_mm == pytest.approx(0.0, abs=1e-9)
    assert replace(found, n=2).rms_mm == pytest.approx(found.largest_mm)
