"""Seats of a tool that its mountings shift and turn, and what a fit leaves of them."""

import numpy as np

SHIFT_MM, TURN_RAD = 0.15, 1.5e-3  # widths of the seats' priors
WIDTHS = np.repeat([SHIFT_MM, TURN_RAD], 3)
GROUPS = np.repeat([0, 1], 3)


def posterior(draws, noise, rng):
    """What a fit with the prior leaves of draws that were measured with some noise."""
    variance = np.tile(WIDTHS**2, len(draws))
    seen = draws.ravel() + noise * rng.standard_normal(draws.size) * np.sqrt(variance)
    precision = 1.0 / (noise**2 * variance) + 1.0 / variance
    return (seen / (noise**2 * variance) / precision).reshape(draws.shape), np.diag(1.0 / precision)
