"""What a model lacks is part of its stated uncertainty: errors over it, of many arms."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.lacking import GAP_RAD, MODEL, errors_over_stated, robot
from truepose.identification import identify

WAVE_RAD = 2e-4


def ratios_over_robots(changed=lambda model: model, **lacking):
    """Errors over stated uncertainty of eight arms."""
    found = []
    for seed in range(8):
        read, structure, values = robot(seed, **lacking)
        model = changed(identify(read, MODEL).model)
        found.append(errors_over_stated(read, structure, values, model, seed))
    return np.array(found)


def test_of_noise_alone_parameters_are_nearly_all_of_the_uncertainty():
    ratios = ratios_over_robots()
    of_parameters = ratios_over_robots(lambda model: replace(model, shortfall=None, discrepancy_mm=0.0))

    assert 0.93 < np.mean(np.abs(ratios) <= 1.96) < 0.985
    assert np.std(ratios) == pytest.approx(np.std(of_parameters), rel=0.1)


def test_what_is_stated_beside_structure_is_as_large_as_true_errors_are():
    ratios = ratios_over_robots(
        gap_1=GAP_RAD, gap_3=GAP_RAD, wave_1_2_sin=WAVE_RAD, wave_2_2_cos=WAVE_RAD, wave_5_1_sin=WAVE_RAD
    )

    assert np.sqrt(np.mean(ratios**2)) == pytest.approx(1.0, abs=0.15)
    assert np.mean(np.abs(ratios) <= 1.96) > 0.93
