r"""Cross-validation by configuration: every configuration is predicted by a model that never saw it.

All readings of a configuration, and of its revisits, are left out together, at the weights of the full fit.
From the full solution a fold is one step of Gauss-Newton away, which needs no new linearisation: with
whitened derivatives J_k and residuals r_k of the readings of fold k, prior precision W and the slope g of the
whole cost (zero but for the solver's tolerance), the parameters without fold k are off the full solution by

    s_k = C_k (g - J_k r_k)        C_k = (W + sum over the other folds of J_l J_l^T)^-1

and a held-out reading by what s_k moves its prediction. What further steps of a refit would change is of the
second order in s_k.

References
----------
R. D. Cook, S. Weisberg, Residuals and Influence in Regression, 1982, section 2.2 (deletion formulae).
"""

from collections.abc import Iterable, Iterator

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, distinct_values
from truepose.identification.fit.robust import RobustFit
from truepose.identification.fit.solver import covariance_of, posterior_covariance, slope
from truepose.identification.model.stops import sites

_LEAVE_ONE_OUT = 40  # up to so many configurations one is left out at a time, beyond it a tenth
_FOLDS = 10


def held_out_residuals(fit: RobustFit) -> tuple[FloatArray, FloatArray]:
    """Residuals of the first block's readings, each predicted without its configuration.

    Parameters
    ----------
    fit : RobustFit
        The full solution with its weights.

    Returns
    -------
    residual : ndarray, shape (n, d)
    variance : ndarray, shape (n,)
        What the uncertainty of the fold's parameters adds per component.
    """
    final, first = fit.solution.final, fit.results[0]
    precision = 1.0 / fit.structure.prior_widths**2
    whole_slope = slope(final, precision, fit.values - fit.structure.prior_means)
    owners = _folds(fit)
    columns = _columns_of_folds(fit, owners)
    parts = [final.jacobian[:, held] for held in columns]
    residual, variance = first.residual.copy(), np.zeros(len(first.residual))
    for fold, covariance in enumerate(_covariances(final.jacobian, columns, parts, precision)):
        held, out = columns[fold], np.flatnonzero(owners[0] == fold)
        step = covariance @ (whole_slope - parts[fold] @ final.residual[held])
        motion = first.jacobian[:, out].reshape(len(step), first.residual[out].size)  # also of no parameter
        residual[out] -= (step @ motion).reshape(len(out), -1)
        spread = ((covariance @ motion) * motion).sum(axis=0)
        variance[out] = spread.reshape(len(out), -1).mean(axis=1)
    return residual, variance


def _folds(fit: RobustFit) -> list[IntArray]:
    """Return the fold of each reading, (n,) per block; -1 of readings that are never held out."""
    owners = [sites(block.targets.stops) for block in fit.blocks]
    distinct = distinct_values(owners[0])
    if len(distinct) <= _LEAVE_ONE_OUT:
        fold = np.arange(len(distinct))
    else:
        shuffled = np.random.default_rng(0).permutation(len(distinct))
        fold = np.empty(len(distinct), dtype=np.int64)
        for number, members in enumerate(np.array_split(shuffled, _FOLDS)):
            fold[members] = number
    places = [np.minimum(np.searchsorted(distinct, owner), len(distinct) - 1) for owner in owners]
    return [
        np.where(distinct[place] == owner, fold[place], -1)
        for place, owner in zip(places, owners, strict=True)
    ]


def _columns_of_folds(fit: RobustFit, owners: list[IntArray]) -> list[IntArray]:
    """Return the stacked observations of each fold, at the end those that are never held out."""
    each = zip(owners, fit.results, strict=True)
    stacked = np.concatenate([np.repeat(owner, result.residual.shape[1]) for owner, result in each])
    numbers = (*range(int(owners[0].max()) + 1), -1)
    return [np.flatnonzero(stacked == number) for number in numbers]


def _covariances(
    jacobian: FloatArray, columns: list[IntArray], parts: list[FloatArray], precision: FloatArray
) -> Iterable[FloatArray]:
    """Return the covariances (P, P) of the parameters without each fold; where one is ill, each by itself."""
    normals = _normals_of_others(parts) + np.diag(precision)
    together = covariance_of(normals)
    return _one_by_one(jacobian, columns, normals, precision) if together is None else together


def _one_by_one(
    jacobian: FloatArray, columns: list[IntArray], normals: FloatArray, precision: FloatArray
) -> Iterator[FloatArray]:
    for held, normal in zip(columns[:-1], normals, strict=True):
        covariance = covariance_of(normal)
        if covariance is None:
            covariance = posterior_covariance(np.delete(jacobian, held, axis=1), precision)
        yield covariance


def _normals_of_others(parts: list[FloatArray]) -> FloatArray:
    """Return J J^T of all parts but one, for each but the last, shape (folds, P, P).

    As sums of what is left: a difference from the whole would lose the digits of what only one fold sees.
    """
    products = np.stack([part @ part.T for part in parts])
    others: FloatArray = np.tensordot(1.0 - np.eye(len(parts)), products, 1)
    return others[:-1]
