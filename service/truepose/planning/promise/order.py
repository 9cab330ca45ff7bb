"""The order in which configurations are worth measuring: every next one raises O1 most.

det M of the information M grows by det(I + J_a M^-1 J_a') with a candidate a (D-optimality, as in
`planning.choice_by_exchange`). Sets of a greedy choice are nested, so that whoever stops early, or goes on,
has the best begun; an exchange among all candidates is better by 3 % of the predicted error at 30
configurations and by 0.3 % at 50 (measured on the simulated cell).
"""

from collections.abc import Callable

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray


def most_informative_first(rows: FloatArray, n: int, information: FloatArray) -> IntArray:
    """Choose n of the candidates one after another.

    Parameters
    ----------
    rows : ndarray, shape (n_candidates, d, P)
        Whitened derivatives of each candidate's readings.
    n : int
        All candidates are taken where there are no more.
    information : ndarray, shape (P, P)
        What is known before the first, positive definite.

    Returns
    -------
    ndarray, shape (min(n, n_candidates),)
        Indices in the order of choice.
    """
    unit = np.eye(rows.shape[1])

    def gains(covariance: FloatArray) -> FloatArray:
        grown: FloatArray = np.linalg.slogdet(unit + (rows @ covariance) @ np.swapaxes(rows, 1, 2))[1]
        return grown

    return best_first(rows, n, information, gains)


def best_first(
    rows: FloatArray, n: int, information: FloatArray, gains: Callable[[FloatArray], FloatArray]
) -> IntArray:
    """Choose n of the candidates one after another, each the best after those before.

    Parameters as above; `gains` says what each candidate, shape (n_candidates,), is worth beside a
    covariance, shape (P, P).
    """
    covariance: FloatArray = np.asarray(np.linalg.inv(information), dtype=float)
    free = np.ones(len(rows), dtype=bool)
    order = np.empty(min(n, len(rows)), dtype=np.int64)
    for place in range(len(order)):
        order[place] = best = int(np.argmax(np.where(free, gains(covariance), -np.inf)))
        free[best] = False
        covariance = with_readings(covariance, rows[best])
    return order


def with_readings(covariance: FloatArray, rows: FloatArray) -> FloatArray:
    """Return what a covariance, shape (P, P), becomes with readings of whitened derivatives (d, P)."""
    seen = covariance @ rows.T
    return np.asarray(covariance - seen @ np.linalg.solve(np.eye(len(rows)) + rows @ seen, seen.T))
