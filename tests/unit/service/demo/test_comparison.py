"""The truth beside the model: alignment, and the campaign as it would be without noise."""

import numpy as np
import pytest

from tests.helpers.domain.builders import make_campaign, make_model, make_points
from truepose.demo.truth import TrueReadings
from truepose.demo.truth_comparison import rigidly_aligned, true_campaign, true_errors
from truepose.identification import predict
from truepose.kinematics.frames import rotation_xyz


def points(n=40, seed=1):
    return np.random.default_rng(seed).uniform(-500.0, 500.0, (n, 3))


def test_alignment_undoes_any_rigid_motion():
    here = points()
    there = here @ rotation_xyz(2.0, -1.0, 0.5).T + [10.0, -300.0, 7.0]

    # double precision: coordinates of 1e3 mm, a few roundings of 1e-16 each
    np.testing.assert_allclose(rigidly_aligned(here, there), there, atol=1e-9)


def test_alignment_never_mirrors():
    here = points()
    mirrored = here * [1.0, 1.0, -1.0]

    aligned = rigidly_aligned(here, mirrored)

    distances = np.linalg.norm(np.diff(aligned, axis=0), axis=1)
    np.testing.assert_allclose(distances, np.linalg.norm(np.diff(here, axis=0), axis=1), atol=1e-9)
    assert np.max(np.abs(aligned - mirrored)) > 100.0


def test_alignment_leaves_what_no_rigid_motion_explains():
    here = points()

    aligned = rigidly_aligned(here, here * 1.001)

    # Least squares: scaling by 1.001 about the centre is as close as a rigid motion comes.
    centred = here - here.mean(axis=0)
    np.testing.assert_allclose(
        np.linalg.norm(here * 1.001 - aligned, axis=1), 0.001 * np.linalg.norm(centred, axis=1), rtol=1e-6
    )


def test_the_true_error_is_truth_minus_prediction_without_the_readings_noise():
    model, readings = make_model(), make_points(n=4)
    predicted, _ = predict(model, readings.stops, readings.nest)

    errors = true_errors(model, readings, predicted + np.array([0.03, 0.0, 0.04]))

    assert errors.absolute.mean_mm == pytest.approx(0.05)
    assert errors.aligned.max_mm < 1e-9  # a shift is a rigid motion
    assert errors.absolute.noise_mm == 0.0


def test_the_true_campaign_has_true_places_and_keeps_configurations_and_stated_uncertainties():
    campaign = make_campaign(calibration=make_points(n=3), validation=make_points(n=2))
    n_nests = len(campaign.nests)
    true = TrueReadings(np.full((3, 3), 7.0), np.full((2, 3), 8.0), np.full((n_nests, 3), 9.0))

    found = true_campaign(campaign, true)

    assert found.calibration.position_mm.tolist() == [[7.0] * 3] * 3
    assert found.calibration.stops is campaign.calibration.stops
    assert [nest.centre_mm for nest in found.nests] == [(9.0, 9.0, 9.0)] * n_nests
    assert found.nests[0].standard_uncertainty_mm == campaign.nests[0].standard_uncertainty_mm
    assert found.validation is None
