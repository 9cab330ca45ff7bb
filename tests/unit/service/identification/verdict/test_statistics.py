"""Figures of residuals, and the mean norm that noise alone gives."""

import numpy as np
import pytest

from truepose.identification.verdict.judge import mean_norm, statistics

DRAWS = np.random.default_rng(0).standard_normal((200_000, 3))


@pytest.mark.parametrize(
    "sigma",
    [(1.0, 1.0, 1.0), (1.0, 0.1, 0.1), (1.0, 1.0, 0.01), (1.0, 0.0, 0.0)],
    ids=["ball", "cigar", "disc", "needle"],
)
def test_the_mean_norm_is_that_of_draws(sigma):
    turn = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))[0]
    covariance = turn @ np.diag(np.square(sigma)) @ turn.T

    drawn = np.linalg.norm(DRAWS * sigma, axis=1)

    # standard error of the mean of 200,000 draws, five times
    assert mean_norm(covariance[None]) == pytest.approx(
        drawn.mean(), abs=5 * drawn.std() / np.sqrt(len(DRAWS))
    )


def test_the_mean_norm_of_equal_axes_is_maxwells():
    assert mean_norm(0.09 * np.eye(3)[None]) == pytest.approx(0.3 * np.sqrt(8.0 / np.pi), rel=1e-12)


def test_several_readings_are_averaged():
    both = np.stack([np.eye(3), 4.0 * np.eye(3)])

    assert mean_norm(both) == pytest.approx(1.5 * np.sqrt(8.0 / np.pi), rel=1e-12)


def test_figures_are_those_of_the_norms():
    figures = statistics(np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 1.0], [0.0, 3.0, 0.0]]), 0.2)

    assert (figures.n, figures.mean_mm, figures.max_mm, figures.noise_mm) == (3, 3.0, 5.0, 0.2)
    assert figures.rms_mm == pytest.approx(np.sqrt(35.0 / 3.0))
    assert figures.sd_mm == pytest.approx(2.0)


def test_one_reading_has_no_scatter():
    assert statistics(np.array([[1.0, 0.0, 0.0]]), 0.0).sd_mm == 0.0


def test_the_mean_norm_of_what_is_not_known_is_not_known():
    assert np.isnan(mean_norm(np.full((2, 3, 3), np.nan)))
