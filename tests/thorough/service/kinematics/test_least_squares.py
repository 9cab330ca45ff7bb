"""The stated covariance of a pose device's pose, against lengths and fixtures that are drawn."""

import numpy as np
import pytest

from tests.helpers.ballbar.pose_device import ALL_LEGS, CUPS, MEASURABLE, NESTS, SIGMA_MM, lengths
from truepose.kinematics.frames import vector_from_rotation
from truepose.kinematics.pose_device import Fixtures, least_squares_pose


def off(found, true):
    turn = vector_from_rotation(found.rotation @ true.rotation.T)
    return np.concatenate([found.origin_mm - true.origin_mm, turn])


def test_the_stated_covariance_is_how_the_pose_scatters_and_chi2_how_the_misfit_does():
    rng = np.random.default_rng(11)
    cups_u, nests_u = 0.004, 0.002
    fixtures = Fixtures(CUPS, NESTS, cups_u**2 * np.eye(9), nests_u**2 * np.eye(9))
    true, legs = MEASURABLE[10].pose, ALL_LEGS
    found = []
    for _ in range(200):
        cups, nests = CUPS + cups_u * rng.normal(size=(3, 3)), NESTS + nests_u * rng.normal(size=(3, 3))
        length_mm = lengths(true, legs, cups, nests) + SIGMA_MM * rng.normal(size=9)
        found.append(least_squares_pose(fixtures, legs, length_mm, SIGMA_MM**2 * np.eye(9), commanded=true))

    errors = np.array([off(one.pose, true) for one in found])
    white = np.linalg.solve(np.linalg.cholesky(found[0].covariance), errors.T)

    # 200 draws: a standard deviation to 5 %, a mean of chi-squared with 3 degrees of freedom to 0.17
    assert white.std(axis=1) == pytest.approx(np.ones(6), abs=0.18)
    assert np.mean([one.chi2 for one in found]) == pytest.approx(3.0, abs=0.55)
    assert np.corrcoef(white)[np.triu_indices(6, 1)] == pytest.approx(np.zeros(15), abs=0.25)
