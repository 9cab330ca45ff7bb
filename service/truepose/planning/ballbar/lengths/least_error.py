r"""Choice of configurations by the predicted error over the work space.

O1 asks how well parameters are known, whichever they are; a user asks how well positions are. With C the
covariance of all parameters and W the mean square gradient of the positions in them, the figure is tr(W C).
A configuration b with whitened rows J_b that leaves, and a that enters, change it by

    C' = C + C J_b' (I - J_b C J_b')^-1 J_b C
    tr W C'' = tr W C' - tr (I + J_a C' J_a')^-1 J_a C' W C' J_a'
"""

from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.planning.promise.order import best_first

_SMALLEST_GAIN: Final = 1e-4  # of the figure: an exchange that brings less is not worth its time
_MOST_EXCHANGES: Final = 60
_MOST_LEAVING: Final = 12  # members that are tried before the exchange ends; the rest is missed even more


def exchanged_for_error(
    rows: FloatArray, chosen: IntArray, known: FloatArray, weight: FloatArray
) -> IntArray:
    """Exchange configurations as long as the mean square error of predicted positions falls.

    Parameters
    ----------
    rows : ndarray, shape (N, L, P)
        Whitened derivatives of all candidates.
    chosen : ndarray, shape (n,)
        Indices to start from.
    known : ndarray, shape (P, P)
        Information that there is without any of them, positive definite.
    weight : ndarray, shape (P, P)
        Mean of g g' over the work space, g the gradient of a position in the parameters.

    Returns
    -------
    ndarray, shape (n,)
        Ascending.
    """
    member = np.zeros(len(rows), dtype=bool)
    member[chosen] = True
    for _ in range(_MOST_EXCHANGES):
        if member.all() or not _exchange(rows, member, known, weight):
            break
    return np.flatnonzero(member).astype(np.int64)


def least_error_first(rows: FloatArray, n: int, known: FloatArray, weight: FloatArray) -> IntArray:
    """Choose n configurations one after another: every next one lowers the mean square error most.

    Parameters as above; all are taken where there are no more.

    Returns
    -------
    ndarray, shape (min(n, N),)
        Indices in the order of choice.
    """
    return best_first(rows, n, known, lambda covariance: _changes(rows, covariance, weight, 1.0))


def _exchange(rows: FloatArray, member: BoolArray, known: FloatArray, weight: FloatArray) -> bool:
    own = rows[member].reshape(-1, rows.shape[2])
    covariance: FloatArray = np.asarray(np.linalg.inv(own.T @ own + known), dtype=float)
    figure = float(np.sum(weight * covariance))
    members, others = np.flatnonzero(member), np.flatnonzero(~member)
    missed = _changes(rows[members], covariance, weight, -1.0)
    for leaving in members[np.argsort(missed)][:_MOST_LEAVING]:
        without = _without(covariance, rows[leaving])
        gains = _changes(rows[others], without, weight, 1.0)
        best = int(np.argmax(gains))
        if float(np.sum(weight * without)) - gains[best] < figure * (1.0 - _SMALLEST_GAIN):
            member[leaving], member[others[best]] = False, True
            return True
    return False


def _without(covariance: FloatArray, left: FloatArray) -> FloatArray:
    seen = covariance @ left.T
    return np.asarray(covariance + seen @ np.linalg.solve(np.eye(len(left)) - left @ seen, seen.T))


def _changes(rows: FloatArray, covariance: FloatArray, weight: FloatArray, sign: float) -> FloatArray:
    """How much the figure changes with each configuration that enters (+1) or leaves (-1), shape (n,)."""
    n, lines, columns = rows.shape
    seen = (rows.reshape(-1, columns) @ covariance).reshape(n, lines, columns)
    own = np.eye(lines) + sign * seen @ np.swapaxes(rows, 1, 2)
    moved = (seen.reshape(-1, columns) @ weight).reshape(n, lines, columns) @ np.swapaxes(seen, 1, 2)
    return np.asarray(np.trace(np.linalg.solve(own, moved), axis1=1, axis2=2))
