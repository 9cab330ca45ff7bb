"""What chance alone gives, over arrays: from the special functions.

The distributions of scipy.stats give the same digits, but to import them takes a third of a second in each
worker and each command.
"""

import numpy as np
from scipy.special import fdtrc, gammaln, ndtr, xlogy

from truepose.domain.arrays import FloatArray, IntArray

Numbers = float | FloatArray | IntArray  # one, or arrays that go together


def chi2_log_density(squared: Numbers, degrees: Numbers) -> FloatArray:
    """Return the logarithm of the density of chi-square variates."""
    half = np.divide(degrees, 2.0)
    return np.asarray(
        xlogy(half - 1.0, squared) - np.divide(squared, 2.0) - gammaln(half) - half * np.log(2.0)
    )


def f_exceeded(ratio: Numbers, above: Numbers, below: Numbers) -> FloatArray:
    """Return the chance that the ratio of two mean squares, of so many degrees of freedom, is larger."""
    return np.asarray(fdtrc(above, below, ratio))


def normal_exceeded(deviate: Numbers) -> FloatArray:
    """Return the chance that a standard normal variate is larger."""
    return np.asarray(ndtr(np.negative(deviate)))


def so_many_drawn(reached: int, drawn: int, marked: int, total: int) -> float:
    """Return the chance that at least `reached` of `drawn` out of `total` are `marked`: hypergeometric."""
    count = np.arange(reached, min(drawn, marked) + 1)
    log_chance = _log_ways(marked, count) + _log_ways(total - marked, drawn - count) - _log_ways(total, drawn)
    return float(np.exp(log_chance).sum())


def _log_ways(total: Numbers, chosen: Numbers) -> FloatArray:
    """Return the logarithm of the ways to choose; minus infinity where there is none."""
    left_over = np.subtract(total, chosen)
    return np.asarray(gammaln(np.add(total, 1.0)) - gammaln(np.add(chosen, 1.0)) - gammaln(left_over + 1.0))
