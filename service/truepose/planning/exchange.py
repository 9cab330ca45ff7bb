"""Choice of configurations by exchange: the set of n candidates with the largest O1.

For a given n, O1 grows with det M, M = sum over the chosen candidates of J_i' J_i (D-optimality; thesis of
A. Nubiola, 2014, section 2.5.2; V. V. Fedorov, Theory of Optimal Experiments, 1972, chapter 3). With

    G_ab = J_a M^-1 J_b'     A_a = I + G_aa
    det(M - J_b'J_b) = det M det(I - G_bb)
    det(M - J_b'J_b + J_a'J_a) = det M det A_a det(I - G_bb + G_ba A_a^-1 G_ab)

all losses and gains follow from blocks as small as one candidate's Jacobian is high; M itself is inverted
once an exchange. The last line holds where M without b is singular, too: a set that is just large enough
can still change.

An exchange takes out the candidate whose loss lowers the index least and puts in the one that raises it most.
Where that brings nothing, the other members are tried in the order of their loss; it ends when no
single exchange helps.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.planning.errors import TooFewCandidatesError
from truepose.planning.observability import observability_o1

_SMALLEST_GAIN: Final = 1e-6  # of log det: far above its rounding, and O1 gains less than that relatively
_RIDGE: Final = 1e-9  # of the mean information per parameter: makes a rank-deficient start comparable


@dataclass(frozen=True, slots=True)
class Selection:
    """The chosen candidates."""

    indices: IntArray  # (n,) ascending
    o1: float  # 0 where the chosen ones leave a parameter undetermined
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

    Raises
    ------
    TooFewCandidatesError
        There are fewer than n candidates.
    ConfigurationError
        An argument has the wrong shape or is not finite.
    """
    _check_arguments(jacobians, n, start)
    chosen = np.zeros(len(jacobians), dtype=bool)
    chosen[rng.choice(len(jacobians), n, replace=False) if start is None else start] = True
    prior = _ridge(jacobians, n) if prior_information is None else prior_information
    exchanges = _exchange_until_it_stops(jacobians, chosen, prior)
    indices: IntArray = np.flatnonzero(chosen).astype(np.int64)
    return Selection(indices, _o1(jacobians[indices]), exchanges)


def rank_substitutes(jacobians: FloatArray, chosen: BoolArray, prior_information: FloatArray) -> IntArray:
    """Return the candidates that are not chosen, first the one that raises O1 of the chosen ones most.

    Parameters and errors as above; `chosen` is a mask of shape (n_candidates,).
    """
    state = _blocks(jacobians, chosen, prior_information)
    gains = np.where(chosen, -np.inf, _log_det(np.eye(state.rows) + state.blocks))
    ranked: IntArray = np.argsort(-gains, kind="stable")[: int(np.sum(~chosen))]
    return ranked


def _check_arguments(jacobians: FloatArray, n: int, start: IntArray | None) -> None:
    if jacobians.ndim != 3 or not np.all(np.isfinite(jacobians)):
        raise ConfigurationError("Jacobians come as (candidates, rows, parameters) with finite entries only.")
    if n < 1:
        raise ConfigurationError(f"{n} configurations were asked for; ask for at least one.")
    if len(jacobians) < n:
        raise TooFewCandidatesError(
            f"{n} configurations were asked for, and only {len(jacobians)} candidates are there."
        )
    if start is not None and (len(start) != n or len(np.unique(start)) != n):
        raise ConfigurationError(f"A start consists of {n} different candidates.")


def _ridge(jacobians: FloatArray, n: int) -> FloatArray:
    parameters = jacobians.shape[2]
    typical = n * float(np.mean(np.sum(jacobians**2, axis=(1, 2)))) / parameters
    ridge: FloatArray = _RIDGE * max(typical, 1e-100) * np.eye(parameters)
    return ridge


def _o1(chosen: FloatArray) -> float:
    rows = chosen.reshape(-1, chosen.shape[2])
    return observability_o1(rows, len(chosen)) if len(rows) >= rows.shape[1] else 0.0


def _exchange_until_it_stops(jacobians: FloatArray, chosen: BoolArray, prior: FloatArray) -> int:
    exchanges = 0
    while _exchange_once(_blocks(jacobians, chosen, prior), chosen):
        exchanges += 1
    return exchanges


def _exchange_once(state: "_Blocks", chosen: BoolArray) -> bool:
    """Make the first exchange that helps; whether there was one."""
    losses = np.where(chosen, _log_det(np.eye(state.rows) - state.blocks), -np.inf)
    plus = np.eye(state.rows) + state.blocks
    plus_inverse, plus_log_det = np.linalg.inv(plus), _log_det(plus)
    members_first = np.lexsort((-losses, ~chosen))  # those that can go most easily, then the others
    for leaving in members_first[: int(chosen.sum())]:
        seen = state.seen_from(int(leaving))
        left = np.eye(state.rows) - state.blocks[leaving] + np.swapaxes(seen, 1, 2) @ plus_inverse @ seen
        gains = np.where(chosen, -np.inf, plus_log_det + _log_det(left))
        entering = int(np.argmax(gains))
        if gains[entering] > _SMALLEST_GAIN:
            chosen[leaving], chosen[entering] = False, True
            return True
    return False


@dataclass(frozen=True, slots=True)
class _Blocks:
    """Inverse of M and the blocks G_i of all N candidates."""

    jacobians: FloatArray  # (N, rows, P)
    inverse: FloatArray  # (P, P)
    blocks: FloatArray  # (N, rows, rows)

    @property
    def rows(self) -> int:
        """Rows of each candidate's Jacobian."""
        return int(self.blocks.shape[1])

    def seen_from(self, candidate: int) -> FloatArray:
        """Return the blocks G_ab of all candidates a with one candidate b, shape (N, rows, rows)."""
        return _times(self.jacobians, self.inverse @ self.jacobians[candidate].T)


def _blocks(jacobians: FloatArray, chosen: BoolArray, prior: FloatArray) -> _Blocks:
    members = jacobians[chosen].reshape(-1, jacobians.shape[2])
    inverse: FloatArray = np.asarray(np.linalg.inv(members.T @ members + prior))
    return _Blocks(jacobians, inverse, np.einsum("nrp,nsp->nrs", _times(jacobians, inverse), jacobians))


def _times(stack: FloatArray, matrix: FloatArray) -> FloatArray:
    """Product of (N, r, p) with (p, q) as one flat product, several times faster than N small ones."""
    n, rows, _ = stack.shape
    product: FloatArray = (stack.reshape(n * rows, -1) @ matrix).reshape(n, rows, -1)
    return product


def _log_det(matrices: FloatArray) -> FloatArray:
    """Logarithms of determinants, -inf where one is not positive: a member that M cannot do without."""
    sign, log_det = np.linalg.slogdet(matrices)
    return np.where(sign > 0.0, log_det, -np.inf)
