"""Choice of configurations by exchange: the set of n candidates with the largest O1.

For a given n, O1 grows with det M, M = sum over the chosen candidates of J_i' J_i (D-optimality; thesis of
A. Nubiola, 2014, section 2.5.2; V. V. Fedorov, Theory of Optimal Experiments, 1972, chapter 3). With
G_ab = J_a M^-1 J_b' all losses and gains follow from blocks as small as one candidate's Jacobian is high:

    det(M - J_b'J_b) = det M det(I - G_bb)
    det(M + J_a'J_a) = det M det(I + G_aa)
    without b:  G_aa + G_ab (I - G_bb)^-1 G_ba        with b:  G_aa - G_ab (I + G_bb)^-1 G_ba

so that an exchange brings every block up to date by two thin products. Where M without b is (nearly)
singular, as with a set that is just large enough, the same gain is taken from

    det(M - J_b'J_b + J_a'J_a) = det M det A_a det(I - G_bb + G_ba A_a^-1 G_ab)        A_a = I + G_aa

An exchange takes out the candidate whose loss lowers the index least and puts in the one that raises it most.
Where that brings nothing, the other members are tried in the order of their loss; it ends when no
single exchange helps.
"""

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.planning.errors import TooFewCandidatesError

_SMALLEST_GAIN: Final = 1e-6  # of log det: far above its rounding, and O1 gains less than that relatively
_FRESH: Final = (
    16  # exchanges after which the blocks are worked out anew: what rounding adds up to stays small
)
_DISPENSABLE: Final = 1e-4  # of det(I - G_bb): below it too few digits are left of what stays without b
_RIDGE: Final = 1e-9  # of the mean information per parameter: makes a rank-deficient start comparable


@dataclass(frozen=True, slots=True)
class Selection:
    """The chosen candidates.

    Attributes
    ----------
    indices : ndarray, shape (n,)
        Ascending.
    exchanges : int
        How many were made.
    """

    indices: IntArray
    exchanges: int


def choose_by_exchange(
    jacobians: FloatArray,
    n: int,
    rng: np.random.Generator,
    *,
    start: IntArray | None = None,
    prior_information: FloatArray | None = None,
) -> Selection:
    """Choose n candidates so that no single exchange raises O1.

    Parameters
    ----------
    jacobians : ndarray, shape (n_candidates, rows, n_parameters)
        Derivatives of each candidate's observations, columns scaled to comparable units.
    n : int
        How many to choose.
    rng : numpy.random.Generator
        Draws the start where none is given.
    start : ndarray, shape (n,), optional
        Indices of the set to start from, all different.
    prior_information : ndarray, shape (n_parameters, n_parameters), optional
        What is known beforehand, in the scaling of `jacobians`; without it, next to nothing.

    Returns
    -------
    Selection
        A local optimum: another start may end at another.

    Raises
    ------
    TooFewCandidatesError
        There are fewer than n candidates.
    ConfigurationError
        Jacobians or prior have the wrong shape or are not finite, n is below 1, or the start is no set of n.
    """
    _check_arguments(jacobians, n, start)
    if prior_information is not None:
        _check_prior(jacobians, prior_information)
    chosen = np.zeros(len(jacobians), dtype=bool)
    chosen[rng.choice(len(jacobians), n, replace=False) if start is None else start] = True
    # A start of lower rank has det M = 0 like all its neighbours: without a ridge no exchange would be
    # better than another.
    prior = _ridge(jacobians, n) if prior_information is None else prior_information
    exchanges = _exchange_until_it_stops(jacobians, chosen, prior)
    indices: IntArray = np.flatnonzero(chosen).astype(np.int64)
    return Selection(indices, exchanges)


def rank_substitutes(jacobians: FloatArray, chosen: BoolArray, prior_information: FloatArray) -> IntArray:
    """Return the candidates that are not chosen, first the one that raises O1 of the chosen ones most.

    Parameters
    ----------
    jacobians : ndarray, shape (n_candidates, rows, n_parameters)
        As in `choose_by_exchange`.
    chosen : ndarray of bool, shape (n_candidates,)
        Which are chosen.
    prior_information : ndarray, shape (n_parameters, n_parameters)
        What is known beforehand.

    Returns
    -------
    ndarray, shape (n_candidates - n_chosen,)
        Indices, the best first.
    """
    gains = _Blocks(jacobians, chosen, prior_information).gains()
    # Stable: equal gains stay in the order of the candidates, so that the same seed gives the same plan.
    ranked: IntArray = np.argsort(-gains, kind="stable")[: int(np.sum(~chosen))]
    return ranked


def _check_arguments(jacobians: FloatArray, n: int, start: IntArray | None) -> None:
    if jacobians.ndim != 3 or not jacobians.shape[2] or not np.all(np.isfinite(jacobians)):
        raise ConfigurationError(
            "Jacobians must have the shape (candidates, rows, parameters), at least one parameter and only "
            "finite entries."
        )
    if n < 1:
        raise ConfigurationError(f"The number of configurations must be at least 1 (got {n}).")
    if len(jacobians) < n:
        raise TooFewCandidatesError(
            f"{n} configurations were requested, but there are only {len(jacobians)} candidates."
        )
    candidates = range(len(jacobians))
    if start is not None and not (len(start) == n == len(set(start.tolist()) & set(candidates))):
        raise ConfigurationError(
            f"The initial selection must consist of {n} different candidate indices from 0 to "
            f"{candidates[-1]}."
        )


def _check_prior(jacobians: FloatArray, prior_information: FloatArray) -> None:
    parameters = jacobians.shape[2]
    if prior_information.shape != (parameters, parameters) or not np.all(np.isfinite(prior_information)):
        raise ConfigurationError(
            f"The prior information on {parameters} parameters must have the shape ({parameters}, "
            f"{parameters}) and only finite entries."
        )


def _ridge(jacobians: FloatArray, n: int) -> FloatArray:
    """Return the information that makes a rank-deficient start comparable, a multiple of I, shape (P, P).

    A share of n mean |J_i|^2 / P, the mean information per parameter of a set of n: it is too small to draw
    the choice anywhere.
    """
    parameters = jacobians.shape[2]
    typical = n * float(np.mean(np.sum(jacobians**2, axis=(1, 2)))) / parameters
    ridge: FloatArray = _RIDGE * max(typical, 1e-100) * np.eye(parameters)
    return ridge


def _exchange_until_it_stops(jacobians: FloatArray, chosen: BoolArray, prior: FloatArray) -> int:
    """Exchange members of `chosen`, which is changed in place, until none helps; return their number."""
    exchanges, state = 0, _Blocks(jacobians, chosen, prior)
    while (swap := state.swap()) is not None or state.exchanges > 0:
        if swap is not None:
            chosen[[swap.leaving, swap.entering]] = False, True
            exchanges += 1
        # That nothing helps is believed only of blocks worked out anew: after some exchanges rounding
        # may hide the last of them.
        if swap is None or state.exchanges == _FRESH or not state.exchanged(swap):
            state = _Blocks(jacobians, chosen, prior)
    return exchanges


class _Swap(NamedTuple):
    """Who leaves and who enters."""

    leaving: int
    entering: int
    without: FloatArray | None  # (rows, rows, N) blocks once the one has left; None: too few digits would be


class _Blocks:
    """Inverse of M and the blocks G_aa of all N candidates, which come last: products run over them."""

    def __init__(self, jacobians: FloatArray, chosen: BoolArray, prior: FloatArray) -> None:
        self._chosen = chosen.copy()
        # Brought up to date by thin products, 38 of 5,000 candidates are chosen in 0.12 s; with all
        # blocks worked out anew at each exchange it took 0.55 s.
        self._rows = np.ascontiguousarray(jacobians.transpose(2, 1, 0))  # (P, rows, N)
        members = jacobians[chosen].reshape(-1, jacobians.shape[2])
        self._inverse = _inverted(members.T @ members + prior)
        flat = self._rows.reshape(len(self._rows), -1)
        weighted = (self._inverse @ flat).reshape(self._rows.shape)
        self._blocks = _products(self._rows, weighted)  # (rows, rows, N)
        self.exchanges = 0  # since all was worked out from the candidates

    def gains(self) -> FloatArray:
        """Growth of log det M with each candidate, shape (N,); -inf of those that are chosen."""
        return np.where(self._chosen, -np.inf, _log_det(_plus_one(self._blocks)))

    def swap(self) -> _Swap | None:
        """Return the first exchange that helps; None where none does."""
        members = np.flatnonzero(self._chosen)
        losses = _log_det(_plus_one(-self._blocks[:, :, members]))
        for place in np.argsort(-losses, kind="stable"):
            leaving, without = int(members[place]), None
            # I - G_bb is nearly singular where M needs b: its inverse would keep no digits, the
            # other form has it not.
            if losses[place] > np.log(_DISPENSABLE):
                without = self._without(leaving)
                gains = losses[place] + _log_det(_plus_one(without))
            else:
                gains = self._gains_of_indispensable(leaving)
            gains[members] = -np.inf
            entering = int(np.argmax(gains))
            if gains[entering] > _SMALLEST_GAIN:
                return _Swap(leaving, entering, without)
        return None

    def exchanged(self, swap: _Swap) -> bool:
        """Bring everything up to date with an exchange; False where too few digits would be left."""
        if swap.without is None:
            return False
        own = np.eye(len(self._blocks)) - self._blocks[:, :, swap.leaving]
        self._blocks = swap.without
        self._inverse = _with_term(self._inverse, self._rows[:, :, swap.leaving], _inverted(own))
        own = np.eye(len(self._blocks)) + self._blocks[:, :, swap.entering]
        self._blocks = self._blocks - _shared(self._seen_from(swap.entering), _inverted(own))
        self._inverse = _with_term(self._inverse, self._rows[:, :, swap.entering], -_inverted(own))
        self._chosen[[swap.leaving, swap.entering]] = False, True
        self.exchanges += 1
        return True

    def _without(self, leaving: int) -> FloatArray:
        """Return the blocks once a member has left, shape (rows, rows, N)."""
        own = np.eye(len(self._blocks)) - self._blocks[:, :, leaving]
        return self._blocks + _shared(self._seen_from(leaving), _inverted(own))

    def _seen_from(self, candidate: int) -> FloatArray:
        """Return the blocks G_ba of one candidate b with all candidates a, shape (rows, rows, N)."""
        own = self._rows[:, :, candidate].T @ self._inverse
        return np.asarray((own @ self._rows.reshape(len(self._rows), -1)).reshape(self._blocks.shape))

    def _gains_of_indispensable(self, leaving: int) -> FloatArray:
        """Return by what log det M grows where a member leaves that the others can hardly do without.

        For every a: log det(I + G_aa) + log det(I - G_bb + G_ba (I + G_aa)^-1 G_ab), shape (N,); as the head
        of the module says.
        """
        plus = np.moveaxis(_plus_one(self._blocks), 2, 0)
        seen = np.moveaxis(self._seen_from(leaving), 2, 0)
        left = np.eye(plus.shape[1]) - self._blocks[:, :, leaving]
        left = left + seen @ np.linalg.solve(plus, np.swapaxes(seen, 1, 2))
        return _log_det(_plus_one(self._blocks)) + _log_det(np.moveaxis(left, 0, 2))


def _inverted(matrix: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.inv(matrix), dtype=float)


def _plus_one(blocks: FloatArray) -> FloatArray:
    """Return I + G of blocks (rows, rows, N)."""
    return np.asarray(blocks + np.eye(len(blocks))[:, :, None])


def _products(first: FloatArray, second: FloatArray) -> FloatArray:
    """Sum over the first axis of products of (k, rows, N), symmetric in the rows, shape (rows, rows, N)."""
    rows, n = first.shape[1:]
    sums = np.empty((rows, rows, n))
    for i in range(rows):
        for j in range(i + 1):
            # Symmetric to the last digit, as the determinants by elimination take them to be.
            sums[i, j] = sums[j, i] = np.einsum("kn,kn->n", first[:, i], second[:, j])
    return sums


def _shared(seen: FloatArray, own: FloatArray) -> FloatArray:
    """Return G_ab K G_ba of all candidates a, from G_ba and K (rows, rows) of one, shape (rows, rows, N)."""
    return _products(seen, np.tensordot(own, seen, 1))


def _with_term(inverse: FloatArray, rows: FloatArray, own: FloatArray) -> FloatArray:
    """Return M^-1 after a candidate has come or gone: M^-1 + M^-1 J' K J M^-1.

    `rows` is J' (P, rows), `own` is K: (I - G_bb)^-1 of one that goes, -(I + G_bb)^-1 of one that comes
    (Woodbury).
    """
    reach = inverse @ rows
    return np.asarray(inverse + reach @ own @ reach.T)


def _log_det(matrices: FloatArray) -> FloatArray:
    """Logarithms of determinants of symmetric (rows, rows, N), -inf where one is not positive.

    By elimination, all N at once; a pivot that is not positive is of a member that M cannot do without.
    """
    left, total = matrices.copy(), np.zeros(matrices.shape[2])
    with np.errstate(divide="ignore", invalid="ignore"):  # no logarithm is asked of what is not positive
        for k in range(len(left)):
            pivot = left[k, k]
            total += np.where(pivot > 0.0, np.log(pivot), -np.inf)
            for i in range(k + 1, len(left)):
                left[i, k + 1 : i + 1] -= left[i, k] / pivot * left[k + 1 : i + 1, k]
    return np.where(np.isnan(total), -np.inf, total)
