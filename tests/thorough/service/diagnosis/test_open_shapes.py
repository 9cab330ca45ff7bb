"""Where no angle was read, errors stay within the uncertainty that a model with waves states there."""

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import START, telling_campaign
from tests.helpers.diagnosis.selections import planted
from tests.helpers.identification.synthetic import NOISE_MM, configurations
from truepose.diagnosis.diagnose import diagnose
from truepose.identification.model.prediction import predict

GAP_DEG = (-40.0, 30.0)  # of joint 1
# Two waves of which one stands for another in a gap, and a third that no whole order has.
WAVES = {
    "joint_harmonics": {
        f"wave_1_{order}_{part}": np.deg2rad(size)
        for order, size in (("2", 0.08), ("5", 0.05), ("7.6", 0.04))
        for part in ("sin", "cos")
    }
}


def at(joints_rad):
    return telling_campaign(len(joints_rad), joints_rad=joints_rad)


def in_gap(joints_rad):
    low, high = np.deg2rad(GAP_DEG)
    return (joints_rad[:, 0] > low) & (joints_rad[:, 0] < high)


@pytest.fixture(scope="module")
def with_gap():
    """A diagnosis without readings in a gap of joint 1; readings of that robot there and elsewhere."""
    joints = configurations(160, seed=3)
    measured = planted(WAVES, at(joints[~in_gap(joints)]))
    others = configurations(300, seed=9)
    unseen = planted(WAVES, at(others), seed=11).calibration
    return diagnose(measured, START), unseen


def normalised(found, points):
    """Errors over what is predicted for them, noise of the reading included."""
    predicted_mm, u_mm = predict(found.model, points.stops, points.nest)
    off_mm = np.linalg.norm(points.position_mm - predicted_mm, axis=1)
    return off_mm, u_mm, off_mm / np.sqrt(3.0 * (u_mm**2 + NOISE_MM**2))


def test_in_a_gap_of_the_readings_the_uncertainty_covers_the_errors(with_gap):
    found, unseen = with_gap
    assert {finding.effect for finding in found.findings} >= {"joint_harmonics"}

    off_mm, u_mm, over = normalised(found, unseen)

    there = in_gap(unseen.stops.joints_rad)
    assert off_mm[there].max() > 3.0 * off_mm[~there].max()  # else there was nothing to say
    assert np.sqrt((over[there] ** 2).mean()) < 1.6
    assert over[there].max() < 4.0
    assert np.median(u_mm[there]) > 4.0 * np.median(u_mm[~there])
