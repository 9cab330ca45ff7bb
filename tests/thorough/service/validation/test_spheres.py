"""Sphere tests that are drawn: how often noise alone is said to be noise, and how far figures scatter."""

import numpy as np
import pytest

from tests.helpers.ballbar.spheres import IRB_120, longer, sphere_campaign, stops_on_sphere
from truepose.validation.sphere_test import sphere_test

LONGER = longer()


@pytest.fixture(scope="module")
def stops():
    """Configurations on the sphere, and their nests."""
    return stops_on_sphere()


def drawn(stops, seed, true=IRB_120):
    """The only sphere of a test with noise."""
    joints, nest = stops
    (sphere,) = sphere_test(sphere_campaign(true, joints_rad=joints, nest=nest, noise=1.0, seed=seed)).spheres
    return sphere


def test_noise_alone_is_said_to_be_noise(stops):
    tests = [drawn(stops, seed) for seed in range(200)]

    for taught in (True, False):
        noise = [test.of("nominal", taught=taught).is_noise for test in tests]
        assert sum(noise) >= 190  # 198 on average; 190 is 5 standard deviations off


@pytest.mark.parametrize("taught", [True, False])
def test_uncertainties_are_those_of_drawn_tests(stops, taught):
    """GUM to first order against the scatter of the figures over 200 drawn tests of an arm that errs."""
    tests = (drawn(stops, seed, LONGER) for seed in range(200))
    figures = [one.of("nominal", taught=taught).by_nest[1][1] for one in tests]

    for name in ("mean_mm", "sd_mm", "range_mm"):
        found = [getattr(one, name) for one in figures]
        stated = np.sqrt(np.mean([one.standard_uncertainty**2 for one in found]))
        # 4 standard deviations of 200 draws; a range scatters by less where several stops vie for its ends.
        least = 0.7 if name == "range_mm" else 0.8
        assert least * stated < np.std([one.value for one in found]) < 1.2 * stated
