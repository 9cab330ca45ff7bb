r"""Random functions: many small parameters together, as large as the data ask for.

Columns X of a function, each scaled to its prior width, have weights w ~ N(0, v I). Past the parameters that
are fitted they keep the products G = X^T X and b = X^T r. With G = U diag(l) U^T and a_i = (U^T b)_i^2 / l_i,
a ratio t of v to the variance of the noise takes sum_i a_i t l_i / (1 + t l_i) out of the sum of squares R,
and twice the log likelihood gains, the noise profiled out of nu degrees of freedom,

    nu ln(R / R(t)) - sum_i ln(1 + t l_i).

The most likely t is searched on a grid; whether t = 0 could have given the readings is a score test.

References
----------
D. A. Harville, J. American Statistical Association 72, 1977, 320-338 (REML).
X. Lin, Biometrika 84(2), 1997, 309-326 (variance-component score tests).
"""

from dataclasses import dataclass

import numpy as np

from truepose.diagnosis.screening.normal_equations import Sums
from truepose.diagnosis.screening.quadratic_forms import tail_probability
from truepose.domain.arrays import FloatArray

_RATIOS = np.logspace(-4.0, 6.0, 61)  # of the two variances, over the largest eigenvalue
_SEEN = 1e-9  # of the largest eigenvalue: below, nothing but rounding is seen


@dataclass(frozen=True, slots=True)
class Function:
    """A random function of its most likely size."""

    width: float  # standard deviation of its scaled parameters, 0 where none is seen
    gain: float  # of twice the log likelihood
    explained: float  # sum of squares
    size: float  # effective number of parameters


_NOTHING = Function(0.0, -np.inf, 0.0, 0.0)


def most_likely(gram: FloatArray, towards: FloatArray, sums: Sums, widest: float = np.inf) -> Function:
    """Fit a random function by maximum likelihood, no larger than physics allows.

    Parameters
    ----------
    gram : ndarray, shape (k, k)
        Products of its scaled columns past what is fitted.
    towards : ndarray, shape (k,)
        Their products with the residuals.
    sums : Sums
        Of these residuals.
    widest : float
        What the width of its scaled parameters may be at most.
    """
    sizes, axes = np.linalg.eigh(gram)
    seen = sizes > _SEEN * max(float(sizes.max(initial=0.0)), 1e-300)
    if not seen.any():
        return _NOTHING
    sizes = sizes[seen]
    along = (axes[:, seen].T @ towards) ** 2 / sizes
    ratios = _RATIOS[:, None] / float(sizes.max())
    shrunk = ratios * sizes / (1.0 + ratios * sizes)
    explained = np.minimum(shrunk @ along, (1.0 - 1e-9) * sums.residual_square)
    left = sums.residual_square - explained
    gain = sums.degrees / sums.alike * np.log(sums.residual_square / left)
    gain -= np.log1p(ratios * sizes).sum(axis=1)
    widths = np.sqrt(ratios[:, 0] * left / max(sums.degrees, 1.0))
    best = int(np.argmax(np.where(widths <= widest, gain, -np.inf)))
    return Function(float(widths[best]), float(gain[best]), float(explained[best]), float(shrunk[best].sum()))


def chance(gram: FloatArray, towards: FloatArray, sums: Sums) -> float:
    """Chance that noise alone lies as much along a random function."""
    weights = np.maximum(np.linalg.eigvalsh(gram), 0.0)
    statistic = float(towards @ towards) / sums.variance / sums.alike
    return tail_probability(statistic, weights, sums.degrees / sums.alike)
