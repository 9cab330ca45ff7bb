"""The stated uncertainty of a tracker's place in the world, against registrations that are drawn."""

import numpy as np

from tests.helpers.domain.registered import CERTIFIED, ROTATION, draw
from tests.unit.service.sessions.tracker.fakes import TRACKER_AT
from truepose.kinematics.frames import vector_from_rotation


def test_the_stated_covariance_is_what_many_registrations_show():
    rng = np.random.default_rng(3)
    motions, stated = [], []
    for _ in range(1500):
        true_nests = CERTIFIED + 0.002 * rng.standard_normal(CERTIFIED.shape)
        registration = draw(rng, true_nests)
        turn = vector_from_rotation(registration.rotation @ ROTATION.T)
        shift = registration.translation_mm - registration.rotation @ ROTATION.T @ TRACKER_AT
        motions.append(np.concatenate([shift, turn]))
        stated.append(registration.covariance)

    observed = np.cov(np.array(motions), rowvar=False)
    ratios = np.linalg.eigvals(np.linalg.solve(np.mean(stated, axis=0), observed)).real
    # the largest of six eigenvalues of 1,500 draws strays by (1 +- sqrt(6 / 1500))^2: 0.88 to 1.13
    assert np.all((ratios > 0.85) & (ratios < 1.16))


def test_the_scale_is_found_with_its_uncertainty():
    errors = []
    for seed in range(200):
        registration = draw(np.random.default_rng(seed), scale=1.0 / (1.0 + 20e-6))
        errors.append((registration.scale - 1.0 - 20e-6) / registration.scale_standard_uncertainty)

    # the certificate's own errors are not drawn here, so a little less than 1; 200 draws: 5 %
    assert 0.7 < np.std(errors) < 1.15
    assert abs(np.mean(errors)) < 4 / np.sqrt(200)
