"""Circle tests of noise alone: uncertainties that hold, and waves as rarely as other figures."""

import numpy as np
import pytest

from tests.helpers.domain.circles import read_on, there_and_back, turned
from tests.helpers.domain.robots import IRB_120
from truepose.validation.circle_test import circle_test

_U_MM = 0.01


def one(joint, angles_deg, **read):
    """The only circle of a test of one joint of an IRB 120."""
    (found,) = circle_test(read_on(IRB_120, turned(joint, angles_deg), **read)).circles
    return found


def test_noise_alone_is_said_to_be_noise_and_its_uncertainties_hold():
    """Short arcs, where the uncertain axis bends the errors more than the readings' scatter does."""
    tests = [one(2, there_and_back(-40, 40, 4), scatter_mm=_U_MM, seed=seed) for seed in range(200)]

    assert sum(test.is_noise for test in tests) >= 190  # 198 on average; 190 is 5 standard deviations off
    ratios = np.array([test.errors.angular_rad[0] / test.errors.angular_uncertainty_rad[0] for test in tests])
    assert ratios.std() == pytest.approx(1.0, abs=0.2)  # 4 standard deviations of 200 draws
    gains = np.array([test.curve.gain.value / test.curve.gain.standard_uncertainty for test in tests])
    assert gains.std() == pytest.approx(1.0, abs=0.2)
    gaps = np.array([test.backlash_rad.value / test.backlash_rad.standard_uncertainty for test in tests])
    assert gaps.std() == pytest.approx(1.0, abs=0.2)


def test_noise_makes_waves_as_rarely_as_other_figures():
    tests = [one(5, there_and_back(-150, 150, 10), scatter_mm=_U_MM, seed=seed) for seed in range(150)]
    waves = [wave for test in tests for wave in test.curve.waves]

    assert sum(wave.is_seen for wave in waves) <= 4  # 0.8 of 300 on average
    assert sum(test.is_noise for test in tests) >= 140  # 147 on average
