"""Means and scatters of visits, with the first-order uncertainty that a finite number of them leaves.

A figure that is a function of the distribution of the visits moves by the mean of its influence function
when the visits are drawn anew; its variance is that of the influence over n (the delta method, which the GUM,
JCGM 100:2008, 5.1.2, writes for a function of means).
"""

import numpy as np

from truepose.domain.arrays import FloatArray

# Of three independent normal components of standard deviation 1 (Maxwell): mean and sd of their norm.
_RADIUS_MEAN = 2.0 * np.sqrt(2.0 / np.pi)
_RADIUS_SD = np.sqrt(3.0 - 8.0 / np.pi)
RADIUS_OF_NOISE = float(_RADIUS_MEAN + 3.0 * _RADIUS_SD)  # mean + 3 sd: RP of an instrument alone


def scatter(values: FloatArray) -> float:
    """Return the sample standard deviation of (n,), n >= 2; of equal values exactly 0."""
    return float((values - values[0]).std(ddof=1))


def of_mean(values: FloatArray) -> float:
    """Return the standard uncertainty of a mean of (n,) visits, from their own scatter."""
    return scatter(values) / float(np.sqrt(values.size))


def three_scatters(values: FloatArray) -> tuple[float, float]:
    """Return 3 S of (n,) visits and its standard uncertainty."""
    return _with_uncertainty(values, mean_weight=0.0)


def mean_and_three_scatters(values: FloatArray) -> tuple[float, float]:
    """Return mean + 3 S of (n,) visits and its standard uncertainty."""
    return _with_uncertainty(values, mean_weight=1.0)


def _with_uncertainty(values: FloatArray, mean_weight: float) -> tuple[float, float]:
    s, away = scatter(values), values - values.mean()
    value = mean_weight * float(values.mean()) + 3.0 * s
    if s == 0.0:
        return value, 0.0
    return value, of_mean(mean_weight * away + 1.5 * (away**2 / s - s))


def barycentre(positions_mm: FloatArray) -> FloatArray:
    """Return the mean (3,) of (n, 3) visits; of equal ones exactly what they are."""
    return np.asarray(positions_mm[0] + (positions_mm - positions_mm[0]).mean(axis=0))


def barycentre_covariance(positions_mm: FloatArray) -> FloatArray:
    """Return the covariance (3, 3) of the mean of (n, 3) visits, from their own scatter."""
    return np.asarray(np.cov(positions_mm, rowvar=False)) / len(positions_mm)


def norm_uncertainty(vector: FloatArray, covariance: FloatArray) -> float:
    """Return the standard uncertainty of the length of (3,); of no length, that along the worst direction."""
    length = float(np.linalg.norm(vector))
    if length == 0.0:
        return float(np.sqrt(np.linalg.norm(covariance, 2)))
    unit = vector / length
    return float(np.sqrt(unit @ covariance @ unit))


def common(uncertainties: FloatArray) -> float:
    """Return the instrument's uncertainty at one pose (n,): a constant error of it does not average out."""
    return float(np.sqrt(np.mean(uncertainties**2)))
