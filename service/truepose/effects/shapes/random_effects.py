r"""Standard deviations of effects that are drawn anew each time, from estimates of the single draws.

The draws x_m of M occasions scatter about an unknown mean with deviation s_g in the components of group g.
They are known as a fit left them: mean m and covariance C, under a prior N(0, W) that is taken out again,
which leaves the information A = C^-1 - W^-1, b = C^-1 m. The evidence for the deviations is then

    log p(s) = (b^T (A + S^-1)^-1 b - log det(I + S A)) / 2,   S = diag(s_g^2) + (a wide common mean)

Its maximum is the estimate, the root mean square distance from there under exp(log p) is its standard
uncertainty: few occasions leave a wide one, as they should. A coarse grid finds where the evidence is, a fine
one weighs it there.

Source: D. A. Harville, J. American Statistical Association 72, 1977, 320-338 (REML).
"""

from itertools import product

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.definite import inverse

_COARSE, _FINE = 13, 15  # steps of the two grids
_FINEST, _WIDEST = 1e-2, 10.0  # of the prior's width: what the coarse grid spans
_NEGLIGIBLE = 6.0  # below the largest log evidence: 1/400 of it


def deviations(
    mean: FloatArray, covariance: FloatArray, widths: FloatArray, groups: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Estimate the deviation of each group of components.

    Parameters
    ----------
    mean : ndarray, shape (M, d)
        Estimates of the draws of M occasions, d components each.
    covariance : ndarray, shape (M d, M d)
        Of these estimates, occasions first.
    widths : ndarray, shape (d,)
        Of the prior, about 0, under which they were estimated.
    groups : ndarray, shape (d,)
        Group 0, 1, .. of each component.

    Returns
    -------
    deviation, standard_uncertainty : ndarray, shape (G,)
    """
    occasions, components = mean.shape
    scale = np.tile(widths, occasions)
    precision = inverse(covariance / np.outer(scale, scale))
    vector = precision @ (mean.ravel() / scale)
    information = _positive(precision - np.eye(len(scale)))
    common = np.kron(np.full((occasions, occasions), _WIDEST**2), np.eye(components))

    def evidence(deviation: FloatArray) -> float:
        return _evidence(np.tile(deviation[groups] ** 2, occasions), common, information, vector)

    n_groups = int(groups.max()) + 1
    coarse = np.array(list(product(np.geomspace(_FINEST, _WIDEST, _COARSE), repeat=n_groups)))
    level = np.array([evidence(deviation) for deviation in coarse])
    fine = _around(coarse[level > level.max() - _NEGLIGIBLE])
    level = np.array([evidence(deviation) for deviation in fine])
    best, share = fine[level.argmax()], np.exp(level - level.max())
    spread = np.sqrt(share @ (fine - best) ** 2 / share.sum())
    unit = np.array([widths[groups == group][0] for group in range(n_groups)])
    return best * unit, spread * unit


def _around(chosen: FloatArray) -> FloatArray:
    """Return an even grid over the box of the chosen deviations and one coarse step beyond, shape (m, G)."""
    step = (_WIDEST / _FINEST) ** (1.0 / (_COARSE - 1))
    low, high = chosen.min(axis=0) / step, chosen.max(axis=0) * step
    low = np.where(low < _FINEST, 0.0, low)
    axes = [np.linspace(a, b, _FINE) for a, b in zip(low, high, strict=True)]
    return np.array(list(product(*axes)))


def _positive(matrix: FloatArray) -> FloatArray:
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)


def _evidence(variance: FloatArray, common: FloatArray, information: FloatArray, vector: FloatArray) -> float:
    spread = np.diag(variance) + common
    loaded = np.eye(len(variance)) + information @ spread
    explained = vector @ spread @ np.linalg.solve(loaded, vector)
    return 0.5 * float(explained - np.linalg.slogdet(loaded)[1])
