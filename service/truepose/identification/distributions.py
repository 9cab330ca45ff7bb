"""What chance alone gives: chi-square and F variates, Holm's levels of many tests, and Carlson's R_G.

Incomplete gamma and beta functions and Carlson's R_G, for what every identification asks of them.
scipy.special has them too, but to import it takes longer than to identify a robot from a hundred readings.
Equations are those of the NIST Digital Library of Mathematical Functions (DLMF).

    Q(a, x) = integral of t^(a-1) e^-t from x on, over Gamma(a)              P(chi2_k > c) = Q(k/2, c/2)
    I_x(a, b) = integral of t^(a-1) (1-t)^(b-1) up to x, over B(a, b)        P(F_(m,k) > f) = I_y(k/2, m/2)

with y = k / (k + m f). A power over a gamma function is the exponential of a small difference of large
numbers; so the two are taken together, as a deviance D(u) = u - 1 - ln u and what Stirling's formula leaves:

    x^a e^-x / Gamma(a + 1) = exp(-a D(x / a) - rest(a)) / sqrt(2 pi a)

References
----------
C. Loader, Fast and accurate computation of binomial probabilities, 2000.
B. C. Carlson, Numerical computation of real or complex elliptic integrals, Numer. Algorithms 10, 1995.
"""

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import count

import numpy as np

from truepose.domain.arrays import FloatArray

_EPSILON = 2.0**-52
_NO_ZERO = 1e-300  # stands for a denominator of zero (Thompson and Barnett's modification of Lentz's method)
_STIRLING = (1 / 12, -1 / 360, 1 / 1260, -1 / 1680, 1 / 1188, -691 / 360360, 1 / 156)  # DLMF 5.11.1
_STIRLING_FROM = 10.0  # where these terms are exact to rounding
_HALF_LOG_TWO_PI = 0.5 * math.log(2.0 * math.pi)
_SQUARED_TO_ROUNDING = 1e-9  # a relative step of Newton's method after which the next is none
_FLAT = 1e-20  # of the largest argument of R_G: what stands for zero
_ALIKE = 2e-3  # spread of its arguments at which Carlson's series is exact to rounding


def gamma_above(shape: float, start: float) -> float:
    """Return Q(a, x), the share of the gamma function above x = `start` (DLMF 8.2.4).

    Parameters
    ----------
    shape : float
        a > 0.
    start : float
        x; all lies above what is not positive.

    Returns
    -------
    float
        0 to 1; NaN of what is no number.
    """
    if start <= 0.0 or start == math.inf:
        return float(start <= 0.0)
    # Series and fraction each converge fast on one side of the mean.
    if start < shape + 1.0:
        return 1.0 - _gamma_power(shape, start) * _gamma_series(shape, start)
    # Above the mean the complement of the series would lose the digits of a small chance.
    fraction = _continued(start + 1.0 - shape, _gamma_terms(shape, start))
    return _gamma_power(shape, start) * shape / fraction


def gamma_limit(shape: float, chance: float) -> float:
    """Return x with Q(a, x) = `chance`, by Newton's method on ln Q.

    ln Q is concave for a > 1 and convex for a < 1, so that one step at most passes the root.

    Parameters
    ----------
    shape : float
        a > 0.
    chance : float
        Above 0 and below 1.

    Returns
    -------
    float
        x, with a relative error of the order of rounding.
    """
    limit = step = _rough_gamma_limit(shape, chance)
    while abs(step) > _SQUARED_TO_ROUNDING * limit:
        above = gamma_above(shape, limit)
        step = math.log(above / chance) * above * limit / (_gamma_power(shape, limit) * shape)
        # A step beyond 0 would leave where the logarithm is defined.
        step = max(step, -0.9 * limit)
        limit += step
    return limit


def beta_below(a: float, b: float, end: float, left: float) -> float:
    """Return I_x(a, b), the share of the beta function below x = `end` (DLMF 8.17.2).

    Parameters
    ----------
    a, b : float
        Above 0.
    end : float
        x.
    left : float
        1 - x, which may have more digits than x leaves of it.

    Returns
    -------
    float
        0 to 1.
    """
    if end <= 0.0 or left <= 0.0:
        return float(left <= 0.0)
    if end > (a + 1.0) / (a + b + 2.0):  # there the fraction of the other side converges
        return 1.0 - beta_below(b, a, left, end)
    return _beta_power(a, b, end, left) / (a * _continued(1.0, _beta_terms(a, b, end)))


def _gamma_power(shape: float, x: float) -> float:
    """Return x^a e^-x / Gamma(a + 1)."""
    deviance = shape * _deviance(x / shape)
    return math.exp(-deviance - _beyond_stirling(shape)) / math.sqrt(2.0 * math.pi * shape)


def _beta_power(a: float, b: float, x: float, left: float) -> float:
    """Return x^a (1 - x)^b / B(a, b)."""
    both = a + b
    deviance = a * _deviance(both * x / a) + b * _deviance(both * left / b)
    rest = _beyond_stirling(both) - _beyond_stirling(a) - _beyond_stirling(b)
    return math.exp(rest - deviance) * math.sqrt(a * b / (2.0 * math.pi * both))


def _deviance(ratio: float) -> float:
    # Near 1 this loses digits of a small number, which in an exponent do no harm.
    return ratio - 1.0 - math.log(ratio)


def _beyond_stirling(x: float) -> float:
    """Return ln Gamma(x + 1) less Stirling's (x + 1/2) ln x - x + ln(2 pi) / 2 (DLMF 5.11.1)."""
    if x < _STIRLING_FROM:
        return math.lgamma(x + 1.0) - (x + 0.5) * math.log(x) + x - _HALF_LOG_TWO_PI
    return sum(term / x ** (2 * k + 1) for k, term in enumerate(_STIRLING))


def _gamma_series(shape: float, x: float) -> float:
    """Return 1 + x / (a + 1) + x^2 / ((a + 1) (a + 2)) + ... (DLMF 8.11.4)."""
    total = term = 1.0
    denominator = shape
    # All terms are positive: where the next one no longer counts, none after it does.
    while term > _EPSILON * total:
        denominator += 1.0
        term *= x / denominator
        total += term
    return total


def _gamma_terms(shape: float, x: float) -> Iterator[tuple[float, float]]:
    """Yield numerators and denominators (DLMF 8.9.2)."""
    return ((-n * (n - shape), x + 2 * n + 1.0 - shape) for n in count(1))


def _beta_terms(a: float, b: float, x: float) -> Iterator[tuple[float, float]]:
    """Yield numerators and denominators (DLMF 8.17.22, 8.17.23)."""
    for m in count():
        yield -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1.0)), 1.0
        yield (m + 1.0) * (b - m - 1.0) * x / ((a + 2 * m + 1.0) * (a + 2 * m + 2.0)), 1.0


def _continued(first: float, terms: Iterator[tuple[float, float]]) -> float:
    """Return first + a1 / (b1 + a2 / (b2 + ...)), by Lentz's method."""
    value = above = first or _NO_ZERO
    below = 0.0
    # Lentz's two ratios never overflow, as numerator and denominator of the fraction by themselves would.
    for numerator, denominator in terms:
        below = 1.0 / (denominator + numerator * below or _NO_ZERO)
        above = denominator + numerator / above or _NO_ZERO
        value *= above * below
        if not abs(above * below - 1.0) > _EPSILON:  # what is no number ends as well
            break
    return value


def _rough_gamma_limit(shape: float, chance: float) -> float:
    """Return the limit by Wilson and Hilferty's cube of a normal variate, within a few per cent."""
    third = 1.0 - 1.0 / (9.0 * shape) + _rough_normal_limit(chance) / (3.0 * math.sqrt(shape))
    return float(shape * max(third, 0.1) ** 3)


def _rough_normal_limit(chance: float) -> float:
    """Return what a normal variate exceeds, within 0.003 (Abramowitz and Stegun 26.2.22)."""
    if chance > 0.5:
        return -_rough_normal_limit(1.0 - chance)
    t = math.sqrt(-2.0 * math.log(chance))
    return t - (2.30753 + 0.27061 * t) / (1.0 + 0.99229 * t + 0.04481 * t**2)


def carlson_rg(arguments: FloatArray) -> FloatArray:
    """Carlson's completely symmetric integral of the second kind, R_G(x, y, z).

    Parameters
    ----------
    arguments : ndarray, shape (n, 3)
        x, y, z >= 0, in any order.

    Returns
    -------
    ndarray, shape (n,)
        By DLMF 19.21.10 with z between the others: then no term is taken from another.
    """
    largest = arguments.max(axis=1, initial=0.0)
    share = arguments / np.where(largest > 0.0, largest, 1.0)[:, None]
    # An argument of 0 is allowed in R_G, but R_F and R_D of two zeros are not finite.
    x, z, y = np.maximum(np.sort(share, axis=1), _FLAT).T
    rf, rd = _carlson_rf_rd(x, y, z)
    double = z * rf + (z - x) * (y - z) * rd / 3.0 + np.sqrt(x * y / z)
    return np.asarray(0.5 * np.sqrt(largest) * double)


def _carlson_rf_rd(x: FloatArray, y: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return R_F and R_D, by duplication until the arguments are alike (DLMF 19.26.18, 19.26.20)."""
    alike, share = np.stack([x, y, z]), 1.0
    passed = np.zeros_like(x)
    # Each round brings the arguments four times closer, whatever they were.
    while np.any(np.ptp(alike, axis=0) > _ALIKE * alike[2]):
        root = np.sqrt(alike)
        common = root[0] * root[1] + root[1] * root[2] + root[2] * root[0]
        passed += share / (root[2] * (alike[2] + common))
        alike = (alike + common) / 4.0
        share /= 4.0
    return _rf_series(*alike), 3.0 * passed + share * _rd_series(*alike)


def _rf_series(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    """Return R_F of arguments that are alike (DLMF 19.36.1)."""
    mean = (x + y + z) / 3.0
    dx, dy = 1.0 - x / mean, 1.0 - y / mean
    dz = -(dx + dy)
    e2, e3 = dx * dy - dz**2, dx * dy * dz
    return np.asarray((1.0 - e2 / 10 + e3 / 14 + e2**2 / 24 - 3 * e2 * e3 / 44) / np.sqrt(mean))


def _rd_series(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    """Return R_D of arguments that are alike (DLMF 19.36.2)."""
    mean = (x + y + 3.0 * z) / 5.0
    dx, dy = 1.0 - x / mean, 1.0 - y / mean
    dz = -(dx + dy) / 3.0
    e2, e3 = dx * dy - 6 * dz**2, (3 * dx * dy - 8 * dz**2) * dz
    e4, e5 = 3 * (dx * dy - dz**2) * dz**2, dx * dy * dz**3
    series = 1.0 - 3 * e2 / 14 + e3 / 6 + 9 * e2**2 / 88 - 3 * e4 / 22 - 9 * e2 * e3 / 52 + 3 * e5 / 26
    return np.asarray(series / mean**1.5)


WITHIN_95 = 1.96  # standard deviations either way that hold 95 % of all normal variates


def chi2_exceeded(squared: float, degrees: float) -> float:
    """Return the chance that a chi-square variate is larger.

    Parameters
    ----------
    squared : float
        Sum of squares of standard normal variates.
    degrees : float
        Of freedom, > 0.

    Returns
    -------
    float
        0 to 1.
    """
    return gamma_above(0.5 * degrees, 0.5 * squared)


# A fit asks for the same few limits in every round.
@lru_cache
def chi2_limit(chance: float, degrees: float) -> float:
    """Return what a chi-square variate exceeds with that chance.

    Parameters
    ----------
    chance : float
        Above 0 and below 1.
    degrees : float
        Of freedom, > 0.
    """
    # A chi-square variate is twice a gamma variate of half as many degrees of freedom.
    return 2.0 * gamma_limit(0.5 * degrees, chance)


def chi2_median(degrees: float) -> float:
    """Return what half of all chi-square variates exceed."""
    return chi2_limit(0.5, degrees)


def f_exceeded(ratio: float, above: float, below: float) -> float:
    """Return the chance that the ratio of two mean squares is larger.

    Parameters
    ----------
    ratio : float
        Mean square over mean square.
    above, below : float
        Degrees of freedom of the two, > 0.

    Returns
    -------
    float
        0 to 1.
    """
    both = below + above * ratio
    return beta_below(0.5 * below, 0.5 * above, below / both, above * ratio / both)


def holm(p_values: Sequence[float | None]) -> list[float | None]:
    """Return p values corrected for all that are known, in their order.

    Parameters
    ----------
    p_values : sequence of float or None
        None of tests that were not made: they do not count.

    Returns
    -------
    list of float or None
        Each at most 1: the smallest level of all tests together at which this one is refused.

    References
    ----------
    S. Holm, Scand. J. Statist. 6, 1979, 65-70.
    """
    known = sorted((p, index) for index, p in enumerate(p_values) if p is not None)
    corrected: list[float | None] = [None] * len(p_values)
    largest = 0.0
    for rank, (p, index) in enumerate(known):
        # A test is refused only where all of smaller p are: its level is never below theirs.
        largest = max(largest, min(1.0, (len(known) - rank) * p))
        corrected[index] = largest
    return corrected
