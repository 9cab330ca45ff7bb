"""Distributions of chance over arrays, from the special functions.

With k degrees of freedom the log density of chi-square at x is

    (k/2 - 1) ln x - x/2 - ln Gamma(k/2) - (k/2) ln 2,

and of K marked ones among N, the chance that n drawn without replacement hold j marked ones is
C(K, j) C(N - K, n - j) / C(N, n) (hypergeometric).

The distributions of scipy.stats give the same digits, but to import them takes a third of a second in each
worker and each command.
"""

import numpy as np
from scipy.special import fdtrc, gammaln, ndtr, xlogy

from truepose.domain.arrays import FloatArray, IntArray

Numbers = float | FloatArray | IntArray  # one, or arrays that go together


def chi2_log_density(squared: Numbers, degrees: Numbers) -> FloatArray:
    """Return the logarithm of the density of chi-square variates.

    Parameters
    ----------
    squared : float or ndarray
        Values [1], >= 0.
    degrees : float or ndarray
        Degrees of freedom, > 0; broadcast against `squared`.

    Returns
    -------
    ndarray
        Of the broadcast shape.
    """
    half = np.divide(degrees, 2.0)
    return np.asarray(
        xlogy(half - 1.0, squared) - np.divide(squared, 2.0) - gammaln(half) - half * np.log(2.0)
    )


def f_exceeded(ratio: Numbers, above: Numbers, below: Numbers) -> FloatArray:
    """Return the chance that a ratio of two mean squares is exceeded: the upper tail of Fisher's F.

    Parameters
    ----------
    ratio : float or ndarray
        Mean square above over mean square below [1].
    above, below : float or ndarray
        Their degrees of freedom, > 0; broadcast against `ratio`.

    Returns
    -------
    ndarray
        Of the broadcast shape, from 0 to 1.
    """
    return np.asarray(fdtrc(above, below, ratio))


def normal_exceeded(deviate: Numbers) -> FloatArray:
    """Return the chance that a standard normal variate exceeds a deviate.

    Parameters
    ----------
    deviate : float or ndarray

    Returns
    -------
    ndarray
        Of the same shape, from 0 to 1.
    """
    # Of the negative deviate: 1 - Phi(x) loses every digit beyond eight standard deviations.
    return np.asarray(ndtr(np.negative(deviate)))


def hypergeometric_tail(reached: int, drawn: int, marked: int, total: int) -> float:
    """Return the chance of at least `reached` marked ones in a draw without replacement: hypergeometric tail.

    Parameters
    ----------
    reached : int
        Marked ones that were drawn.
    drawn : int
        How many were drawn, at most `total`.
    marked, total : int
        How many are marked, and how many there are.

    Returns
    -------
    float
        0 where fewer than `reached` are marked or drawn.
    """
    count = np.arange(reached, min(drawn, marked) + 1)
    # Counts of ways overflow from a thousand readings on; their logarithms do not.
    log_chance = _log_ways(marked, count) + _log_ways(total - marked, drawn - count) - _log_ways(total, drawn)
    return float(np.exp(log_chance).sum())


def _log_ways(total: Numbers, chosen: Numbers) -> FloatArray:
    """Return the logarithm of the ways to choose; minus infinity where there is none."""
    # gammaln is infinite at 0 and at negative whole numbers, so an impossible choice gets no weight by
    # itself.
    left_over = np.subtract(total, chosen)
    return np.asarray(gammaln(np.add(total, 1.0)) - gammaln(np.add(chosen, 1.0)) - gammaln(left_over + 1.0))
