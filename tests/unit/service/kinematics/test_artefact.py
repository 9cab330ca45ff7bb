"""What the accuracy of nests means for a pose: against poses that are fitted to noisy nests."""

import numpy as np
import pytest

from truepose.domain.errors import UnderdeterminedError
from truepose.kinematics.frames import rigid_alignment, vector_from_rotation
from truepose.kinematics.poses import centre, normal, pose_uncertainty

FLAT = np.array([[0.0, 0.0, 125.0], [75.0, 93.675, 215.0], [150.0, 0.0, 125.0]])
SPATIAL = np.array([[45.0, 0.0, 150.0], [-22.5, 38.971, 150.0], [-22.5, -38.971, 150.0]])
FIVE = np.vstack([FLAT, SPATIAL[:2]])


def fitted(nests_mm, nest_mm, n=2000):
    """Errors of centre and turn (n, 3) of poses fitted to nests that err independently, and of the nests."""
    sigma = nest_mm * np.sqrt(nests_mm.size / 6)
    rng = np.random.default_rng(1)
    poses = [rigid_alignment(nests_mm, nests_mm + sigma * rng.normal(size=nests_mm.shape)) for _ in range(n)]
    turns = np.array([turn for turn, _ in poses])
    shifts = np.array([shift for _, shift in poses])
    placed = nests_mm @ np.swapaxes(turns, 1, 2) + shifts[:, None]
    return placed.mean(axis=1) - centre(nests_mm), vector_from_rotation(turns), placed - nests_mm


@pytest.mark.parametrize("nests_mm", [FLAT, SPATIAL, FIVE])
def test_a_pose_is_known_as_fits_to_noisy_nests_scatter(nests_mm):
    found = pose_uncertainty(nests_mm, 0.045)

    shifts, turns, nests = fitted(nests_mm, 0.045)

    # RMS of 6000 draws: known to 1 %, three of it
    assert np.sqrt(np.mean(shifts**2)) == pytest.approx(found.position_mm, rel=0.03)
    assert np.sqrt(np.mean(turns**2)) == pytest.approx(found.rotation_rad, rel=0.03)
    assert np.sqrt(np.mean(nests**2)) == pytest.approx(0.045, rel=0.03)


def test_at_the_centre_position_and_turn_share_no_error():
    shifts, turns, _ = fitted(FIVE, 0.045)

    correlation = np.corrcoef(np.hstack([shifts, turns]), rowvar=False)[:3, 3:]

    assert np.abs(correlation).max() < 0.08  # 3.5 standard deviations of 2000 draws


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0)])
def test_the_normal_points_away_from_the_flange_however_the_nests_are_numbered(order):
    assert normal(SPATIAL[list(order)]) == pytest.approx([0.0, 0.0, 1.0])
    assert normal(FLAT) @ centre(FLAT) > 0.0


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (3, 0, 2, 1)])
def test_nests_in_a_row_beside_others_have_a_normal_too(order):
    row = np.array([[0.0, 0.0, 90.0], [50.0, 0.0, 90.0], [100.0, 0.0, 90.0], [0.0, 80.0, 90.0]])

    assert normal(row[list(order)]) == pytest.approx([0.0, 0.0, 1.0])


@pytest.mark.parametrize("along", [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.36, 0.48, -0.8)])
def test_nests_on_a_line_tell_no_pose(along):
    line = np.array([10.0, 20.0, 30.0]) + np.outer([0.0, 40.0, 90.0], along)

    with pytest.raises(UnderdeterminedError, match="on a line"):
        pose_uncertainty(line, 0.045)
