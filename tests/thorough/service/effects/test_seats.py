"""The stated interval of how much seats differ, against seats that are drawn."""

import numpy as np
import pytest

from tests.helpers.diagnosis.seats import GROUPS, WIDTHS, posterior
from truepose.effects.setup.tool_reseating import deviations


@pytest.mark.parametrize(("mountings", "noise"), [(4, 0.02), (4, 0.15), (8, 0.15)])
def test_the_deviation_of_seats_lies_within_its_stated_interval_as_often_as_it_says(mountings, noise):
    rng = np.random.default_rng(8)
    truth = np.array([0.03, 3e-4])  # a fifth of the priors' widths, for shifts and turns
    within = []
    for _ in range(40):
        draws = np.repeat(truth, 3) * rng.standard_normal((mountings, 6)) + WIDTHS * rng.standard_normal(6)
        mean, covariance = posterior(draws, noise, rng)

        found, uncertainty = deviations(mean, covariance, WIDTHS, GROUPS)

        within += (np.abs(found - truth) < 1.96 * uncertainty).tolist()
    # 95 % stated; 80 deviations of that scatter by 2.4 %
    assert np.mean(within) > 0.87
