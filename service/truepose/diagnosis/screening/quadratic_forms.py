r"""Distribution of weighted sums of chi-square variables, for tests of smooth structure.

For residuals r of unknown size with nu degrees of freedom and U = r^T S r / (r^T r / nu), S with eigenvalues
l_i, P(U > u) = P(sum_i (l_i - u / nu) z_i^2 > 0) over nu independent standard normal z_i (l_i = 0 beyond the
rank). Its saddlepoint approximation is accurate far into the tail, where a scaled chi-square is not.

References
----------
D. Kuonen, Biometrika 86(4), 1999, 929-935.
R. Lugannani, S. Rice, Advances in Applied Probability 12(2), 1980, 475-490.
"""

import numpy as np
from scipy.optimize import brentq

from truepose.diagnosis.distributions import normal_exceeded
from truepose.domain.arrays import FloatArray


def tail_probability(statistic: float, weights: FloatArray, degrees: float) -> float:
    """Chance that noise alone exceeds the statistic.

    Parameters
    ----------
    statistic : float
        U.
    weights : ndarray, shape (k,)
        Eigenvalues of S, not negative.
    degrees : float
        nu; where there are fewer than weights, as many as weights are counted.

    Returns
    -------
    float
    """
    positive = weights[weights > 1e-12 * max(float(weights.max(initial=0.0)), 1e-300)]
    if positive.size == 0:
        return 1.0
    values, multiplicity = positive - statistic / degrees, np.ones(positive.size)
    if degrees > positive.size:
        values = np.append(values, -statistic / degrees)
        multiplicity = np.append(multiplicity, degrees - positive.size)
    if values.max() <= 0.0:
        return 0.0
    if values.min() >= 0.0:
        return 1.0
    return _above_zero(values / np.abs(values).max(), multiplicity)


def _above_zero(values: FloatArray, multiplicity: FloatArray) -> float:
    """P(sum of multiplicity * values * z^2 > 0), for values of both signs."""
    mean = float(multiplicity @ values)
    spread = float(np.sqrt(2.0 * multiplicity @ values**2))
    if abs(mean) < 1e-6 * spread:
        return 0.5

    def slope(t: float) -> float:
        return float(multiplicity @ (values / (1.0 - 2.0 * t * values)))

    highest = 0.5 / float(values.max())
    lowest = 0.5 / float(values.min())
    if mean < 0.0:
        t = brentq(slope, 0.0, highest * (1.0 - 1e-9), xtol=1e-12)
    else:
        t = brentq(slope, lowest * (1.0 - 1e-9), 0.0, xtol=1e-12)
    generating = -0.5 * float(multiplicity @ np.log(1.0 - 2.0 * t * values))
    curvature = 2.0 * float(multiplicity @ (values / (1.0 - 2.0 * t * values)) ** 2)
    w = float(np.sign(t) * np.sqrt(max(-2.0 * generating, 0.0)))
    v = t * float(np.sqrt(curvature))
    if abs(w) < 1e-3 or abs(v) < 1e-3:
        return float(normal_exceeded(-mean / spread))
    return float(np.clip(normal_exceeded(w + np.log(v / w) / w), 0.0, 1.0))
