"""What chance alone gives: chi-square and F variates, one at a time; of arrays: `diagnosis.distributions`."""

from functools import lru_cache

from truepose.identification.special_functions import beta_below, gamma_above, gamma_limit

WITHIN_95 = 1.96  # standard deviations either way that hold 95 % of all normal variates


def chi2_exceeded(squared: float, degrees: float) -> float:
    """Return the chance that a chi-square variate is larger."""
    return gamma_above(0.5 * degrees, 0.5 * squared)


@lru_cache
def chi2_limit(chance: float, degrees: float) -> float:
    """Return what a chi-square variate exceeds with that chance."""
    return 2.0 * gamma_limit(0.5 * degrees, chance)


def chi2_median(degrees: float) -> float:
    """Return what half of all chi-square variates exceed."""
    return chi2_limit(0.5, degrees)


def f_exceeded(ratio: float, above: float, below: float) -> float:
    """Return the chance that the ratio of two mean squares, of so many degrees of freedom, is larger."""
    both = below + above * ratio
    return beta_below(0.5 * below, 0.5 * above, below / both, above * ratio / both)
