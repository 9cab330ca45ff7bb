"""Single readings: heavy tails are noise, wild readings are bad, swapped labels are put right."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.selections import make_start
from truepose.diagnosis.reading_faults import swapped_labels, tails

N = 300


def squared_radius(vectors):
    return (vectors**2).sum(axis=1)


def normal(n=N, seed=0):
    return np.random.default_rng(seed).standard_normal((n, 3))


def student(degrees, n=N, seed=0):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((n, 3)) / np.sqrt(rng.chisquare(degrees, n) / degrees)[:, None]


def nobody(n=N):
    return np.zeros(n, dtype=bool)


@pytest.mark.parametrize("seed", range(10))
def test_normal_noise_is_neither_heavy_nor_bad(seed):
    found = tails(squared_radius(normal(seed=seed)), 3, nobody())

    assert found.degrees_of_freedom is None
    assert not found.bad.any()


def test_few_normal_readings_seldom_look_heavy_tailed():
    found = [tails(squared_radius(normal(60, seed)), 3, nobody(60)) for seed in range(100, 140)]

    # five in log likelihood for one parameter: a chi-square of 10, once in a thousand
    assert sum(one.degrees_of_freedom is not None for one in found) <= 1


@pytest.mark.parametrize("components", [1, 2, 3])
def test_a_reading_that_lies_on_the_model_is_normal(components):
    squared = squared_radius(normal(10)[:, :components])
    squared[0] = 0.0

    found = tails(squared, components, nobody(10))

    assert found.degrees_of_freedom is None
    assert not found.bad.any()


@pytest.mark.parametrize("seed", range(5))
def test_students_noise_is_heavy_tailed_and_no_reading_of_it_is_bad(seed):
    squared = squared_radius(student(4.0, seed=seed))

    found = tails(squared, 3, squared > np.sort(squared)[-4])  # the fit gave three no weight

    assert not found.bad.any()
    # the standard deviation of the degrees is about 0.9 with 300 readings; three of these
    assert found.degrees_of_freedom == pytest.approx(4.0, abs=2.7)


def test_the_size_of_the_noise_does_not_decide_about_its_tails():
    squared = squared_radius(student(4.0))

    small = tails(0.01 * squared, 3, nobody()).degrees_of_freedom
    large = tails(100.0 * squared, 3, nobody()).degrees_of_freedom

    assert small == pytest.approx(large, rel=0.02)  # where the search for the best stops


@pytest.mark.parametrize("seed", range(5))
def test_a_few_wild_readings_in_normal_noise_are_bad(seed):
    vectors = normal(seed=seed)
    vectors[:9] *= 20.0
    wild = np.arange(N) < 9

    found = tails(squared_radius(vectors), 3, wild)

    assert np.array_equal(found.bad, wild)
    assert found.degrees_of_freedom is None


@pytest.fixture(scope="module")
def start():
    return make_start({})


def with_labels(start, rows, nest):
    points = start.campaign.calibration
    labels = points.nest.copy()
    labels[rows] = nest
    return replace(points, nest=labels)


def test_a_reading_of_another_nest_gets_its_label_back(start):
    right = start.campaign.calibration.nest
    rows = np.flatnonzero(right == 1)[:2]
    suspect = np.isin(np.arange(len(right)), rows)

    assert np.array_equal(swapped_labels(with_labels(start, rows, 2), suspect, start.fit), right)


def test_labels_that_nobody_suspects_stay(start):
    wrong = with_labels(start, [0, 3], 2)

    assert np.array_equal(swapped_labels(wrong, nobody(len(wrong)), start.fit), wrong.nest)


def test_a_bad_reading_that_fits_no_nest_keeps_its_label(start):
    points = start.campaign.calibration
    position = points.position_mm.copy()
    position[4] += [0.0, 0.0, -60.0]  # away from all three nests
    suspect = np.arange(len(points)) == 4

    found = swapped_labels(replace(points, position_mm=position), suspect, start.fit)

    assert np.array_equal(found, points.nest)
